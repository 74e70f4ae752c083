// Lines to other programs while a run goes on.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "apps/descriptor.h"

namespace pleinair {

// To standard output, a file or pipe, or every program that is connected to a Unix socket.
class LineStream {
 public:
  // "-", a path, or "unix:PATH", a socket that is made (in place of one that nobody listens on) and
  // removed again. Keeps what is in a file. Throws std::runtime_error, one line with the target.
  explicit LineStream(const std::string& target, std::stop_token stop = {});
  ~LineStream();
  LineStream(const LineStream&) = delete;
  LineStream& operator=(const LineStream&) = delete;

  // The first line removes what was in a file. Throws where a file or pipe cannot be written, or is
  // not read within a second once `stop` is requested. A socket's readers that do not keep up, or
  // are gone, are disconnected, and so is a 65th.
  void Write(const std::string& line);

 private:
  void WriteToReaders(const std::string& line);

  std::string target_;
  std::stop_token stop_;
  Descriptor file_;
  bool has_begun_ = false;
  std::filesystem::path socket_path_;
  Descriptor socket_;
  std::vector<Descriptor> readers_;
};

}  // namespace pleinair
