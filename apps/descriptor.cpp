#include "apps/descriptor.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "scene/write_all.h"

namespace pleinair {

Descriptor::~Descriptor() {
  if (is_owned_ && number_ >= 0) close(number_);
}

Descriptor OpenForWriting(const std::string& path) {
  if (path == "-") return Descriptor(STDOUT_FILENO, false);
  // A pipe without a reader would else wait for one for ever.
  constexpr int kTries = 100;
  constexpr std::chrono::milliseconds kBetween{100};
  for (int i = 0;; ++i) {
    const int number =
        open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NONBLOCK, 0666);
    if (number >= 0) {
      fcntl(number, F_SETFL, fcntl(number, F_GETFL) & ~O_NONBLOCK);
      return Descriptor(number);
    }
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

void WriteAll(const Descriptor& descriptor,
              std::span<const std::byte> bytes,
              const std::string& what) {
  // Once: a pipe without a reader else ends the process.
  [[maybe_unused]] static const auto ignored = std::signal(SIGPIPE, SIG_IGN);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (WriteAll(descriptor.Number(), text)) return;
  throw std::runtime_error(what + ": " +
                           (errno == EPIPE ? "its reader is gone" : std::strerror(errno)));
}

}  // namespace pleinair
