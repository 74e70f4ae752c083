#include "relight/volume/environment_view.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/relight/probe_test_scenes.h"

namespace pleinair::environment_view_test {
namespace {

constexpr LatLongSize kSize{128, 64};
constexpr float kAlbedo = 0.5f;

// On a plane that faces `normal`, by the map's pixels.
glm::dvec3 IrradianceOf(const RgbImage& map, const glm::dvec3& normal) {
  glm::dvec3 sum(0.0);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const double cosine =
          glm::dot(DirectionFromLatLong({x + 0.5, y + 0.5}, {map.width, map.height}), normal);
      if (cosine > 0.0) {
        sum += cosine * LatLongPixelSolidAngleSr(y, {map.width, map.height}) *
               glm::dvec3(map.At(x, y));
      }
    }
  }
  return sum;
}

// Open ground of 200 m, seen from 1 m.
struct Ground {
  Ground() {
    Mesh mesh;
    AddGround(mesh, 100.0f);
    scene = SceneOf(std::move(mesh), glm::vec3(kAlbedo));
    view = EnvironmentView(scene, nullptr, {0.0f, 0.0f, 1.0f}, kSize);
    sky = MakeUniformSkyShape();
    for (std::size_t face = 0; face < scene.FaceCount(); ++face) {
      const bool is_top = scene.FaceNormal(face).z > 0.0f;
      of_sky.push_back(is_top ? glm::vec3(kAlbedo) : glm::vec3(0.0f));
      direct.push_back(is_top ? glm::vec3(float(to_sun.z)) : glm::vec3(0.0f));
      of_sun.push_back(kAlbedo * direct.back());
    }
  }
  std::vector<EnvironmentLight> Basis() const {
    return {{nullptr, of_sun, direct}, {sky.get(), of_sky, {}}};
  }
  Lighting Light(double sun, double sky_irradiance) const {
    Lighting lighting;
    lighting.sun = {to_sun, glm::dvec3(sun), 0.00465};
    lighting.sky = {{"uniform", glm::dvec3(sky_irradiance)}};
    return lighting;
  }
  glm::dvec3 to_sun = glm::normalize(glm::dvec3(1.0, 2.0, 1.5));
  PatchScene scene;
  EnvironmentView view;
  std::shared_ptr<const SkyShape> sky;
  std::vector<glm::vec3> of_sky;
  std::vector<glm::vec3> of_sun;
  std::vector<glm::vec3> direct;
};

// Upwards the map holds the sky's irradiance, downwards what open ground reflects of sky and sun.
// The ground ends 0.6 deg below the horizon: 1e-4 of it is missing.
TEST(EnvironmentView, HoldsTheLightOfOpenGround) {
  const Ground ground;
  const Lighting lighting = ground.Light(80.0, 20.0);
  const RgbImage map = ground.view.Radiance(lighting, ground.Basis());
  const double reflected = kAlbedo * (20.0 + 80.0 * ground.to_sun.z);
  EXPECT_NEAR(IrradianceOf(map, {0.0, 0.0, 1.0}).x, 20.0, 0.02);
  EXPECT_NEAR(IrradianceOf(map, {0.0, 0.0, -1.0}).y, reflected, 2e-3 * reflected);
}

// Whatever the map's size, the disc's pixels hold the sun's irradiance, towards the sun.
TEST(EnvironmentView, TheDiscHoldsTheSunsIrradiance) {
  const Ground ground;
  for (const LatLongSize size : {LatLongSize{16, 8}, kSize, LatLongSize{2048, 1024}}) {
    const EnvironmentView view(ground.scene, nullptr, {0.0f, 0.0f, 1.0f}, size);
    RgbImage map(size.width, size.height, glm::vec3(0.0f));
    view.AddSun(ground.Light(80.0, 0.0).sun, map);
    glm::dvec3 sum(0.0);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        sum += LatLongPixelSolidAngleSr(y, size) * glm::dvec3(map.At(x, y));
      }
    }
    EXPECT_NEAR(sum.x, 80.0, 1e-3) << size.width;  // A thousand sums in float.
  }
}

TEST(EnvironmentView, ASunAtTheZenithOrBehindAWallIsRight) {
  Mesh mesh;
  AddGround(mesh, 100.0f);
  AddBox(mesh, {-50.0f, 10.0f, 0.0f}, {50.0f, 11.0f, 50.0f});
  const PatchScene scene = SceneOf(std::move(mesh));
  const EnvironmentView view(scene, nullptr, {0.0f, 0.0f, 1.0f}, kSize);
  DirectionalLight sun{{0.0, 0.0, 1.0}, glm::dvec3(5.0), 0.00465};
  RgbImage map(kSize.width, kSize.height, glm::vec3(0.0f));
  view.AddSun(sun, map);
  EXPECT_NEAR(
      IrradianceOf(map, {0.0, 0.0, 1.0}).x, 5.0, 5.0 * 1e-3);  // Pixels' centres are off it.
  sun.direction_enu = glm::normalize(glm::dvec3(0.0, 1.0, 1.0));
  map.pixels.assign(map.pixels.size(), glm::vec3(0.0f));
  view.AddSun(sun, map);
  EXPECT_EQ(IrradianceOf(map, sun.direction_enu), glm::dvec3(0.0));
}

TEST(EnvironmentView, RefusesALightingOfOtherShapes) {
  const Ground ground;
  Lighting lighting = ground.Light(1.0, 1.0);
  lighting.sky.push_back(lighting.sky[0]);
  EXPECT_THROW(ground.view.Radiance(lighting, ground.Basis()), std::invalid_argument);
  EXPECT_THROW(EnvironmentView(ground.scene, nullptr, glm::vec3(0.0f), {0, 5}),
               std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::environment_view_test
