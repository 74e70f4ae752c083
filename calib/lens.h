// OpenCV's pinhole model with its five-coefficient distortion, both ways.
#pragma once

#include <optional>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "scene/camera.h"

namespace pleinair {

// Image point of a camera-frame point; none behind the camera or beyond the radius where the
// distortion polynomial folds back (its stated validity).
std::optional<glm::dvec2> ProjectToPixel(const CameraIntrinsics& intrinsics,
                                         const glm::dvec3& point_camera);

// Unit camera-frame direction through an image point; none where no direction leads there.
std::optional<glm::dvec3> DirectionFromPixel(const CameraIntrinsics& intrinsics,
                                             const glm::dvec2& pixel);

// The smallest undistorted pinhole camera (same focal length) whose picture covers every direction
// that the distorted one sees, with one pixel of margin; the same camera where there is no
// distortion.
CameraIntrinsics UndistortedCover(const CameraIntrinsics& intrinsics);

}  // namespace pleinair
