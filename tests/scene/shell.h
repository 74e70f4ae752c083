// A shell command, run to its end: for tests of programs.
#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

namespace pleinair {

struct Ended {
  int exit_code = -1;  // -1: a signal ended it.
  std::string output;
};

inline Ended StandardOutputOf(const std::string& command) {
  Ended ended;
  FILE* const pipe = popen(command.c_str(), "r");
  std::array<char, 4096> part{};
  while (const std::size_t bytes = std::fread(part.data(), 1, part.size(), pipe)) {
    ended.output.append(part.data(), bytes);
  }
  const int status = pclose(pipe);
  ended.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return ended;
}

// With standard output and error together.
inline Ended Shell(const std::string& command) { return StandardOutputOf(command + " 2>&1"); }

}  // namespace pleinair
