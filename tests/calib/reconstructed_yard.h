// A yard as a reconstruction of it would be: ground, a wall with a gateway, a wall behind it, and a
// wall to the right.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/lens.h"
#include "calib/reconstruction/reconstruction.h"
#include "sunmodel/angles.h"

namespace pleinair::reconstructed_yard {

// Metres, +Z up.
inline constexpr double kFacadeY = 20.0;
inline constexpr double kBehindY = 26.0;
inline constexpr double kRightX = 10.0;
inline constexpr double kGateHalfWidth = 3.0;
inline constexpr double kGateHeight = 5.0;
inline constexpr double kCameraHeight = 1.6;

struct Options {
  double noise_m = 0.02;
  double wrong_share = 0.1;  // Of points anywhere.
  bool has_ground = true;
  double pitch_rad = RadFromDeg(12.0);  // Upwards.
  unsigned seed = 1;
};

inline CameraIntrinsics YardCamera() {
  CameraIntrinsics camera;
  camera.width_px = 1200;
  camera.height_px = 900;
  camera.fx_px = camera.fy_px = 800.0;
  camera.cx_px = 599.5;
  camera.cy_px = 449.5;
  return camera;
}

// Looks along +Y, turned to the right and upwards.
inline glm::dmat4 CameraAt(const glm::dvec3& centre, double right_rad, double up_rad) {
  const glm::dvec3 forward(std::sin(right_rad) * std::cos(up_rad),
                           std::cos(right_rad) * std::cos(up_rad),
                           std::sin(up_rad));
  const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0.0, 0.0, 1.0)));
  const glm::dmat3 world_from_camera(right, glm::cross(forward, right), forward);
  glm::dmat4 pose = glm::dmat4(glm::transpose(world_from_camera));
  pose[3] = glm::dvec4(-(glm::transpose(world_from_camera) * centre), 1.0);
  return pose;
}

inline bool IsVisible(const glm::dvec3& from, const glm::dvec3& to) {
  if (to.y <= kFacadeY + 1.0) return true;
  const double t = (kFacadeY - from.y) / (to.y - from.y);
  const glm::dvec3 at = from + t * (to - from);
  return std::abs(at.x) < kGateHalfWidth && at.z < kGateHeight;
}

inline Reconstruction MakeYard(const Options& options = {}) {
  std::mt19937 random(options.seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, options.noise_m);
  Reconstruction yard;
  yard.cameras.push_back({"1", YardCamera()});
  const auto between = [&](double a, double b) { return a + (b - a) * unit(random); };
  const auto add = [&](glm::dvec3 p, const glm::dvec3& colour) {
    p += glm::dvec3(noise(random), noise(random), noise(random));
    yard.points.push_back({static_cast<std::int64_t>(yard.points.size()) + 1, p, colour});
  };
  const glm::dvec3 grey(0.6, 0.6, 0.6);
  for (int i = 0; i < 900; ++i) {
    const glm::dvec3 p(between(-10.0, kRightX), kFacadeY, between(0.0, 8.0));
    if (std::abs(p.x) > kGateHalfWidth || p.z > kGateHeight) add(p, {0.7, 0.6, 0.5});
  }
  for (int i = 0; i < 400; ++i) add({kRightX, between(6.0, kFacadeY), between(0.0, 6.0)}, grey);
  for (int i = 0; i < 400; ++i) add({between(-6.0, 6.0), kBehindY, between(0.0, 6.0)}, grey);
  for (int i = 0; i < (options.has_ground ? 500 : 0); ++i) {
    add({between(-10.0, kRightX), between(4.0, kFacadeY), 0.0}, grey);
  }
  const auto wrong =
      static_cast<int>(options.wrong_share * static_cast<double>(yard.points.size()));
  for (int i = 0; i < wrong; ++i) {
    add({between(-10.0, kRightX), between(8.0, kFacadeY), between(0.2, 8.0)}, grey);
  }

  const Lens lens(YardCamera());
  constexpr int kPictures = 6;
  for (int p = 0; p < kPictures; ++p) {
    const glm::dvec3 centre(-6.0 + 2.4 * p, -8.0 + 1.5 * (p % 3), kCameraHeight);
    ReconstructedPicture picture;
    picture.name = std::to_string(p) + ".jpg";
    picture.camera_from_model = CameraAt(centre, RadFromDeg(12.0 - 5.0 * p), options.pitch_rad);
    for (std::uint32_t i = 0; i < yard.points.size(); ++i) {
      const glm::dvec3& point = yard.points[i].position;
      const auto pixel =
          lens.ProjectToPixel(glm::dvec3(picture.camera_from_model * glm::dvec4(point, 1.0)));
      if (!pixel || !IsVisible(centre, point) || pixel->x < 0.0 || pixel->y < 0.0 ||
          pixel->x > 1199.0 || pixel->y > 899.0) {
        continue;
      }
      picture.observations.push_back({i, *pixel});
    }
    yard.pictures.push_back(std::move(picture));
  }
  return yard;
}

}  // namespace pleinair::reconstructed_yard
