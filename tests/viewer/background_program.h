// A program that runs beside its test.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

namespace pleinair {

// Asks until `holds`; false after a time that only a fault needs, or a shorter one, where it is
// tried again.
inline bool Await(const std::function<bool()>& holds, double most_s = 60.0) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(most_s);
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) return false;
    // Each check may start a program, which takes processor time from the one under test.
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return true;
}

class BackgroundProgram {
 public:
  // A shell command of one program.
  explicit BackgroundProgram(const std::string& command) {
    const std::string shell = "exec " + command;
    pid_ = fork();
    if (pid_ < 0) throw std::runtime_error(command + ": not started");
    if (pid_ == 0) {
      execl("/bin/sh", "sh", "-c", shell.c_str(), nullptr);
      _exit(127);
    }
  }
  // Ended where it has not yet.
  ~BackgroundProgram() {
    if (HasEnded()) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  BackgroundProgram(const BackgroundProgram&) = delete;
  BackgroundProgram& operator=(const BackgroundProgram&) = delete;

  bool HasEnded() {
    int status = 0;
    if (!exit_code_ && waitpid(pid_, &status, WNOHANG) == pid_) {
      exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    return exit_code_.has_value();
  }
  // Waits for its end. -1: a signal ended it; none: it goes on.
  std::optional<int> ExitCode() {
    Await([this] { return HasEnded(); });
    return exit_code_;
  }
  void Terminate() { kill(pid_, SIGTERM); }

 private:
  pid_t pid_ = -1;
  std::optional<int> exit_code_;
};

}  // namespace pleinair
