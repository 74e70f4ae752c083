// The OpenGL context that a compositor is made in.
#pragma once

namespace pleinair {

// First member of its owner, so that it throws before any shader is compiled.
class CheckedContext {
 public:
  // Throws std::runtime_error where none is current, or it lacks something, naming it.
  CheckedContext();

  // Calls without a context would go nowhere, or end the program: throws std::runtime_error where
  // it is not current on this thread.
  void RequireCurrent() const;
  // Throws std::runtime_error after the device was reset or removed: it then draws nothing, and
  // reads back arbitrary data.
  void RequireNotLost() const;
  // Whether processors draw, and no graphics device.
  bool DrawsInSoftware() const { return draws_in_software_; }

 private:
  const void* made_in_;
  bool reports_loss_;
  bool draws_in_software_;
};

}  // namespace pleinair
