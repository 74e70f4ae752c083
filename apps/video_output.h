// V4L2 devices that take pictures: loopback devices, whose pictures other programs read as a
// camera's.
#pragma once

#include <string>

#include "apps/descriptor.h"

namespace pleinair {

// Opens `device` for writing. Writes do not wait: they fail with EAGAIN.
//
// Throws     std::runtime_error, one line that begins with `name`: it cannot be opened, or is no
//            V4L2 device that takes pictures.
Descriptor OpenVideoOutput(const std::string& device, const std::string& name);

// Sets the pictures that the device takes: YUYV, limited range, BT.601, rows without padding. Its
// readers see the rate where the driver can state one.
//
// Throws     std::runtime_error, one line that begins with `name`: the device takes none of this
//            size.
void SetVideoOutput(const Descriptor& device,
                    const std::string& name,
                    int width_px,
                    int height_px,
                    double frames_per_second);

}  // namespace pleinair
