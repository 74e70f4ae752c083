// OpenCV's pinhole model with its five-coefficient distortion, both ways.
//
// With x = X/Z, y = Y/Z, r^2 = x^2 + y^2 (the undistorted image plane at distance 1):
//   x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)
//   y' = y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y
//   u = fx x' + cx,  v = fy y' + cy
#pragma once

#include <optional>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "scene/camera.h"

namespace pleinair {

// Projection with its set-up done: for many points of one camera. Safe from any thread.
//
// Validity  points before the camera with r < ValidRadius() whose picture lies within 1e8 px of the
//           picture's origin (beyond, a double does not hold 1e-6 px). There the mapping is
//           one-to-one, and projecting a pixel's direction returns that pixel within 1e-6 px.
//           Outside of it both functions return none.
class Lens {
 public:
  // Throws std::invalid_argument naming the field and its value, for a size or focal length that is
  // not positive, or a value that is not finite.
  explicit Lens(const CameraIntrinsics& intrinsics);

  // Image point of a camera-frame point; none outside the validity.
  std::optional<glm::dvec2> ProjectToPixel(const glm::dvec3& point_camera) const;

  // Unit camera-frame direction through an image point; none where no valid direction leads there.
  std::optional<glm::dvec3> DirectionFromPixel(const glm::dvec2& pixel) const;

  // tan of the angle to the optical axis up to which the mapping is one-to-one for certain: within
  // it its Jacobian is positive definite. Infinite without distortion.
  double ValidRadius() const { return valid_radius_; }
  const CameraIntrinsics& Intrinsics() const { return intrinsics_; }

 private:
  CameraIntrinsics intrinsics_;
  double valid_radius_;
};

// The same for a single point; the last distorted camera's set-up is kept per thread.
std::optional<glm::dvec2> ProjectToPixel(const CameraIntrinsics& intrinsics,
                                         const glm::dvec3& point_camera);
std::optional<glm::dvec3> DirectionFromPixel(const CameraIntrinsics& intrinsics,
                                             const glm::dvec2& pixel);

// None also for points at or behind the camera's centre.
std::optional<glm::dvec2> ProjectToPixel(const Camera& camera, const glm::dvec3& point_world_m);

// Returns the smallest undistorted pinhole camera whose picture covers every direction of the
// distorted one, with one pixel of margin. It has the same focal length and a pixel grid aligned
// with the distorted one's principal point. Without distortion it is the same camera.
// Throws  std::invalid_argument where a side would exceed 16384 pixels: the picture's corners are
//         then nearly at a right angle to the axis, which no pinhole camera covers.
CameraIntrinsics UndistortedCover(const CameraIntrinsics& intrinsics);

}  // namespace pleinair
