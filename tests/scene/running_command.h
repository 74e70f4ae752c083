// A shell command that runs beside a test: for what a signal does to it.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <optional>
#include <string>
#include <thread>

namespace pleinair {

class RunningCommand {
 public:
  // Becomes the shell's process: a signal reaches the command itself.
  explicit RunningCommand(const std::string& command) : process_(fork()) {
    if (process_ != 0) return;
    execl("/bin/sh", "sh", "-c", ("exec " + command).c_str(), nullptr);
    _exit(127);
  }
  ~RunningCommand() {
    if (process_ < 0 || status_) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  RunningCommand(const RunningCommand&) = delete;
  RunningCommand& operator=(const RunningCommand&) = delete;

  // Waits as long as the command runs, whatever the machine's speed. Returns whether `holds` did.
  template <typename Condition>
  bool RunsUntil(const Condition& holds) {
    while (!holds()) {
      int status = 0;
      if (process_ < 0 || waitpid(process_, &status, WNOHANG) != 0) {
        status_ = status;
        return false;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return true;
  }

  // Sends it and waits; returns the exit code, or -1 where the signal itself ended the command.
  int EndBy(int signal) {
    if (!status_) {
      kill(process_, signal);
      int status = -1;
      waitpid(process_, &status, 0);
      status_ = status;
    }
    return WIFEXITED(*status_) ? WEXITSTATUS(*status_) : -1;
  }

 private:
  pid_t process_;
  std::optional<int> status_;  // Once it has ended.
};

}  // namespace pleinair
