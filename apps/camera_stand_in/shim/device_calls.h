// What the device answers to open() and ioctl().
#pragma once

namespace pleinair::stand_in {

struct DeviceState;

// A new descriptor, or -1 with errno set.
int OpenDevice(DeviceState& state, int flags);
// As ioctl: 0, or -1 with errno set. `fd` is a handle's.
int CallDevice(DeviceState& state, int fd, unsigned long request, void* argument);

}  // namespace pleinair::stand_in
