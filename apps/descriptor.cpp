#include "apps/descriptor.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>

namespace pleinair {

Descriptor::~Descriptor() {
  if (is_owned_ && number_ >= 0) close(number_);
}

Descriptor OpenForWriting(const std::string& path) {
  if (path == "-") return Descriptor(STDOUT_FILENO, false);
  const int number = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (number < 0) {
    throw std::runtime_error(
        path + ": expected a file or pipe that can be written: " + std::strerror(errno));
  }
  return Descriptor(number);
}

void WriteAll(const Descriptor& descriptor,
              std::span<const std::byte> bytes,
              const std::string& what) {
  // Once: a pipe without a reader else ends the process.
  [[maybe_unused]] static const auto ignored = std::signal(SIGPIPE, SIG_IGN);
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor.Number(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      throw std::runtime_error(what + ": " +
                               (errno == EPIPE ? "its reader is gone" : std::strerror(errno)));
    }
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

}  // namespace pleinair
