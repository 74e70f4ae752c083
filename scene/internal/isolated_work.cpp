#include "scene/internal/isolated_work.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <new>
#include <string_view>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "scene/write_all.h"

namespace pleinair {
namespace {

// Exit codes of the child after it wrote all bytes: of the result, or of an exception's message.
enum Exit : int { kResult = 71, kMessage = 72, kOutOfMemory = 73, kCutOff = 74 };

std::uint64_t AddressSpaceBytes() {
  unsigned long long pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%llu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

void Limit(decltype(RLIMIT_AS) what, std::uint64_t value) {
  const rlimit limit{value, value + 1};
  setrlimit(what, &limit);
}

[[noreturn]] void WorkAsChild(const std::function<std::string()>& work,
                              const IsolationLimits& limits,
                              int out) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  // A crash is this child's own affair: no handler of the parent's reports it.
  for (const int crash : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU}) {
    std::signal(crash, SIG_DFL);
  }
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere >= 0) dup2(nowhere, STDERR_FILENO);
  Limit(RLIMIT_CORE, 0);
  Limit(RLIMIT_AS, AddressSpaceBytes() + limits.memory_bytes);
  Limit(RLIMIT_CPU, static_cast<std::uint64_t>(limits.time.count()));
  std::string bytes;
  Exit how = kResult;
  try {
    bytes = work();
  } catch (const std::bad_alloc&) {
    how = kOutOfMemory;
  } catch (const std::exception& error) {
    how = kMessage;
    bytes = error.what();
  }
  // Nothing of the parent's is destroyed or flushed here.
  _exit(WriteAll(out, bytes) ? how : kCutOff);
}

// Until the end of the stream. False where that takes longer than until `deadline`, or gives more
// than `most` bytes.
bool ReadUntil(std::chrono::steady_clock::time_point deadline,
               std::uint64_t most,
               int file,
               std::string& bytes) {
  static constexpr std::size_t kBlock = std::size_t{1} << 16;
  std::array<char, kBlock> block;
  while (bytes.size() <= most) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    pollfd ready{file, POLLIN, 0};
    if (poll(&ready, 1, static_cast<int>(left.count())) <= 0) continue;
    const ssize_t count = read(file, block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return true;
    bytes.append(block.data(), static_cast<std::size_t>(count));
  }
  return false;
}

}  // namespace

std::string RunIsolated(const std::function<std::string()>& work, const IsolationLimits& limits) {
  // No other call's child may inherit the end that this call's child writes to: the stream would
  // not end with that child.
  static std::mutex starting;
  std::array<int, 2> ends{};
  pid_t child = -1;
  {
    const std::lock_guard lock(starting);
    if (pipe2(ends.data(), O_CLOEXEC) != 0) {
      throw IsolationError(std::string("no pipe for its reader: ") + std::strerror(errno));
    }
    child = fork();
    if (child == 0) WorkAsChild(work, limits, ends[1]);
    const int error = errno;
    close(ends[1]);
    if (child < 0) {
      close(ends[0]);
      throw IsolationError(std::string("no process for its reader: ") + std::strerror(error));
    }
  }
  std::string bytes;
  bool within_limits = false;
  try {
    within_limits = ReadUntil(
        std::chrono::steady_clock::now() + 2 * limits.time, limits.memory_bytes, ends[0], bytes);
  } catch (const std::bad_alloc&) {
  }
  close(ends[0]);
  if (!within_limits) kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  const int how = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
  if (within_limits && how == kResult) return bytes;
  if (within_limits && how == kMessage) throw std::runtime_error(bytes);
  if (!within_limits || how == kOutOfMemory ||
      (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU)) {
    throw IsolationError("its reader needs more than " +
                         std::to_string(limits.memory_bytes >> 20U) + " MiB or " +
                         std::to_string(limits.time.count()) + " s");
  }
  throw IsolationError("its reader crashed");
}

}  // namespace pleinair
