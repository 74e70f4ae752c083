#include "relight/point_irradiance.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "scene/lighting.h"
#include "tests/relight/memory_store.h"
#include "tests/relight/reference_path_tracer.h"
#include "tests/relight/window_room.h"

namespace pleinair::point_irradiance_test {
namespace {

const std::vector<glm::vec3> kSixWays = {
    {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};

std::size_t FourBySixteen(const glm::dvec3& direction) {
  static const SkyRegions regions;
  return *regions.RegionOf(direction);
}

PointIrradianceOptions Quick() {
  PointIrradianceOptions options;
  options.patch_size_m = 0.25;
  options.rays_per_point = 4096;
  options.sky_rays_per_point = 32768;
  options.sky_rays_per_patch = 4096;
  options.rays_per_patch = 512;
  return options;
}

struct Difference {
  double rms = 0.0;  // Share of the reference's rms, its own noise taken out.
  double bias = 0.0;
};

// Two independent halves of a reference measure its noise: half their difference.
template <class Value>
Difference Compare(const std::vector<glm::vec3>& values,
                   const std::vector<Value>& one,
                   const std::vector<Value>& other) {
  double error2 = 0.0;
  double noise2 = 0.0;
  double reference2 = 0.0;
  double sum = 0.0;
  double reference_sum = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const glm::dvec3 reference = 0.5 * (glm::dvec3(one[i]) + glm::dvec3(other[i]));
    const glm::dvec3 noise = 0.5 * (glm::dvec3(one[i]) - glm::dvec3(other[i]));
    const glm::dvec3 error = glm::dvec3(values[i]) - reference;
    error2 += glm::dot(error, error);
    noise2 += glm::dot(noise, noise);
    reference2 += glm::dot(reference, reference);
    sum += values[i].x + values[i].y + values[i].z;
    reference_sum += reference.x + reference.y + reference.z;
  }
  return {std::sqrt(std::max(0.0, error2 - noise2) / reference2), sum / reference_sum - 1.0};
}

std::vector<ReferencePoint> EveryWay(const std::vector<glm::vec3>& points) {
  std::vector<ReferencePoint> every;
  for (const glm::vec3& point : points) {
    for (const glm::vec3& normal : kSixWays) {
      every.push_back({glm::dvec3(point), glm::dvec3(normal)});
    }
  }
  return every;
}

// 6 % (and 2 % in the mean): 20000 paths a half leave 4 % of noise, which is taken out but not to
// its last tenth, and the settings are a quarter of the defaults. With the defaults and 150000
// paths it is 1 % and 0.1 %.
TEST(PointIrradiance, RegionsAgreeWithAPathTracer) {
  const Mesh mesh = RoomWithWindow({0.7f, 0.6f, 0.3f});
  const std::vector<glm::vec3> points = {{1.0f, 2.5f, 1.2f}, {3.0f, 1.0f, 0.02f}};
  PointIrradianceOptions options = Quick();
  options.regions = SkyRegions();
  PointIrradiance room(mesh, {points, kSixWays}, options, {});
  ReferenceLight light;
  light.bins = 64;
  light.bin_of = FourBySixteen;
  ReferenceOptions reference{.paths = 20000};
  const auto every = EveryWay(points);
  const auto one = ReferenceIndirect(mesh, every, light, reference);
  const auto direct_one = ReferenceDirect(mesh, every, light, {.paths = 100000});
  reference.seed = 2;
  const auto other = ReferenceIndirect(mesh, every, light, reference);
  const auto direct_other = ReferenceDirect(mesh, every, light, {.paths = 100000, .seed = 2});
  const Difference indirect = Compare(room.OfRegions(LightPart::kIndirect), one, other);
  EXPECT_LT(indirect.rms, 0.06);
  EXPECT_LT(std::abs(indirect.bias), 0.02);
  const Difference direct = Compare(room.OfRegions(LightPart::kDirect), direct_one, direct_other);
  EXPECT_LT(direct.rms, 0.02);
  EXPECT_LT(std::abs(direct.bias), 0.01);
}

// Sun through the window, and over the outer walls: all bounces, and exactly two.
TEST(PointIrradiance, SunAgreesWithAPathTracer) {
  const Mesh mesh = RoomWithWindow({0.7f, 0.6f, 0.3f});
  const std::vector<glm::vec3> points = {{1.0f, 2.5f, 1.2f}, {3.0f, 1.0f, 0.02f}};
  const glm::dvec3 sun = glm::normalize(glm::dvec3(0.2, -0.7, 0.6));
  ReferenceLight light;
  light.beam = sun;
  for (const int bounces : {kAllBounces, 2}) {
    PointIrradianceOptions options = Quick();
    options.bounces = bounces;
    PointIrradiance room(mesh, {points, kSixWays}, options, {});
    ReferenceOptions reference{.paths = 30000};
    if (bounces != kAllBounces) reference.bounces = bounces;
    const auto one = ReferenceIndirect(mesh, EveryWay(points), light, reference);
    reference.seed = 2;
    const auto other = ReferenceIndirect(mesh, EveryWay(points), light, reference);
    const Difference indirect =
        Compare(room.OfSun(sun, kMeanSunAngularRadiusRad, LightPart::kIndirect), one, other);
    EXPECT_LT(indirect.rms, 0.02) << bounces;
    EXPECT_LT(std::abs(indirect.bias), 0.02) << bounces;
  }
}

// Total = direct + indirect, and nothing comes back from a room without a bounce.
TEST(PointIrradiance, PartsAddUp) {
  const Mesh mesh = RoomWithWindow(glm::vec3(0.5f));
  PointIrradianceOptions options = Quick();
  options.patch_size_m = 1.0;
  PointIrradiance room(mesh, {{{2, 1, 1}}, kSixWays}, options, {});
  const auto sky = [](const glm::vec3& direction) { return glm::vec3(1.0f, direction.z, 0.5f); };
  const auto direct = room.OfSky(sky, LightPart::kDirect);
  const auto indirect = room.OfSky(sky, LightPart::kIndirect);
  const auto total = room.OfSky(sky, LightPart::kTotal);
  for (std::size_t i = 0; i < total.size(); ++i) {
    EXPECT_NEAR(total[i].y, direct[i].y + indirect[i].y, 1e-6);
  }
  options.bounces = 0;
  PointIrradiance dark(mesh, {{{2, 1, 1}}, kSixWays}, options, {});
  for (const glm::vec3& rgb : dark.OfSky(sky, LightPart::kIndirect)) {
    EXPECT_EQ(rgb, glm::vec3(0.0f));
  }
}

// Closed form under the open sky: Y(0,0) alone holds 1/2 of the sphere's, and the irradiance of the
// nine coefficients is pi upwards and pi/2 on a wall to what three bands leave out (1 % here).
TEST(PointIrradiance, CoefficientsOfAnOpenSkyAreTheClosedForm) {
  PointIrradianceOptions options = Quick();
  options.rays_per_point = 16384;
  PointIrradiance open({}, {{{0, 0, 1}}, {}}, options, {});
  const std::vector<ShRgb> sh = open.ShOfRegions(LightPart::kTotal);
  ASSERT_EQ(sh.size(), 1u);
  EXPECT_NEAR(sh[0][0].x, 2.0 * std::numbers::pi * 0.2820948, 1e-4);
  EXPECT_NEAR(sh[0][2].x, std::numbers::pi * 0.4886025, 1e-3);
  EXPECT_NEAR(sh[0][1].x, 0.0, 1e-3);
  EXPECT_NEAR(IrradianceFromSh(sh[0], {0, 0, 1}).x, std::numbers::pi, 0.01 * std::numbers::pi);
  EXPECT_NEAR(IrradianceFromSh(sh[0], {1, 0, 0}).x, 0.5 * std::numbers::pi, 0.01);
}

// Indirect light of a room has few high frequencies: nine coefficients cost some 2 % in irradiance,
// at most 8 % of the largest right beside a wall.
TEST(PointIrradiance, CoefficientsGiveTheIrradianceBack) {
  const Mesh mesh = RoomWithWindow(glm::vec3(0.5f));
  PointIrradiance room(mesh, {{{2, 2, 1.5f}}, kSixWays}, Quick(), {});
  const auto sky = [](const glm::vec3&) { return glm::vec3(1.0f); };
  const auto irradiance = room.OfSky(sky, LightPart::kIndirect);
  const auto sh = room.ShOfSky(sky, LightPart::kIndirect);
  float largest = 0.0f;
  for (const glm::vec3& rgb : irradiance) largest = std::max(largest, rgb.x);
  for (std::size_t i = 0; i < kSixWays.size(); ++i) {
    EXPECT_NEAR(IrradianceFromSh(sh[0], kSixWays[i]).x, irradiance[i].x, 0.08 * largest);
  }
}

TEST(PointIrradiance, AClosedRoomIsDark) {
  Mesh mesh;
  AddBox(mesh, {0, 0, 0}, {4, 3, 2.5f}, true);
  mesh.materials.resize(1);
  mesh.group_names = {"room"};
  PointIrradiance room(mesh, {{{2, 1, 1}}, kSixWays}, Quick(), {});
  for (const glm::vec3& rgb : room.OfRegions(LightPart::kTotal)) EXPECT_EQ(rgb, glm::vec3(0.0f));
}

TEST(PointIrradiance, RefusesWhatMakesNoSense) {
  const Mesh mesh = RoomWithWindow(glm::vec3(0.5f));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(PointIrradiance(mesh, {{{nan, 0, 0}}, kSixWays}, Quick(), {}),
               std::invalid_argument);
  EXPECT_THROW(PointIrradiance(mesh, {{{0, 0, 0}}, {{0, 0, 2}}}, Quick(), {}),
               std::invalid_argument);
  PointIrradianceOptions options = Quick();
  options.rays_per_point = 0;
  EXPECT_THROW(PointIrradiance(mesh, {{{0, 0, 0}}, kSixWays}, options, {}), std::invalid_argument);
  options = Quick();
  options.patch_size_m = -1.0;
  EXPECT_THROW(PointIrradiance(mesh, {{{0, 0, 0}}, kSixWays}, options, {}), std::invalid_argument);
}

TEST(PointIrradiance, RadiositiesOfRegionsAreKeptByContent) {
  Mesh mesh = RoomWithWindow({0.7f, 0.6f, 0.3f});
  PointIrradianceOptions options = Quick();
  options.patch_size_m = 1.0;
  options.regions = SkyRegions(2, 8);
  const std::vector<glm::vec3> points{{2.0f, 2.0f, 1.0f}};
  MemoryStore store;
  int solves = 0;
  const auto gather = [&] {
    const auto count = [&](std::string_view stage, double share) {
      if (stage == "sky over patches" && share == 0.0) ++solves;
    };
    PointIrradiance irradiance(mesh, {points, kSixWays}, options, count, &store);
    std::vector<glm::vec3> values = irradiance.OfRegions(LightPart::kIndirect);
    EXPECT_GT(irradiance.Summary().iterations, 0);
    EXPECT_GT(irradiance.Summary().exposed_faces, 0u);
    return values;
  };
  const std::vector<glm::vec3> made = gather();
  EXPECT_EQ(gather(), made);
  EXPECT_EQ(solves, 1);
  // More of the points' own rays need no other radiosity; another albedo does, and a damaged part.
  options.rays_per_point = 1024;
  gather();
  EXPECT_EQ(solves, 1);
  mesh.materials[0].diffuse_albedo = glm::vec3(0.5f);
  EXPECT_NE(gather(), made);
  EXPECT_EQ(solves, 2);
  store.blobs.begin()->second[100] ^= 1;
  (++store.blobs.begin())->second[100] ^= 1;
  gather();
  EXPECT_EQ(solves, 3);
}

// Over a laid ground that nothing shades but a slab of 0.2 m, 5 m below: what looks down gets the
// albedo's share of the horizontal irradiance, what stands half of it. 1 % for the rays, the slab
// and the ground's end.
TEST(PointIrradiance, ALaidGroundSendsBackItsShareOfSunAndSky) {
  Mesh mesh;
  AddBox(mesh, {0.0f, 0.0f, 0.0f}, {0.2f, 0.2f, 0.2f});
  mesh.materials.assign(1, {.name = "slab", .diffuse_albedo = glm::vec3(0.5f)});
  mesh.group_names = {"slab"};
  PointIrradianceOptions options = Quick();
  options.patch_size_m = 1.0;
  const std::vector<glm::vec3> points{{0.1f, 0.1f, 5.0f}};
  const std::vector<glm::vec3> normals{{0, 0, -1}, {1, 0, 0}, {0, 0, 1}};
  const glm::dvec3 sun(0.6, 0.0, 0.8);
  const auto gather = [&](double albedo) {
    options.ground_albedo = albedo;
    PointIrradiance irradiance(mesh, {points, normals}, options, {});
    std::vector<glm::vec3> values = irradiance.OfRegions(LightPart::kIndirect);
    const std::vector<glm::vec3> of_sun = irradiance.OfSun(sun, 0.0046, LightPart::kIndirect);
    values.insert(values.end(), of_sun.begin(), of_sun.end());
    return values;
  };
  const std::vector<glm::vec3> lit = gather(0.3);
  const double sky = 0.3 * std::numbers::pi;
  EXPECT_NEAR(lit[0].x, sky, 0.01 * sky);
  EXPECT_NEAR(lit[1].x, 0.5 * sky, 0.01 * sky);
  EXPECT_EQ(lit[2].x, 0.0f);
  EXPECT_NEAR(lit[3].x, 0.3 * 0.8, 0.01 * 0.3 * 0.8);
  EXPECT_NEAR(lit[4].x, 0.15 * 0.8, 0.01 * 0.15 * 0.8);
  // Without it there is but the slab: 0.04 m2 in 25.
  for (const glm::vec3& value : gather(0.0)) EXPECT_LT(value.x, 2e-3f);
}

}  // namespace
}  // namespace pleinair::point_irradiance_test
