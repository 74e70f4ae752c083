// A sequence's pictures, in the one file that the stand-in's device plays from.
#pragma once

#include <optional>

#include "apps/camera_stand_in/device_state.h"
#include "datasets/sequence.h"

namespace pleinair::stand_in {

// Writes all frames of `sequence` in their own size, and resampled to `size` where that is given,
// to a file without a name, and fills the part of `state` that describes them. A frame without an
// 8-bit picture gets the sRGB codes of radiance x exposure. Returns the file's descriptor, which
// the caller closes.
//
// Throws  std::runtime_error naming the frame that cannot be read, or that has neither an 8-bit
//         picture nor an exposure, and where the file cannot be written.
int WritePicturesFile(const Sequence& sequence, std::optional<Size> size, DeviceState& state);

}  // namespace pleinair::stand_in
