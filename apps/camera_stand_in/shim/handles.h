// The open handles of this process, and what connects it to the stand-in's program.
#pragma once

#include <memory>
#include <vector>

#include "apps/camera_stand_in/device_state.h"
#include "apps/camera_stand_in/shim/stream.h"

namespace pleinair::stand_in {

// Null where this process does not run under the stand-in.
DeviceState* SharedState();

// Holds the shared block, and this process' table of handles, for its scope. A process that died
// with it locked leaves a state that is good enough to go on with.
class StateLock {
 public:
  explicit StateLock(DeviceState& state);
  ~StateLock();
  StateLock(const StateLock&) = delete;
  StateLock& operator=(const StateLock&) = delete;

 private:
  DeviceState& state_;
};

// Lock-free, for calls that concern any descriptor.
bool MayBeHandle(int fd);
// Under the lock. Null: not ours.
std::shared_ptr<Handle> FindHandle(int fd);
void AddHandle(int fd, std::shared_ptr<Handle> handle);
void ForgetHandle(int fd);
std::vector<std::shared_ptr<Handle>> AllHandles();

// Another description of the shared block's file, for locks that end with the process; or -1.
int OpenSharedBlock();

}  // namespace pleinair::stand_in
