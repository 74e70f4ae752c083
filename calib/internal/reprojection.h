// Projection of moving points, for Ceres' automatic derivatives.
#pragma once

#include <array>
#include <limits>

#include <ceres/rotation.h>
#include <Eigen/Core>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "calib/fisheye_lens.h"
#include "calib/internal/distortion.h"
#include "scene/camera.h"

namespace pleinair {

// A rotation vector, then a translation.
using Motion = Eigen::Matrix<double, 6, 1>;

// exp(motion[0 .. 2]) point + motion[3 .. 5].
template <typename T>
std::array<T, 3> MovedPoint(const T* motion, const std::array<T, 3>& point) {
  std::array<T, 3> moved;
  ceres::AngleAxisRotatePoint(motion, point.data(), moved.data());
  for (std::size_t i = 0; i < 3; ++i) moved[i] += motion[3 + i];
  return moved;
}

// exp(motion.head<3>()) pose + motion.tail<3>().
inline glm::dmat4 MovedPose(const glm::dmat4& pose, const Motion& motion) {
  glm::dmat4 moved(1.0);
  for (int column = 0; column < 4; ++column) {
    const glm::dvec4& from = pose[column];
    std::array<double, 3> to{};
    ceres::AngleAxisRotatePoint(motion.data(), &from[0], to.data());
    moved[column] = glm::dvec4(to[0], to[1], to[2], from.w);
  }
  moved[3] += glm::dvec4(motion[3], motion[4], motion[5], 0.0);
  return moved;
}

// Where OpenCV's model puts a camera-frame point, less `pixel`; infinite, and false, where the
// point is not before the camera.
template <typename T>
bool PixelError(const CameraIntrinsics& camera,
                const std::array<T, 3>& point,
                const glm::dvec2& pixel,
                T* error) {
  if (!(point[2] > 0.0)) {
    error[0] = error[1] = T(std::numeric_limits<double>::infinity());
    return false;
  }
  const auto [x, y] =
      DistortedPoint<T>(camera.distortion, point[0] / point[2], point[1] / point[2]);
  error[0] = camera.fx_px * x + (camera.cx_px - pixel.x);
  error[1] = camera.fy_px * y + (camera.cy_px - pixel.y);
  return true;
}

// The same of OpenCV's fish-eye model, which sees points behind the camera, too.
template <typename T>
bool PixelError(const FisheyeIntrinsics& camera,
                const std::array<T, 3>& point,
                const glm::dvec2& pixel,
                T* error) {
  using std::atan2;
  using std::sqrt;
  // On the axis itself the root has no derivative: 1e-12 of the distance off it is no matter.
  const T across = sqrt(point[0] * point[0] + point[1] * point[1] + 1e-24 * point[2] * point[2]);
  const T angle = atan2(across, point[2]);
  const T s = angle * angle;
  const auto& [k1, k2, k3, k4] = camera.distortion;
  const T radius = angle * (1.0 + s * (k1 + s * (k2 + s * (k3 + s * k4))));
  error[0] = camera.fx_px * radius * point[0] / across + (camera.cx_px - pixel.x);
  error[1] = camera.fy_px * radius * point[1] / across + (camera.cy_px - pixel.y);
  return true;
}

}  // namespace pleinair
