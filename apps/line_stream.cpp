#include "apps/line_stream.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <span>
#include <stdexcept>
#include <utility>

namespace pleinair {
namespace {

constexpr const char* kSocketPrefix = "unix:";
constexpr std::size_t kMostReaders = 64;

[[noreturn]] void Refuse(const std::string& target, const std::string& why) {
  throw std::runtime_error(target + ": " + why);
}

sockaddr_un AddressOf(const std::string& target, const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) {
    Refuse(target,
           "expected a path of 1 to " + std::to_string(sizeof address.sun_path - 1) +
               " bytes for the socket");
  }
  std::memcpy(address.sun_path, path.data(), path.size());
  return address;
}

Descriptor NewSocket(const std::string& target) {
  const int number = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (number < 0) Refuse(target, std::strerror(errno));
  return Descriptor(number);
}

// A socket that another run still listens on is refused; one that is left over is removed.
void MakeWay(const std::string& target, const sockaddr_un& address) {
  struct stat there {};
  if (lstat(address.sun_path, &there) != 0) return;
  if (!S_ISSOCK(there.st_mode)) Refuse(target, "expected a socket or nothing, found a file");
  const Descriptor probe = NewSocket(target);
  const auto* name = reinterpret_cast<const sockaddr*>(&address);
  if (connect(probe.Number(), name, sizeof address) == 0 || errno == EAGAIN) {
    Refuse(target, "another program listens there");
  }
  if (errno != ECONNREFUSED) Refuse(target, std::strerror(errno));
  unlink(address.sun_path);
}

}  // namespace

LineStream::LineStream(const std::string& target, std::stop_token stop)
    : target_(target), stop_(std::move(stop)) {
  if (!target.starts_with(kSocketPrefix)) {
    file_ = OpenForWriting(target);
    return;
  }
  const std::string path = target.substr(std::strlen(kSocketPrefix));
  const sockaddr_un address = AddressOf(target, path);
  MakeWay(target, address);
  socket_ = NewSocket(target);
  constexpr int kWaitingReaders = 8;
  if (bind(socket_.Number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      listen(socket_.Number(), kWaitingReaders) != 0) {
    Refuse(target, std::strerror(errno));
  }
  socket_path_ = path;
}

LineStream::~LineStream() {
  std::error_code ignored;
  if (!socket_path_.empty()) std::filesystem::remove(socket_path_, ignored);
}

void LineStream::Write(const std::string& line) {
  const std::string text = line + '\n';
  if (socket_.Number() >= 0) {
    WriteToReaders(text);
  } else {
    if (!std::exchange(has_begun_, true)) Truncate(file_, target_);
    WriteAll(file_, std::as_bytes(std::span(text)), target_, stop_);
  }
}

void LineStream::WriteToReaders(const std::string& line) {
  for (;;) {
    const int number = accept4(socket_.Number(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (number < 0) break;
    Descriptor reader(number);
    if (readers_.size() < kMostReaders) readers_.push_back(std::move(reader));
  }
  // A line that does not fit into the reader's buffer completely would be torn: it is left.
  std::erase_if(readers_, [&](const Descriptor& reader) {
    const ssize_t sent =
        send(reader.Number(), line.data(), line.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    return sent != static_cast<ssize_t>(line.size());
  });
}

}  // namespace pleinair
