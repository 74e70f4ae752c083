// The indirect light of a rendered room (Blender Cycles) against PointIrradiance with that room's
// own light: the fish-eye picture is its sky, and the truth's sun its sun. What a source makes of
// the picture is the source's business and not looked at here.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "relight/point_irradiance.h"
#include "scene/image_io.h"
#include "scene/lighting.h"
#include "scene/mesh_io.h"

namespace pleinair::room_window_irradiance_test {
namespace {

const std::filesystem::path kRoom =
    std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences/room-window";

nlohmann::json Read(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return nlohmann::json::parse(stream);
}

glm::dvec3 Vector(const nlohmann::json& json) { return {json.at(0), json.at(1), json.at(2)}; }

std::vector<glm::vec3> Vectors(const nlohmann::json& json) {
  std::vector<glm::vec3> vectors;
  for (const nlohmann::json& v : json) vectors.emplace_back(Vector(v));
  return vectors;
}

// The picture's pixel that a direction falls into, by the formula in sequence.json: equidistant,
// north up, east right, 90 deg at the circle.
glm::ivec2 FisheyePixel(const glm::dvec3& direction, int size_px) {
  const double zenith_angle = std::atan2(std::hypot(direction.x, direction.y), direction.z);
  const double radius = zenith_angle / (0.5 * std::numbers::pi);
  const double azimuth = std::atan2(direction.x, direction.y);
  const double x = radius * std::sin(azimuth);
  const double y = radius * std::cos(azimuth);
  const auto pixel = [size_px](double position) {
    return std::clamp(static_cast<int>(0.5 * (position + 1.0) * size_px), 0, size_px - 1);
  };
  return {pixel(x), pixel(-y)};
}

// The sky around the disc goes on under it. 1 deg: the disc's radius, half the diagonal of a pixel
// (0.35 deg) and its blur.
void CutTheSunOut(RgbImage& picture, const glm::dvec3& sun) {
  const glm::ivec2 at = FisheyePixel(sun, picture.width);
  const int radius_px = 3;
  glm::dvec3 ring(0.0);
  int count = 0;
  for (int y = -radius_px - 2; y <= radius_px + 2; ++y) {
    for (int x = -radius_px - 2; x <= radius_px + 2; ++x) {
      if (std::max(std::abs(x), std::abs(y)) <= radius_px) continue;
      ring += glm::dvec3(picture.At(at.x + x, at.y + y));
      ++count;
    }
  }
  for (int y = -radius_px; y <= radius_px; ++y) {
    for (int x = -radius_px; x <= radius_px; ++x) {
      picture.At(at.x + x, at.y + y) = glm::vec3(ring / static_cast<double>(count));
    }
  }
}

struct Score {
  double rms = 0.0;
  double sum = 0.0;
};

Score ScoreOf(const std::vector<glm::vec3>& indirect, const nlohmann::json& truth) {
  double error2 = 0.0;
  double truth2 = 0.0;
  double sum = 0.0;
  double truth_sum = 0.0;
  std::size_t i = 0;
  for (const nlohmann::json& of_point : truth) {
    for (const nlohmann::json& of_normal : of_point) {
      const glm::dvec3 expected = Vector(of_normal);
      const glm::dvec3 got(indirect.at(i++));
      error2 += glm::dot(got - expected, got - expected);
      truth2 += glm::dot(expected, expected);
      sum += got.x + got.y + got.z;
      truth_sum += expected.x + expected.y + expected.z;
    }
  }
  return {std::sqrt(error2 / truth2), sum / truth_sum - 1.0};
}

// 4 % and 2 %: the truth's own noise (0.8 %), the fish-eye picture's pixels, patches of even light.
TEST(PointIrradiance, GivesTheIndirectLightOfARenderedRoom) {
  if (!std::filesystem::exists(kRoom)) GTEST_SKIP() << "needs the shared sequences: " << kRoom;
  const nlohmann::json truth = Read(kRoom / "truth/irradiance.json");
  const nlohmann::json light = Read(kRoom / "truth/truth.json");
  const nlohmann::json sequence = Read(kRoom / "sequence.json");
  PointIrradianceOptions options;
  options.patch_size_m = 0.3;
  options.rays_per_point = 1024;
  options.sky_rays_per_patch = 1024;
  options.rays_per_patch = 256;
  PointIrradiance room(LoadMesh(kRoom / "scene.obj").mesh,
                       {Vectors(truth.at("points")), Vectors(truth.at("normals"))},
                       options,
                       {});
  for (const nlohmann::json& set : truth.at("sets")) {
    const std::size_t frame = set.at("frame");
    const nlohmann::json& of_frame = light.at("frames").at(frame);
    const glm::dvec3 sun = Vector(of_frame.at("sun_direction_enu"));
    RgbImage sky =
        ReadRadianceImage(kRoom / sequence.at("frames").at(frame).at("fisheye").get<std::string>());
    CutTheSunOut(sky, sun);
    const auto radiance = [&](const glm::vec3& direction) {
      const glm::ivec2 pixel = FisheyePixel(glm::dvec3(direction), sky.width);
      return sky.At(pixel.x, pixel.y);
    };
    std::vector<glm::vec3> indirect = room.OfSky(radiance, LightPart::kIndirect);
    const std::vector<glm::vec3> of_sun =
        room.OfSun(sun, kMeanSunAngularRadiusRad, LightPart::kIndirect);
    const glm::vec3 beam(Vector(of_frame.at("sun_irradiance_rgb")));
    for (std::size_t i = 0; i < indirect.size(); ++i) indirect[i] += beam * of_sun[i];
    const Score score = ScoreOf(indirect, set.at("indirect"));
    EXPECT_LE(score.rms, 0.04) << "frame " << frame;
    EXPECT_LE(std::abs(score.sum), 0.02) << "frame " << frame << ": " << score.sum;
    RecordProperty("rms_of_frame_" + std::to_string(frame), std::to_string(score.rms));
  }
}

}  // namespace
}  // namespace pleinair::room_window_irradiance_test
