#include "apps/viewer/shaded_ball.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "calib/lens.h"
#include "scene/lat_long.h"
#include "scene/spherical_harmonics.h"

namespace pleinair {
namespace {

constexpr int kBallSidePx = 64;
constexpr double kBallRadiusM = 0.15;
constexpr float kWhiteAlbedo = 0.8f;

ShRgb HarmonicsOf(const RgbImage& environment) {
  ShRgb harmonics{};
  const LatLongSize size{environment.width, environment.height};
  for (int y = 0; y < size.height; ++y) {
    const double polar = std::numbers::pi / size.height;
    const double solid_angle =
        2.0 * std::numbers::pi / size.width * (std::cos(y * polar) - std::cos((y + 1) * polar));
    for (int x = 0; x < size.width; ++x) {
      const glm::vec3 direction(DirectionFromLatLong({x + 0.5, y + 0.5}, size));
      const auto basis = EvaluateShBasis9(direction);
      const glm::vec3 light = static_cast<float>(solid_angle) * environment.At(x, y);
      for (std::size_t i = 0; i < basis.size(); ++i) harmonics[i] += basis[i] * light;
    }
  }
  WindowSh(harmonics);
  return harmonics;
}

// As the camera would see it, standing upright in front of it.
Rgba8Image Shade(const ShRgb& light,
                 const Camera& camera,
                 const PictureDisplay& display,
                 std::optional<double> exposure) {
  const glm::dmat3 world_from_camera = glm::transpose(glm::dmat3(camera.camera_from_world));
  RgbImage radiance(kBallSidePx, kBallSidePx, glm::vec3(0.0f));
  Rgba8Image picture(kBallSidePx, kBallSidePx, kNoColour);
  for (int y = 0; y < kBallSidePx; ++y) {
    for (int x = 0; x < kBallSidePx; ++x) {
      const glm::dvec2 at = (glm::dvec2(x, y) + 0.5) * (2.0 / kBallSidePx) - 1.0;
      const double squared = glm::dot(at, at);
      if (squared > 1.0) continue;
      const glm::vec3 normal(world_from_camera * glm::dvec3(at.x, at.y, -std::sqrt(1.0 - squared)));
      radiance.At(x, y) =
          kWhiteAlbedo / std::numbers::pi_v<float> * IrradianceFromSh(light, normal);
    }
  }
  const Rgb8Image shown = display.Show(radiance, exposure);
  for (int y = 0; y < kBallSidePx; ++y) {
    for (int x = 0; x < kBallSidePx; ++x) {
      const glm::dvec2 at = (glm::dvec2(x, y) + 0.5) * (2.0 / kBallSidePx) - 1.0;
      if (glm::dot(at, at) <= 1.0) picture.At(x, y) = glm::u8vec4(shown.At(x, y), 255);
    }
  }
  return picture;
}

}  // namespace

ShadedBall BallIn(const RgbImage& environment,
                  const glm::dvec3& place_world_m,
                  const Frame& frame,
                  const PictureDisplay& display) {
  return {place_world_m,
          kBallRadiusM,
          Shade(HarmonicsOf(environment), frame.camera, display, frame.exposure)};
}

std::vector<ShadedBall> BallsOf(const IrradianceVolume& volume,
                                const Frame& frame,
                                const PictureDisplay& display) {
  std::vector<std::size_t> valid;
  for (std::size_t probe = 0; probe < volume.probes.size(); ++probe) {
    if (volume.valid[probe] != 0) valid.push_back(probe);
  }
  const std::size_t stride = (valid.size() + kMostBalls - 1) / kMostBalls;
  // Neighbours shall not touch.
  constexpr double kShareOfSpacing = 0.25;
  const glm::vec3& spacing_m = volume.grid.spacing_m;
  const double radius_m = std::min<double>(
      kBallRadiusM, kShareOfSpacing * std::min({spacing_m.x, spacing_m.y, spacing_m.z}));
  std::vector<ShadedBall> balls;
  for (std::size_t i = 0; i < valid.size(); i += stride) {
    balls.push_back({glm::dvec3(volume.grid.PositionM(valid[i])),
                     radius_m,
                     Shade(volume.probes[valid[i]], frame.camera, display, frame.exposure)});
  }
  return balls;
}

}  // namespace pleinair
