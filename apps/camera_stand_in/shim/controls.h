// The stand-in's controls: a table, reading and writing, and what they do to the light.
#pragma once

#include <cstdint>

#include <linux/videodev2.h>

#include "apps/camera_stand_in/device_state.h"

namespace pleinair::stand_in {

// Each returns 0 or an errno.
int QueryControl(const DeviceState& state, v4l2_query_ext_ctrl& query);
int QueryMenu(v4l2_querymenu& query);
int GetControl(const DeviceState& state, v4l2_control& control);
// While the device streams, a written value reaches the picture `control_delay` frames later.
int SetControl(DeviceState& state, v4l2_control& control);
int GetControls(const DeviceState& state, v4l2_ext_controls& controls);
int SetControls(DeviceState& state, bool try_only, v4l2_ext_controls& controls);

void ResetControls(DeviceState& state);
// Takes over the gains that are due for the frame state.frame.
void AdvanceGains(DeviceState& state);

// The raw value of no light.
int BlackLevel(int bits);
int RawBits(std::uint32_t pixel_format);  // 0: not a raw format.

}  // namespace pleinair::stand_in
