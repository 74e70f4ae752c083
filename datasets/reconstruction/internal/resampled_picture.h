// Pictures of one camera as another one would have taken them from the same place.
#pragma once

#include "scene/camera.h"
#include "scene/image.h"

namespace pleinair {

// Whether pictures of `to` can be made from those of `from`, except for 3 % at their borders.
// COLMAP may have adjusted one camera for each picture.
bool SeesAlike(const CameraIntrinsics& from, const CameraIntrinsics& to);

// The picture as `camera` would have taken it; the border is repeated where it ends.
// Throws std::runtime_error where the picture has not the shape of the camera that took it.
Rgb8Image SeenBy(const CameraIntrinsics& camera,
                 const Rgb8Image& picture,
                 const CameraIntrinsics& taken_by);

}  // namespace pleinair
