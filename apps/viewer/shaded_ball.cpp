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

std::vector<ShadedBall> BallsAt(const std::vector<VirtualObjectEntry>& objects,
                                const RgbImage& environment,
                                const Frame& frame,
                                const PictureDisplay& display) {
  std::vector<ShadedBall> balls;
  if (objects.empty()) return balls;
  const Rgba8Image picture = Shade(HarmonicsOf(environment), frame.camera, display, frame.exposure);
  for (const VirtualObjectEntry& object : objects) {
    ShadedBall ball;
    ball.centre_world_m = glm::dvec3(object.world_from_object[3]);
    ball.radius_m = kBallRadiusM;
    ball.picture = picture;
    balls.push_back(std::move(ball));
  }
  return balls;
}

}  // namespace pleinair
