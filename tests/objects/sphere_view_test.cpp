#include "objects/sphere_view.h"

#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "tests/relight/probe_test_scenes.h"

namespace pleinair::sphere_view_test {
namespace {

PatchScene Field() {
  Mesh mesh;
  AddGround(mesh, 1e4f);
  return SceneOf(std::move(mesh));
}

// Radiosity of its front faces.
std::vector<glm::vec3> GroundOf(const PatchScene& scene, const glm::vec3& radiosity) {
  std::vector<glm::vec3> faces(scene.FaceCount(), glm::vec3(0.0f));
  for (std::size_t face = 0; face < faces.size(); face += 2) faces[face] = radiosity;
  return faces;
}

TEST(SphereView, SeesSkyAboveAndGroundBelow) {
  const PatchScene field = Field();
  const std::vector<glm::vec3> places{{0.0f, 0.0f, 1.0f}, {3.0f, -2.0f, 0.5f}};
  const SphereView view(field, places, 511, 1);
  ASSERT_EQ(view.PlaceCount(), 2u);
  ASSERT_EQ(view.Directions().size(), 512u) << "rounded up to even";
  const auto sky = MakeUniformSkyShape();
  const glm::vec3 ground(0.4f, 0.3f, 0.2f);
  const std::vector<glm::vec3> radiance =
      view.Radiance(0, sky.get(), GroundOf(field, std::numbers::pi_v<float> * ground));
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    const glm::vec3& direction = view.Directions()[i];
    const glm::vec3 expected = direction.z > 0.0f ? sky->Radiance(direction) : ground;
    EXPECT_NEAR(radiance[i].y, expected.y, 1e-6) << i;
  }
  EXPECT_EQ(view.Radiance(1, sky.get(), GroundOf(field, std::numbers::pi_v<float> * ground)),
            radiance)
      << "what sees the same has the same bits";
}

TEST(SphereView, WithoutSkyAndSceneIsDark) {
  const SphereView view(Field(), std::vector<glm::vec3>{{0.0f, 0.0f, -1.0f}}, 64, 1);
  const std::vector<glm::vec3> lit(4, glm::vec3(1.0f));
  // From below the ground its back is seen, and nothing below the horizon.
  const std::vector<glm::vec3> radiance = view.Radiance(0, nullptr, lit);
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    EXPECT_EQ(radiance[i].x > 0.0f, view.Directions()[i].z > 0.0f);
  }
  const SphereView nowhere(SceneOf(Mesh()), std::vector<glm::vec3>{glm::vec3(0.0f)}, 64, 1);
  for (const glm::vec3& dark : nowhere.Radiance(0, nullptr, {})) EXPECT_EQ(dark, glm::vec3(0.0f));
  EXPECT_EQ(SphereView().PlaceCount(), 0u);
}

// A place that is not finite sees nothing of the scene: never NaN.
TEST(SphereView, RefusesWhatMakesNoSense) {
  const PatchScene field = Field();
  const std::vector<glm::vec3> places{glm::vec3(std::numeric_limits<float>::quiet_NaN())};
  EXPECT_THROW(SphereView(field, places, 0, 1), std::invalid_argument);
  const SphereView view(field, places, 16, 1);
  EXPECT_THROW(view.Radiance(0, nullptr, {}), std::invalid_argument);
  const std::vector<glm::vec3> lit(4, glm::vec3(1.0f));
  EXPECT_THROW(view.Radiance(1, nullptr, lit), std::invalid_argument);
  for (const glm::vec3& radiance : view.Radiance(0, nullptr, lit)) {
    EXPECT_EQ(radiance, glm::vec3(0.0f));
  }
}

}  // namespace
}  // namespace pleinair::sphere_view_test
