#include "apps/camera_stand_in/shim/handles.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <map>

namespace pleinair::stand_in {
namespace {

constexpr int kMaxFd = 65536;
std::array<std::atomic<bool>, kMaxFd> may_be_handle;

std::map<int, std::shared_ptr<Handle>>& Handles() {
  static auto* const handles = new std::map<int, std::shared_ptr<Handle>>;  // Outlives destructors.
  return *handles;
}

DeviceState* MapState() {
  const int fd = OpenSharedBlock();
  if (fd < 0) return nullptr;
  struct stat status {};
  void* block = MAP_FAILED;
  if (fstat(fd, &status) == 0 && status.st_size == static_cast<off_t>(sizeof(DeviceState))) {
    block = mmap(nullptr, sizeof(DeviceState), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  }
  syscall(SYS_close, fd);
  if (block == MAP_FAILED) return nullptr;
  auto* const state = static_cast<DeviceState*>(block);
  return state->magic == kStateMagic ? state : nullptr;
}

}  // namespace

int OpenSharedBlock() {
  const char* path = std::getenv(kStateVariable);
  if (path == nullptr) return -1;
  return static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, O_RDWR | O_CLOEXEC));
}

DeviceState* SharedState() {
  static DeviceState* const state = MapState();
  return state;
}

StateLock::StateLock(DeviceState& state) : state_(state) {
  if (pthread_mutex_lock(&state_.mutex) == EOWNERDEAD) pthread_mutex_consistent(&state_.mutex);
}
StateLock::~StateLock() { pthread_mutex_unlock(&state_.mutex); }

bool MayBeHandle(int fd) {
  return fd >= 0 && fd < kMaxFd &&
         may_be_handle[static_cast<std::size_t>(fd)].load(std::memory_order_acquire);
}

std::shared_ptr<Handle> FindHandle(int fd) {
  const auto found = Handles().find(fd);
  return found == Handles().end() ? nullptr : found->second;
}

void AddHandle(int fd, std::shared_ptr<Handle> handle) {
  if (fd < 0 || fd >= kMaxFd) return;
  Handles()[fd] = std::move(handle);
  may_be_handle[static_cast<std::size_t>(fd)].store(true, std::memory_order_release);
}

void ForgetHandle(int fd) {
  if (!MayBeHandle(fd)) return;
  may_be_handle[static_cast<std::size_t>(fd)].store(false, std::memory_order_release);
  Handles().erase(fd);
}

std::vector<std::shared_ptr<Handle>> AllHandles() {
  std::vector<std::shared_ptr<Handle>> all;
  for (const auto& [fd, handle] : Handles()) all.push_back(handle);
  return all;
}

}  // namespace pleinair::stand_in
