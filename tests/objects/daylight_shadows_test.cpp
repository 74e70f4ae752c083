#include "objects/daylight_shadows.h"

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/relight/window_rooms.h"

namespace pleinair::daylight_shadows_test {
namespace {

using ::testing::HasSubstr;

const DaylightSample kSlanting{glm::normalize(glm::vec3(1.0f, 0.0f, 1.0f)), {2.0f, 4.0f, 6.0f}};

Mesh BoxObject(const glm::vec3& lower, const glm::vec3& upper) {
  Mesh mesh;
  mesh.materials.resize(1);
  mesh.group_names = {"object"};
  AddBox(mesh, lower, upper);
  return mesh;
}

// A box 1 m above the ground, in light from the east at 45 deg: its shadow lies 1 m to the west.
TEST(DaylightShadows, HidesTheSampleInTheObjectsShadowAlone) {
  const RayCaster real{Mesh{}};
  const Mesh object = BoxObject({0.0f, 0.0f, 1.0f}, {1.0f, 1.0f, 1.1f});
  const RayCaster objects(object);
  DaylightShadows shadows(real, objects, BoundingSphereOf(object.positions_m));
  shadows.SetSamples(std::array{kSlanting});
  const glm::vec3 up(0.0f, 0.0f, 1.0f);
  const std::vector<Receiver> receivers{{{-0.5f, 0.5f, 0.0f}, up},    // In the middle of it.
                                        {{0.5f, 0.5f, 0.0f}, up},     // Below the box.
                                        {{-1.5f, 0.5f, 0.0f}, up},    // Beyond.
                                        {{2.5f, 0.5f, 2.0f}, up},     // Towards the light.
                                        {{-0.5f, 0.5f, 0.0f}, -up}};  // Turned away.
  const std::vector<glm::vec3> hidden = shadows.HiddenFrom(receivers);
  const float cosine = std::sqrt(0.5f);
  EXPECT_NEAR(hidden[0].x, 2.0f * cosine, 1e-6f);
  EXPECT_NEAR(hidden[0].z, 6.0f * cosine, 1e-6f);
  for (std::size_t i = 1; i < hidden.size(); ++i) EXPECT_EQ(hidden[i], glm::vec3(0.0f)) << i;
}

// What is in a real roof's shadow has nothing to lose.
TEST(DaylightShadows, DarkensNothingTwice) {
  Mesh roof;
  roof.materials.resize(1);
  roof.group_names = {"roof"};
  AddGround(roof, 20.0f, 5.0f);
  const RayCaster real(roof);
  const Mesh object = BoxObject({0.0f, 0.0f, 1.0f}, {1.0f, 1.0f, 1.1f});
  const RayCaster objects(object);
  DaylightShadows shadows(real, objects, BoundingSphereOf(object.positions_m));
  shadows.SetSamples(std::array{kSlanting});
  const std::vector<Receiver> receivers{{{-0.5f, 0.5f, 0.0f}, {0.0f, 0.0f, 1.0f}}};
  EXPECT_EQ(shadows.HiddenFrom(receivers)[0], glm::vec3(0.0f));
}

// Faces of a box in the open under a uniform sky of radiance 1: pi (1 + n.z) / 2. One of 4096
// samples more or less on the horizon, and their spread: 1 %.
TEST(DaylightShadows, GivesAnUnoccludedFaceItsShareOfTheSky) {
  const RayCaster real{Mesh{}};
  const Mesh object = BoxObject({-0.5f, -0.5f, 0.0f}, {0.5f, 0.5f, 1.0f});
  const RayCaster objects(object);
  const BoundingSphere sphere = BoundingSphereOf(object.positions_m);
  const DaylightSampler sampler(
      {}, sphere, {.samples = 4096, .restriction = DaylightRestriction::kWholeSky});
  DaylightShadows shadows(real, objects, sphere, {.map_size_px = 0});
  shadows.SetSamples(
      sampler.Draw(std::vector<glm::vec3>(SkyTable::kCells, glm::vec3(1.0f))).samples);
  const std::vector<Receiver> receivers{{{0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 1.0f}},
                                        {{0.5f, 0.0f, 0.5f}, {1.0f, 0.0f, 0.0f}},
                                        {{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.0f}}};
  const std::vector<glm::vec3> irradiance = shadows.OnObjects(receivers);
  constexpr float kPi = std::numbers::pi_v<float>;
  EXPECT_NEAR(irradiance[0].x, kPi, 0.01f * kPi);
  EXPECT_NEAR(irradiance[1].x, 0.5f * kPi, 0.01f * kPi);
  EXPECT_EQ(irradiance[2], glm::vec3(0.0f));
}

class DaylightShadowsInARoom : public ::testing::Test {
 protected:
  DaylightShadowsInARoom() {
    const std::vector<Window> windows{SouthWindow(kSouthHole)};
    std::vector<glm::vec3> sky(SkyTable::kCells, glm::vec3(1.0f));
    samples_ = DaylightSampler(windows, sphere_, {}).Draw(sky).samples;
    // The floor around the object.
    for (int i = 0; i < 40; ++i) {
      for (int k = 0; k < 40; ++k) {
        const glm::vec3 position(
            1.52f + 0.05f * static_cast<float>(i), 0.82f + 0.05f * static_cast<float>(k), 0.0f);
        if (position.x > 2.3f && position.x < 2.7f && position.y > 1.3f && position.y < 1.6f) {
          continue;
        }
        floor_.push_back({position, {0.0f, 0.0f, 1.0f}});
      }
    }
  }
  std::vector<glm::vec3> Hidden(int map_size_px) const {
    DaylightShadows shadows(room_, objects_, sphere_, {.map_size_px = map_size_px});
    shadows.SetSamples(samples_);
    return shadows.HiddenFrom(floor_);
  }
  // Rms of the difference to rays, relative to the rms of what is hidden.
  double Error(int map_size_px) const {
    const std::vector<glm::vec3> maps = Hidden(map_size_px);
    const std::vector<glm::vec3> rays = Hidden(0);
    double difference = 0.0;
    double square = 0.0;
    for (std::size_t i = 0; i < maps.size(); ++i) {
      difference += std::pow(static_cast<double>(maps[i].x - rays[i].x), 2.0);
      square += std::pow(static_cast<double>(rays[i].x), 2.0);
    }
    return std::sqrt(difference / square);
  }

  const RayCaster room_{SheetRoom({kSouthHole})};
  const Mesh object_ = BoxObject({2.3f, 1.3f, 0.0f}, {2.7f, 1.6f, 0.8f});
  const RayCaster objects_{object_};
  const BoundingSphere sphere_ = BoundingSphereOf(object_.positions_m);
  std::vector<DaylightSample> samples_;
  std::vector<Receiver> floor_;
};

// Edges of 64 shadows fall a texel of 1.5 cm off at most: where they do, one sample of 64 is wrong.
TEST_F(DaylightShadowsInARoom, ConvergesToRaysWithTheMapsSize) {
  const double coarse = Error(16);
  const double usual = Error(64);
  const double fine = Error(256);
  EXPECT_LT(usual, 0.1);
  EXPECT_LT(usual, coarse);
  EXPECT_LT(fine, usual);
  RecordProperty("error_16", std::to_string(coarse));
  RecordProperty("error_64", std::to_string(usual));
  RecordProperty("error_256", std::to_string(fine));
}

TEST_F(DaylightShadowsInARoom, DrawsTheMapsOfNewDirectionsOnly) {
  DaylightShadows shadows(room_, objects_, sphere_);
  shadows.SetSamples(samples_);
  EXPECT_EQ(shadows.MapsDrawn(), samples_.size());
  const std::vector<glm::vec3> before = shadows.HiddenFrom(floor_);
  std::vector<DaylightSample> brighter = samples_;
  for (DaylightSample& sample : brighter) sample.irradiance_rgb *= 2.0f;
  shadows.SetSamples(brighter);
  EXPECT_EQ(shadows.MapsDrawn(), 0u);
  const std::vector<glm::vec3> after = shadows.HiddenFrom(floor_);
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_EQ(after[i], 2.0f * before[i]);
  brighter[5].direction_enu = glm::vec3(0.0f, 0.0f, 1.0f);
  shadows.SetSamples(brighter);
  EXPECT_EQ(shadows.MapsDrawn(), 1u);
  // As if set at once; and fewer samples leave no trace of the others.
  DaylightShadows again(room_, objects_, sphere_);
  brighter.resize(10);
  again.SetSamples(brighter);
  shadows.SetSamples(brighter);
  EXPECT_EQ(shadows.HiddenFrom(floor_), again.HiddenFrom(floor_));
}

TEST_F(DaylightShadowsInARoom, HaveNothingToHideWithoutSamples) {
  DaylightShadows shadows(room_, objects_, sphere_);
  shadows.SetSamples({});
  for (const glm::vec3& hidden : shadows.HiddenFrom(floor_)) EXPECT_EQ(hidden, glm::vec3(0.0f));
  for (const glm::vec3& light : shadows.OnObjects(floor_)) EXPECT_EQ(light, glm::vec3(0.0f));
}

TEST_F(DaylightShadowsInARoom, RefuseBadSizesByName) {
  const auto message = [&](int map_size_px, const BoundingSphere& sphere) {
    try {
      DaylightShadows(room_, objects_, sphere, {.map_size_px = map_size_px});
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(message(-1, sphere_), HasSubstr("map_size_px is -1"));
  EXPECT_THAT(message(1025, sphere_), HasSubstr("map_size_px is 1025"));
  EXPECT_THAT(message(64, {}), HasSubstr("radius 0"));
}

}  // namespace
}  // namespace pleinair::daylight_shadows_test
