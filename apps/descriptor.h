// A file descriptor that is closed with its owner.
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <string>
#include <utility>

namespace pleinair {

class Descriptor {
 public:
  Descriptor() = default;
  // `is_owned`: false for those of the process, such as standard output's.
  explicit Descriptor(int number, bool is_owned = true) : number_(number), is_owned_(is_owned) {}
  ~Descriptor();
  Descriptor(Descriptor&& other) noexcept
      : number_(std::exchange(other.number_, -1)), is_owned_(other.is_owned_) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    std::swap(is_owned_, other.is_owned_);
    return *this;
  }

  int Number() const { return number_; }

 private:
  int number_ = -1;
  bool is_owned_ = true;
};

// Standard output for "-", else the file: a pipe, or one that is made. What is in it stays until
// it is written over, or truncated. Waits 10 s for a pipe's reader. A pipe's writes never wait.
// Throws std::runtime_error, one line with the path.
Descriptor OpenForWriting(const std::string& path);

// Removes what is in a file. Pipes, devices and standard output stay as they are. Throws
// std::runtime_error naming `what`.
void Truncate(const Descriptor& descriptor, const std::string& what);

// Writes all bytes, waiting for a pipe's reader; once `stop` is requested, for a second. Throws
// std::runtime_error naming `what`; a reader that is gone raises no signal.
void WriteAll(const Descriptor& descriptor,
              std::span<const std::byte> bytes,
              const std::string& what,
              const std::stop_token& stop = {});

}  // namespace pleinair
