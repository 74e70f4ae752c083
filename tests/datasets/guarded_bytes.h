// Bytes whose end is the end of readable memory: a read beyond them ends the test program.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <stdexcept>

namespace pleinair {

class GuardedBytes {
 public:
  explicit GuardedBytes(std::span<const std::byte> bytes) {
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    const std::size_t pages = (bytes.size() + page - 1) / page;
    mapped_ = (pages + 1) * page;
    void* memory =
        mmap(nullptr, mapped_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::runtime_error("no memory for guarded bytes");
    memory_ = static_cast<std::byte*>(memory);
    std::byte* guard = memory_ + pages * page;
    std::byte* first = guard - bytes.size();
    std::copy(bytes.begin(), bytes.end(), first);
    if (mprotect(guard, page, PROT_NONE) != 0) throw std::runtime_error("no guard page");
    bytes_ = {first, bytes.size()};
  }
  ~GuardedBytes() { munmap(memory_, mapped_); }
  GuardedBytes(const GuardedBytes&) = delete;
  GuardedBytes& operator=(const GuardedBytes&) = delete;

  std::span<const std::byte> Bytes() const { return bytes_; }

 private:
  std::byte* memory_ = nullptr;
  std::size_t mapped_ = 0;
  std::span<const std::byte> bytes_;
};

}  // namespace pleinair
