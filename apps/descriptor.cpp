#include "apps/descriptor.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <thread>

namespace pleinair {
namespace {

// A pipe is opened again: whether writes wait is else set for all programs that share it.
Descriptor StandardOutput() {
  struct stat output {};
  if (fstat(STDOUT_FILENO, &output) == 0 && S_ISFIFO(output.st_mode)) {
    const int number = open("/proc/self/fd/1", O_WRONLY | O_CLOEXEC | O_NONBLOCK);
    if (number >= 0) return Descriptor(number);
  }
  return Descriptor(STDOUT_FILENO, false);
}

}  // namespace

Descriptor::~Descriptor() {
  if (is_owned_ && number_ >= 0) close(number_);
}

Descriptor OpenForWriting(const std::string& path) {
  if (path == "-") return StandardOutput();
  // Without a limit a pipe would wait for a reader for ever.
  constexpr int kTries = 100;
  constexpr std::chrono::milliseconds kBetween{100};
  for (int i = 0;; ++i) {
    const int number = open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NONBLOCK, 0666);
    if (number >= 0) return Descriptor(number);
    if (errno == ENXIO && i < kTries) {
      std::this_thread::sleep_for(kBetween);
      continue;
    }
    throw std::runtime_error(path + (errno == ENXIO
                                         ? std::string(": expected a program that reads this pipe")
                                         : ": expected a file or pipe that can be written: " +
                                               std::string(std::strerror(errno))));
  }
}

void Truncate(const Descriptor& descriptor, const std::string& what) {
  struct stat found {};
  if (descriptor.Number() == STDOUT_FILENO || fstat(descriptor.Number(), &found) != 0 ||
      !S_ISREG(found.st_mode)) {
    return;
  }
  if (ftruncate(descriptor.Number(), 0) != 0) {
    throw std::runtime_error(what + ": cannot be truncated: " + std::strerror(errno));
  }
}

void WriteAll(const Descriptor& descriptor,
              std::span<const std::byte> bytes,
              const std::string& what,
              const std::stop_token& stop) {
  // Once a process: else a pipe whose reader is gone would end it.
  [[maybe_unused]] static const auto ignored = std::signal(SIGPIPE, SIG_IGN);
  constexpr std::chrono::milliseconds kTick{100};
  constexpr int kLastTicks = 10;
  int last_ticks = 0;
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor.Number(), bytes.data(), bytes.size());
    if (written > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(written));
      last_ticks = 0;
    } else if (errno == EAGAIN) {
      if (stop.stop_requested() && ++last_ticks > kLastTicks) {
        throw std::runtime_error(what + ": its reader does not read");
      }
      pollfd pipe{descriptor.Number(), POLLOUT, 0};
      poll(&pipe, 1, kTick.count());
    } else if (errno == ENODEV) {
      throw std::runtime_error(what + ": the device is gone");
    } else if (errno != EINTR) {
      throw std::runtime_error(what + ": " +
                               (errno == EPIPE ? "its reader is gone" : std::strerror(errno)));
    }
  }
}

}  // namespace pleinair
