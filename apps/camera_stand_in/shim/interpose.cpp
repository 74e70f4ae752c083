// The C library's functions that the stand-in answers in its place: those that name or hold the
// device, and those that read the wall clock. Everything else passes through.
//
// Waiting functions that take a wall-clock deadline (pthread_cond_timedwait on the default clock)
// are not among them: they count in the machine's own time.

#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/sysmacros.h>
#include <sys/time.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <memory>
#include <vector>

#include "apps/camera_stand_in/device_state.h"
#include "apps/camera_stand_in/shim/device_calls.h"
#include "apps/camera_stand_in/shim/handles.h"
#include "apps/camera_stand_in/shim/stream.h"

#define EXPORTED extern "C" __attribute__((visibility("default")))
// The function that would have been called without us, of the same type.
#define NEXT(name)                                                                             \
  ([] {                                                                                        \
    static const auto function = reinterpret_cast<decltype(&::name)>(dlsym(RTLD_NEXT, #name)); \
    return function;                                                                           \
  }())

namespace {

using pleinair::stand_in::CallDevice;
using pleinair::stand_in::DeviceState;
using pleinair::stand_in::FindHandle;
using pleinair::stand_in::ForgetHandle;
using pleinair::stand_in::Handle;
using pleinair::stand_in::kSecondNs;
using pleinair::stand_in::MayBeHandle;
using pleinair::stand_in::MonotonicNs;
using pleinair::stand_in::OpenDevice;
using pleinair::stand_in::Readiness;
using pleinair::stand_in::SharedState;
using pleinair::stand_in::StateLock;

constexpr int kVideoMajor = 81;

// Mapped early, so that no call has to do it in a signal handler.
__attribute__((constructor)) void Connect() { SharedState(); }

bool IsDevice(const char* path) {
  DeviceState* const state = SharedState();
  if (state == nullptr || path == nullptr || std::strncmp(path, "/dev/video", 10) != 0)
    return false;
  char* end = nullptr;
  const long number = std::strtol(path + 10, &end, 10);
  if (path[10] < '0' || path[10] > '9' || *end != '\0') return false;
  const StateLock lock(*state);
  return number == state->number;
}

// The mode that follows the flags of open() where they create a file.
mode_t ModeOf(int flags, std::va_list& arguments) {
  return (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE ? va_arg(arguments, mode_t) : 0;
}

#define READ_MODE(flags)                        \
  std::va_list arguments;                       \
  va_start(arguments, flags);                   \
  const mode_t mode = ModeOf(flags, arguments); \
  va_end(arguments)

void FillStatus(struct stat& status) {
  status = {};
  status.st_mode = S_IFCHR | 0660;
  status.st_nlink = 1;
  status.st_uid = geteuid();
  status.st_gid = getegid();
  status.st_blksize = 4096;
  status.st_rdev = makedev(kVideoMajor, static_cast<unsigned>(SharedState()->number));
}
// The same structure on 64-bit systems, under another name.
static_assert(sizeof(struct stat) == sizeof(struct stat64));
void FillStatus(struct stat64& status) { FillStatus(reinterpret_cast<struct stat&>(status)); }

// Without following what the link points to: the device's path is no link.
template <typename Status, typename Next>
int StatusOfPath(const char* path, Status* status, Next next) {
  if (!IsDevice(path)) return next();
  FillStatus(*status);
  return 0;
}

std::int64_t WallClockOffsetNs(const DeviceState& state) {
  return state.realtime_minus_monotonic_ns.load(std::memory_order_relaxed);
}

struct Watched {
  std::shared_ptr<Handle> handle;
  std::size_t entry = 0;
};

short ReportedEvents(Handle& handle, short wanted) {
  handle.Advance();
  switch (handle.Ready()) {
    case Readiness::kGone:
      return POLLERR | POLLHUP;
    case Readiness::kError:
      return POLLERR;
    case Readiness::kBuffer:
      return static_cast<short>(wanted & (POLLIN | POLLRDNORM));
    case Readiness::kNothing:
      break;
  }
  return 0;
}

// poll() for a set with handles in it: what is readable there is looked into.
int PollHandles(DeviceState& state,
                pollfd* fds,
                nfds_t count,
                const timespec* timeout,
                const sigset_t* signals) {
  const std::int64_t start = MonotonicNs();
  for (;;) {
    std::vector<pollfd> real(fds, fds + count);
    std::vector<Watched> watched;
    {
      const StateLock lock(state);
      for (std::size_t i = 0; i < count; ++i) {
        std::shared_ptr<Handle> handle = MayBeHandle(fds[i].fd) ? FindHandle(fds[i].fd) : nullptr;
        if (handle == nullptr) continue;
        handle->Advance();
        const Watched one{handle, i};
        real[i].events = POLLIN;  // Errors make it readable, too.
        if ((fds[i].events & POLLPRI) != 0) {
          real.push_back({handle->EventFd(), POLLIN, 0});
        }
        // A handle that asks for events alone must not be woken by pictures.
        if ((fds[i].events & (POLLIN | POLLRDNORM)) == 0 && handle->Ready() == Readiness::kBuffer) {
          real[i].fd = -1;
        }
        watched.push_back(one);
      }
    }
    timespec left{};
    if (timeout != nullptr) {
      const std::int64_t wanted = timeout->tv_sec * kSecondNs + timeout->tv_nsec;
      const std::int64_t left_ns = std::max<std::int64_t>(wanted - (MonotonicNs() - start), 0);
      left = {left_ns / kSecondNs, left_ns % kSecondNs};
    }
    const int ready = NEXT(ppoll)(real.data(), real.size(), timeout ? &left : nullptr, signals);
    if (ready < 0) return ready;
    for (std::size_t i = 0; i < count; ++i) fds[i].revents = real[i].revents;
    {
      const StateLock lock(state);
      for (const Watched& one : watched) {
        pollfd& fd = fds[one.entry];
        fd.revents = static_cast<short>((real[one.entry].revents & ~POLLIN) |
                                        ReportedEvents(*one.handle, fd.events));
        if ((fd.events & POLLPRI) != 0 && one.handle->HasEvent()) fd.revents |= POLLPRI;
      }
    }
    int reported = 0;
    for (std::size_t i = 0; i < count; ++i) reported += fds[i].revents != 0 ? 1 : 0;
    if (reported > 0 || ready == 0) return reported;
  }
}

bool HasHandle(const pollfd* fds, nfds_t count) {
  for (nfds_t i = 0; i < count; ++i) {
    if (MayBeHandle(fds[i].fd)) return true;
  }
  return false;
}

int Duplicated(int from, int to) {
  if (to < 0 || from == to || SharedState() == nullptr) return to;
  if (!MayBeHandle(from) && !MayBeHandle(to)) return to;
  const StateLock lock(*SharedState());
  ForgetHandle(to);
  if (std::shared_ptr<Handle> handle = FindHandle(from)) {
    pleinair::stand_in::AddHandle(to, std::move(handle));
  }
  return to;
}

}  // namespace

EXPORTED int open(const char* path, int flags, ...) {
  READ_MODE(flags);
  return IsDevice(path) ? OpenDevice(*SharedState(), flags) : NEXT(open)(path, flags, mode);
}
EXPORTED int open64(const char* path, int flags, ...) {
  READ_MODE(flags);
  return IsDevice(path) ? OpenDevice(*SharedState(), flags) : NEXT(open64)(path, flags, mode);
}
EXPORTED int openat(int folder, const char* path, int flags, ...) {
  READ_MODE(flags);
  return IsDevice(path) ? OpenDevice(*SharedState(), flags)
                        : NEXT(openat)(folder, path, flags, mode);
}
EXPORTED int openat64(int folder, const char* path, int flags, ...) {
  READ_MODE(flags);
  return IsDevice(path) ? OpenDevice(*SharedState(), flags)
                        : NEXT(openat64)(folder, path, flags, mode);
}
// What the above become where the C library checks arguments (_FORTIFY_SOURCE).
EXPORTED int __open_2(const char* path, int flags) { return open(path, flags); }
EXPORTED int __open64_2(const char* path, int flags) { return open64(path, flags); }
EXPORTED int __openat_2(int folder, const char* path, int flags) {
  return openat(folder, path, flags);
}
EXPORTED int __openat64_2(int folder, const char* path, int flags) {
  return openat64(folder, path, flags);
}

EXPORTED int ioctl(int fd, unsigned long request, ...) noexcept {
  std::va_list arguments;
  va_start(arguments, request);
  void* const argument = va_arg(arguments, void*);
  va_end(arguments);
  return MayBeHandle(fd) ? CallDevice(*SharedState(), fd, request, argument)
                         : NEXT(ioctl)(fd, request, argument);
}

EXPORTED int close(int fd) {
  if (MayBeHandle(fd)) {
    const StateLock lock(*SharedState());
    ForgetHandle(fd);
  }
  return NEXT(close)(fd);
}

EXPORTED int dup(int fd) noexcept { return Duplicated(fd, NEXT(dup)(fd)); }
EXPORTED int dup2(int from, int to) noexcept { return Duplicated(from, NEXT(dup2)(from, to)); }
EXPORTED int dup3(int from, int to, int flags) noexcept {
  return Duplicated(from, NEXT(dup3)(from, to, flags));
}

EXPORTED void* mmap(
    void* address, size_t length, int protection, int flags, int fd, off_t offset) noexcept {
  if ((flags & MAP_ANONYMOUS) == 0 && MayBeHandle(fd)) {
    const StateLock lock(*SharedState());
    if (const std::shared_ptr<Handle> handle = FindHandle(fd)) fd = handle->BuffersFd();
    if (fd < 0) {
      errno = EINVAL;
      return MAP_FAILED;
    }
  }
  // By itself and not through dlsym, which may need memory.
  return reinterpret_cast<void*>(syscall(SYS_mmap, address, length, protection, flags, fd, offset));
}
EXPORTED void* mmap64(
    void* address, size_t length, int protection, int flags, int fd, off64_t offset) noexcept {
  return mmap(address, length, protection, flags, fd, offset);
}

EXPORTED int ppoll(pollfd* fds, nfds_t count, const timespec* timeout, const sigset_t* signals) {
  if (!HasHandle(fds, count)) return NEXT(ppoll)(fds, count, timeout, signals);
  return PollHandles(*SharedState(), fds, count, timeout, signals);
}
EXPORTED int poll(pollfd* fds, nfds_t count, int timeout_ms) {
  if (!HasHandle(fds, count)) return NEXT(poll)(fds, count, timeout_ms);
  const timespec timeout{timeout_ms / 1000, timeout_ms % 1000 * 1'000'000};
  return PollHandles(*SharedState(), fds, count, timeout_ms < 0 ? nullptr : &timeout, nullptr);
}
EXPORTED int __poll_chk(pollfd* fds, nfds_t count, int timeout_ms, size_t) {
  return poll(fds, count, timeout_ms);
}
EXPORTED int __ppoll_chk(
    pollfd* fds, nfds_t count, const timespec* timeout, const sigset_t* signals, size_t) {
  return ppoll(fds, count, timeout, signals);
}

EXPORTED int stat(const char* path, struct stat* status) noexcept {
  return StatusOfPath(path, status, [&] { return NEXT(stat)(path, status); });
}
EXPORTED int stat64(const char* path, struct stat64* status) noexcept {
  return StatusOfPath(path, status, [&] { return NEXT(stat64)(path, status); });
}
EXPORTED int lstat(const char* path, struct stat* status) noexcept {
  return StatusOfPath(path, status, [&] { return NEXT(lstat)(path, status); });
}
EXPORTED int lstat64(const char* path, struct stat64* status) noexcept {
  return StatusOfPath(path, status, [&] { return NEXT(lstat64)(path, status); });
}
EXPORTED int fstatat(int folder, const char* path, struct stat* status, int flags) noexcept {
  return StatusOfPath(path, status, [&] { return NEXT(fstatat)(folder, path, status, flags); });
}
EXPORTED int fstatat64(int folder, const char* path, struct stat64* status, int flags) noexcept {
  return StatusOfPath(path, status, [&] { return NEXT(fstatat64)(folder, path, status, flags); });
}
EXPORTED int fstat(int fd, struct stat* status) noexcept {
  if (!MayBeHandle(fd)) return NEXT(fstat)(fd, status);
  FillStatus(*status);
  return 0;
}
EXPORTED int fstat64(int fd, struct stat64* status) noexcept {
  if (!MayBeHandle(fd)) return NEXT(fstat64)(fd, status);
  FillStatus(*status);
  return 0;
}
EXPORTED int statx(
    int folder, const char* path, int flags, unsigned mask, struct statx* status) noexcept {
  const bool is_handle = *path == '\0' && MayBeHandle(folder);
  if (!is_handle && !IsDevice(path)) return NEXT(statx)(folder, path, flags, mask, status);
  struct stat plain {};
  FillStatus(plain);
  *status = {};
  status->stx_mask = STATX_BASIC_STATS;
  status->stx_mode = static_cast<std::uint16_t>(plain.st_mode);
  status->stx_nlink = 1;
  status->stx_uid = plain.st_uid;
  status->stx_gid = plain.st_gid;
  status->stx_blksize = 4096;
  status->stx_rdev_major = major(plain.st_rdev);
  status->stx_rdev_minor = minor(plain.st_rdev);
  return 0;
}
EXPORTED int access(const char* path, int mode) noexcept {
  if (!IsDevice(path)) return NEXT(access)(path, mode);
  return (mode & X_OK) != 0 ? (errno = EACCES, -1) : 0;
}
EXPORTED int faccessat(int folder, const char* path, int mode, int flags) noexcept {
  return IsDevice(path) ? access(path, mode) : NEXT(faccessat)(folder, path, mode, flags);
}

EXPORTED int clock_gettime(clockid_t clock, timespec* time) noexcept {
  const DeviceState* const state = SharedState();
  const bool is_wall = clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE;
  if (!is_wall || state == nullptr) return NEXT(clock_gettime)(clock, time);
  const int result = NEXT(clock_gettime)(CLOCK_MONOTONIC, time);
  const std::int64_t now = time->tv_sec * kSecondNs + time->tv_nsec + WallClockOffsetNs(*state);
  *time = {now / kSecondNs, now % kSecondNs};
  return result;
}
EXPORTED int gettimeofday(timeval* time, void* zone) noexcept {
  if (SharedState() == nullptr) return NEXT(gettimeofday)(time, zone);
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  *time = {now.tv_sec, now.tv_nsec / 1000};
  return 0;
}
EXPORTED time_t time(time_t* seconds) noexcept {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  if (seconds != nullptr) *seconds = now.tv_sec;
  return now.tv_sec;
}
