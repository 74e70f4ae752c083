// A camera as plain data. For distortion and its inverse see calib/lens.h.
#pragma once

#include <array>

#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>

namespace pleinair {

// OpenCV's pinhole model; integer pixel coordinates are pixel centres.
struct CameraIntrinsics {
  int width_px = 0;
  int height_px = 0;
  double fx_px = 0.0;
  double fy_px = 0.0;
  double cx_px = 0.0;
  double cy_px = 0.0;
  std::array<double, 5> distortion{};  // k1, k2, p1, p2, k3 (OpenCV's order).

  bool HasDistortion() const { return distortion != std::array<double, 5>{}; }
  bool operator==(const CameraIntrinsics&) const = default;
};

// Lens and pose.
struct Camera {
  CameraIntrinsics intrinsics;
  glm::dmat4 camera_from_world{1.0};  // Rigid; camera x right, y down, z forward; metres.

  glm::dvec3 CentreWorldM() const { return glm::dvec3(glm::inverse(camera_from_world)[3]); }
  bool operator==(const Camera&) const = default;
};

}  // namespace pleinair
