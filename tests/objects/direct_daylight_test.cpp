// Direct daylight by samples, against rays that gather.
#include "objects/direct_daylight.h"

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "objects/object_gather.h"
#include "relight/transport/shading_mesh.h"
#include "tests/relight/window_rooms.h"

namespace pleinair::direct_daylight_test {
namespace {

using ::testing::HasSubstr;

// In edges of a decimetre: rays gather around a vertex, samples stand at it.
Mesh BoxObject(const glm::vec3& lower, const glm::vec3& upper) {
  Mesh mesh;
  mesh.materials.resize(1);
  mesh.group_names = {"object"};
  AddBox(mesh, lower, upper);
  return MakeShadingMesh(mesh, {.longest_edge = 0.15, .most_growth = 100.0});
}

// The brighter the lower: a window shows the sky's lower part.
std::shared_ptr<const SkyShape> BrightBelow() {
  std::vector<glm::vec3> table;
  for (std::size_t cell = 0; cell < SkyTable::kCells; ++cell) {
    const auto height = static_cast<float>(SkyTable::DirectionOfCell(cell).z);
    table.push_back({1.5f - height, 1.2f - height, 1.0f});
  }
  return MakeTableSkyShape("bright below", table);
}

std::vector<glm::vec3> DarkFaces(const PatchScene& scene) {
  return std::vector<glm::vec3>(scene.FaceCount(), glm::vec3(0.0f));
}

// Rms of the difference over the rms of the second.
double RelativeRms(std::span<const glm::vec3> a, std::span<const glm::vec3> b) {
  double difference = 0.0;
  double size = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference += double{glm::dot(a[i] - b[i], a[i] - b[i])};
    size += double{glm::dot(b[i], b[i])};
  }
  return std::sqrt(difference / size);
}

// A box beside the window's light on the floor of a room with one window.
class DirectDaylightInARoom : public ::testing::Test {
 protected:
  DirectDaylight Daylight(const DirectDaylightOptions& options) const {
    return {room_.mesh, room_.caster, object_, options};
  }
  static DirectDaylightOptions Samples(int count) {
    DirectDaylightOptions options;
    options.sampling.samples = count;
    options.shadows.map_size_px = 0;
    return options;
  }

  PatchScene room_ = SceneOf(SheetRoom({kSouthHole}));
  PatchScene object_ = SceneOf(BoxObject({2.3f, 1.3f, 0.0f}, {2.7f, 1.6f, 0.5f}));
  std::shared_ptr<const SkyShape> sky_ = BrightBelow();
};

// 16384 rays a vertex, of which some hundreds leave by the window: 1 / sqrt(some hundreds) at the
// worst, half of that as both sets are low-discrepancy. The object casts shadows on itself.
TEST_F(DirectDaylightInARoom, ObjectsGetWhatRaysAtTheirVerticesGather) {
  DirectDaylight daylight = Daylight(Samples(16384));
  daylight.Update(std::array{sky_});
  const ObjectGather gather(object_, room_, {.rays_per_receiver = 16384});
  const std::vector<glm::vec3> gathered =
      gather.Irradiance(sky_.get(), DarkFaces(object_), DarkFaces(room_));
  EXPECT_LT(RelativeRms(daylight.OnObjects(0), gathered), 0.03);
  EXPECT_THAT(daylight.Note(), HasSubstr("1 window"));
}

// Points of the floor: sky that rays gather without the object less that with it.
TEST_F(DirectDaylightInARoom, NewShadowsAreWhatTheObjectTakesFromTheFloor) {
  std::vector<Receiver> floor;
  for (int i = 0; i < 20; ++i) {
    for (int k = 0; k < 20; ++k) {
      floor.push_back(
          {{1.53f + 0.1f * static_cast<float>(i), 1.65f + 0.07f * static_cast<float>(k), 0.0f},
           {0.0f, 0.0f, 1.0f}});
    }
  }
  Mesh both = room_.mesh;
  AddBox(both, {2.3f, 1.3f, 0.0f}, {2.7f, 1.6f, 0.5f});
  const GatherOptions rays{.rays_per_receiver = 4096};
  std::vector<glm::vec3> taken = GatheredRays(room_, floor, rays).FromSky(*sky_);
  const std::vector<glm::vec3> left = GatheredRays(SceneOf(both), floor, rays).FromSky(*sky_);
  for (std::size_t i = 0; i < taken.size(); ++i) taken[i] -= left[i];

  DirectDaylight daylight = Daylight(Samples(4096));
  daylight.Update(std::array{sky_});
  // A fifth of the light is lost; its noise is that of a fifth of the rays.
  EXPECT_LT(RelativeRms(daylight.HiddenFrom(0, floor), taken), 0.1);
}

// A bound of what each vertex gets, and of what the object hides from the floor around it.
TEST_F(DirectDaylightInARoom, NothingGetsOrLosesMoreThanTheWindowLetsThrough) {
  DirectDaylight daylight = Daylight(Samples(4096));
  daylight.Update(std::array{sky_});
  const glm::vec3 largest = daylight.LargestIrradiance(sky_);
  EXPECT_LT(largest.g, 1.0f) << "less than all the sky";
  float most = 0.0f;
  for (const glm::vec3& irradiance : daylight.OnObjects(0)) most = std::max(most, irradiance.g);
  EXPECT_LT(most, largest.g);
  EXPECT_GT(most, 0.2f * largest.g) << "the bound is no idle one";
  std::vector<Receiver> floor;
  for (int i = 0; i < 40; ++i) {
    floor.push_back({{1.5f + 0.05f * static_cast<float>(i), 1.9f, 0.0f}, {0.0f, 0.0f, 1.0f}});
  }
  for (const glm::vec3& hidden : daylight.HiddenFrom(0, floor)) EXPECT_LT(hidden.g, largest.g);
}

TEST_F(DirectDaylightInARoom, AStillSkyDrawsNoNewSamples) {
  DirectDaylightOptions options;
  options.sampling.samples = 64;
  DirectDaylight daylight = Daylight(options);
  const auto uniform = MakeUniformSkyShape();
  daylight.Update(std::array{sky_, uniform});
  EXPECT_EQ(daylight.Summary().samples, 128u);
  EXPECT_EQ(daylight.Summary().maps_drawn, 128u);
  EXPECT_GT(daylight.Summary().sky_share, 0.0);
  EXPECT_LT(daylight.Summary().sky_share, 0.5);
  const std::vector<glm::vec3> before = daylight.OnObjects(0);
  daylight.Update(std::array{sky_, uniform});
  EXPECT_EQ(daylight.Summary().maps_drawn, 0u);
  EXPECT_EQ(daylight.Summary().samples, 128u);
  // The same light in another object: drawn again, in the same directions.
  daylight.Update(std::array{BrightBelow(), uniform});
  EXPECT_EQ(daylight.Summary().maps_drawn, 0u);
  EXPECT_EQ(daylight.OnObjects(0), before);
  // One shape less, and another one.
  daylight.Update(std::array{uniform});
  EXPECT_EQ(daylight.Summary().samples, 64u);
  EXPECT_GT(daylight.Summary().maps_drawn, 0u);
}

// Given windows or found ones: the same light.
TEST_F(DirectDaylightInARoom, WindowsAreGivenOrFound) {
  DirectDaylightOptions options = Samples(4096);
  DirectDaylight found = Daylight(options);
  options.windows = {SouthWindow(kSouthHole)};
  DirectDaylight given = Daylight(options);
  EXPECT_THAT(given.Note(), HasSubstr("1 window"));
  found.Update(std::array{sky_});
  given.Update(std::array{sky_});
  // A found outline is up to a cell and a half of 1 cm too large: other directions are drawn.
  EXPECT_LT(RelativeRms(found.OnObjects(0), given.OnObjects(0)), 0.05);
}

TEST(DirectDaylight, SamplesTheWholeSkyOutdoors) {
  Mesh ground;
  ground.materials.resize(1);
  ground.group_names = {"ground"};
  AddGround(ground, 1000.0f);
  const PatchScene real = SceneOf(ground);
  const PatchScene object = SceneOf(BoxObject({0.0f, 0.0f, 0.0f}, {1.0f, 1.0f, 1.0f}));
  DirectDaylightOptions options;
  options.sampling.samples = 1024;
  DirectDaylight daylight(real.mesh, real.caster, object, options);
  EXPECT_THAT(daylight.Note(), HasSubstr("entire sky"));
  const auto sky = MakeUniformSkyShape();
  daylight.Update(std::array{sky});
  EXPECT_EQ(daylight.Summary().sky_share, 1.0);
  for (std::size_t v = 0; v < object.mesh.positions_m.size(); ++v) {
    const float expected = 0.5f * (1.0f + object.mesh.normals[v].z);
    // One of 1024 samples more or less, and their spread.
    EXPECT_NEAR(daylight.OnObjects(0)[v].y, expected, 0.01f);
  }
}

TEST(DirectDaylight, AClosedRoomHasNone) {
  const PatchScene room = SceneOf(SheetRoom({}));
  const PatchScene object = SceneOf(BoxObject({2.3f, 1.3f, 0.2f}, {2.7f, 1.6f, 0.5f}));
  DirectDaylight daylight(room.mesh, room.caster, object, {});
  EXPECT_THAT(daylight.Note(), HasSubstr("no window"));
  daylight.Update(std::array{MakeUniformSkyShape()});
  EXPECT_EQ(daylight.Summary().samples, 0u);
  for (const glm::vec3& irradiance : daylight.OnObjects(0)) {
    EXPECT_EQ(irradiance, glm::vec3(0.0f));
  }
}

TEST_F(DirectDaylightInARoom, RefusesBadOptionsByName) {
  DirectDaylightOptions options;
  options.sampling.samples = 0;
  EXPECT_THROW(Daylight(options), std::invalid_argument);
  options = {};
  options.windows = {{"flat", {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}}};
  EXPECT_THROW(Daylight(options), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::direct_daylight_test
