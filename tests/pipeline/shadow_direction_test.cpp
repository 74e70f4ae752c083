// A made yard, photographed under a sun that is turned from the stated one.
#include "pipeline/shadow_direction.h"

#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "pipeline/sun_check.h"
#include "sunmodel/angles.h"
#include "sunmodel/north.h"
#include "tests/pipeline/yard_pictures.h"

namespace pleinair::shadow_direction_test {
namespace {

using namespace yard;  // NOLINT: what all these tests are about.

ShadowDirectionOptions Quick() {
  ShadowDirectionOptions options;
  options.pixels = 2500;
  return options;
}

// Two frames, morning and afternoon; the stated sun is turned by `turn_deg`.
ShadowDirectionResult Measure(const Mesh& pictured,
                              const Mesh& modelled,
                              double turn_deg,
                              const Shading& shading) {
  ShadowDirectionFinder finder(modelled, kGround, Quick());
  int index = 0;
  for (const double azimuth_deg : {120.0, 215.0}) {
    const glm::dvec3 sun = Sun(azimuth_deg, 40.0);
    finder.Add(Photograph(pictured, sun, index++, shading),
               TurnedClockwise(sun, RadFromDeg(turn_deg)));
  }
  return finder.Result();
}

// Half a degree is what is asked for; the stated uncertainty must own up to the error.
void ExpectFound(const ShadowDirection& shadow, double offset_deg) {
  EXPECT_TRUE(shadow.determined) << shadow.reason;
  EXPECT_NEAR(DegFromRad(shadow.azimuth_offset_rad), offset_deg, 0.5);
  EXPECT_LE(std::abs(shadow.azimuth_offset_rad - RadFromDeg(offset_deg)), 3.0 * shadow.stddev_rad);
  EXPECT_LT(shadow.stddev_rad, RadFromDeg(1.5));
}

TEST(ShadowDirection, FindsTheSunFromWhereItWasTurned) {
  const Mesh yard = Yard(4.0f);
  for (const double turn_deg : {-15.0, -5.0, -1.0, 1.3, 5.0, 15.0}) {
    SCOPED_TRACE(turn_deg);
    ExpectFound(Measure(yard, yard, turn_deg, TwoLevels).all, -turn_deg);
  }
}

TEST(ShadowDirection, WarnsOnlyWhereTheSunIsElsewhere) {
  const Mesh yard = Yard(4.0f);
  EXPECT_FALSE(Measure(yard, yard, 0.0, TwoLevels).all.ContradictsTheSun());
  EXPECT_TRUE(Measure(yard, yard, 6.0, TwoLevels).all.ContradictsTheSun());
}

// Dark round patches all over the yard, one of them at a shadow's edge.
TEST(ShadowDirection, IsNotTakenInByShadowsThatTheMeshLacks) {
  const Mesh yard = Yard(4.0f);
  const auto with_strangers = [](const glm::vec3& position_m, bool lit) {
    for (const glm::vec3& stranger : {glm::vec3(-1.0f, 1.0f, 0.0f),
                                      glm::vec3(4.0f, -3.0f, 0.0f),
                                      glm::vec3(-5.0f, -4.0f, 0.0f),
                                      glm::vec3(7.0f, 6.0f, 0.0f),
                                      glm::vec3(-10.0f, 9.0f, 0.0f)}) {
      if (glm::distance(position_m, stranger) < 1.2f) return kShaded;
    }
    return TwoLevels(position_m, lit);
  };
  ExpectFound(Measure(yard, yard, 4.0, with_strangers).all, -4.0);
}

// Eaves and gutters that a coarse mesh lacks lengthen shadows: by a twelfth here.
TEST(ShadowDirection, ForgivesHousesThatAreHigherThanTheMesh) {
  ExpectFound(Measure(Yard(4.33f), Yard(4.0f), -3.0, TwoLevels).all, 3.0);
}

// Clouds: no sun, but the ground near walls sees less sky.
TEST(ShadowDirection, TakesNothingFromAnOvercastSky) {
  const Mesh yard = Yard(4.0f);
  const auto overcast = [](const glm::vec3& position_m, bool) {
    const double from_walls_m = std::abs(double(position_m.y) - 3.0);
    return 0.4 * (0.45 + 0.55 * std::min(1.0, from_walls_m / 8.0));
  };
  const ShadowDirectionResult result = Measure(yard, yard, 2.0, overcast);
  EXPECT_FALSE(result.all.determined);
  EXPECT_FALSE(result.all.reason.empty());
  EXPECT_FALSE(result.all.ContradictsTheSun());
  for (const FrameShadowDirection& frame : result.frames) EXPECT_FALSE(frame.sunlit);
}

TEST(ShadowDirection, AnOvercastFrameLeavesTheAnswerAlone) {
  const Mesh yard = Yard(4.0f);
  const auto overcast = [](const glm::vec3&, bool) { return 0.3; };
  const glm::dvec3 sun = Sun(150.0, 35.0);
  ShadowDirectionFinder finder(yard, kGround, Quick());
  finder.Add(Photograph(yard, sun, 0, TwoLevels), sun);
  const ShadowDirection alone = finder.Result().all;
  finder.Add(Photograph(yard, sun, 1, overcast), sun);
  const ShadowDirectionResult both = finder.Result();
  EXPECT_EQ(both.all.azimuth_offset_rad, alone.azimuth_offset_rad);
  EXPECT_EQ(both.all.curvature_stddev_rad, alone.curvature_stddev_rad);
  EXPECT_FALSE(both.frames[1].sunlit);
}

TEST(ShadowDirection, SaysSoWhereNoShadowsEdgeIsInView) {
  const Mesh ground = Ground();
  const ShadowDirectionResult result = Measure(ground, ground, 0.0, TwoLevels);
  EXPECT_FALSE(result.all.determined);
  EXPECT_FALSE(result.all.reason.empty());
}

// Brightness with neither sun nor edges where the mesh has them: whatever is said, it is not clear.
TEST(ShadowDirection, IsNotSureOfAPictureOfSomethingElse) {
  const Mesh yard = Yard(4.0f);
  const auto stripes = [](const glm::vec3& position_m, bool) {
    return std::fmod(std::abs(double(position_m.x) + 0.4 * double(position_m.y)), 6.0) < 3.0
               ? kLit
               : kShaded;
  };
  EXPECT_FALSE(Measure(yard, yard, 0.0, stripes).all.ContradictsTheSun());
}

TEST(ShadowDirection, DoesNotDependOnTheScaleOfLight) {
  const Mesh yard = Yard(4.0f);
  const ShadowDirection plain = Measure(yard, yard, 2.0, TwoLevels).all;
  const ShadowDirection bright = Measure(yard, yard, 2.0, [](const glm::vec3& p, bool lit) {
                                   return 1024.0 * TwoLevels(p, lit);
                                 }).all;
  // Float's rounding of the pictures.
  EXPECT_NEAR(plain.azimuth_offset_rad, bright.azimuth_offset_rad, 1e-4);
  EXPECT_NEAR(plain.stddev_rad, bright.stddev_rad, 1e-4);
}

double AngleDeg(const glm::dvec3& a, const glm::dvec3& b) {
  return DegFromRad(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
}

// The sun shown by a frame under a sun at azimuth 150 deg, elevation 40 deg.
ShownSun ShownFor(const glm::dvec3& stated, const Shading& shading = TwoLevels) {
  const Mesh yard = Yard(4.0f);
  ShadowDirectionFinder finder(yard, kGround, Quick());
  return finder.ShownBy(Photograph(yard, Sun(150.0, 40.0), 3, shading), stated);
}

// Orientation, time zone, place: off by anything from 5 deg on, and found to half a degree of
// azimuth about the sun that was found, or to the 3 deg that a search over all directions has.
TEST(ShownSun, ContradictsASunThatIsFarFromItsShadows) {
  for (const auto& [azimuth_deg, elevation_deg] :
       std::vector<std::pair<double, double>>{{157.0, 40.0},
                                              {142.0, 40.0},
                                              {170.0, 40.0},
                                              {128.0, 40.0},
                                              {240.0, 40.0},
                                              {330.0, 40.0},
                                              {-30.0, 40.0},
                                              {150.0, 62.0},
                                              {165.0, 55.0},
                                              {150.0, -20.0}}) {
    SCOPED_TRACE(std::to_string(azimuth_deg) + ", " + std::to_string(elevation_deg));
    const ShownSun shown = ShownFor(Sun(azimuth_deg, elevation_deg));
    EXPECT_TRUE(shown.contradicts);
    EXPECT_LT(AngleDeg(shown.direction_enu, Sun(150.0, 40.0)), 4.0);
    EXPECT_GT(shown.stddev_rad, 0.0);
  }
}

TEST(ShownSun, SaysNothingOfASunThatIsInItsPlaceOrNearIt) {
  for (const double azimuth_deg : {150.0, 149.0, 151.0, 148.0, 152.0}) {
    EXPECT_FALSE(ShownFor(Sun(azimuth_deg, 40.0)).contradicts) << azimuth_deg;
  }
  // Heights of casters are not known better.
  EXPECT_FALSE(ShownFor(Sun(150.0, 42.0)).contradicts);
}

TEST(ShownSun, TakesNothingFromCloudsTextureOrDarkness) {
  const auto overcast = [](const glm::vec3& position_m, bool) {
    return 0.4 * (0.45 + 0.55 * std::min(1.0, std::abs(double(position_m.y) - 3.0) / 8.0));
  };
  const auto stripes = [](const glm::vec3& position_m, bool) {
    return std::fmod(std::abs(double(position_m.x) + 0.4 * double(position_m.y)), 6.0) < 3.0
               ? kLit
               : kShaded;
  };
  const auto nothing = [](const glm::vec3&, bool) {
    return std::numeric_limits<double>::quiet_NaN();
  };
  for (const Shading& shading : {Shading(overcast), Shading(stripes), Shading(nothing)}) {
    for (const glm::dvec3& stated : {Sun(150.0, 40.0),
                                     Sun(10.0, 40.0),
                                     glm::dvec3(0.0, 0.0, -1.0),
                                     glm::dvec3(0.0, 0.0, 1.0)}) {
      EXPECT_FALSE(ShownFor(stated, shading).contradicts);
    }
  }
}

// Corners that are dark under clouds look like a sun's shadows, but for their colour.
TEST(ShownSun, TakesNoSunFromShadeThatIsNotBluer) {
  const Mesh yard = Yard(4.0f);
  ShadowDirectionFinder finder(yard, kGround, Quick());
  for (const double azimuth_deg : {170.0, 240.0, 330.0}) {
    const Frame grey = Photograph(yard, Sun(150.0, 40.0), 3, TwoLevels, glm::vec3(1.0f));
    EXPECT_FALSE(finder.ShownBy(grey, Sun(azimuth_deg, 40.0)).contradicts) << azimuth_deg;
    const Frame sunny = Photograph(yard, Sun(150.0, 40.0), 3, TwoLevels);
    EXPECT_TRUE(finder.ShownBy(sunny, Sun(azimuth_deg, 40.0)).contradicts) << azimuth_deg;
  }
}

// Clouds are stated, and the sun shines.
TEST(ShownSun, ContradictsAnAbsenceOfTheSun) {
  const ShownSun shown = ShownFor({0.0, 0.0, -1.0});
  EXPECT_TRUE(shown.contradicts);
  EXPECT_LT(AngleDeg(shown.direction_enu, Sun(150.0, 40.0)), 4.0);
}

Lighting LightOf(const glm::dvec3& sun, double irradiance) {
  Lighting lighting;
  lighting.sun.direction_enu = sun;
  lighting.sun.irradiance_rgb = glm::dvec3(irradiance);
  lighting.sky = {{"uniform", glm::dvec3(1.0)}};
  return lighting;
}

std::optional<SunContradiction> LookIfDue(SunCheck& check,
                                          const Frame& frame,
                                          const Lighting& lighting) {
  if (!check.IsDue(lighting)) return std::nullopt;
  return check.Look(frame, lighting);
}

TEST(SunCheck, WarnsOnceAndAgainWhenTheSunIsElsewhere) {
  const Mesh yard = Yard(4.0f);
  SunCheck check(yard, kGround);
  const Frame frame = Photograph(yard, Sun(150.0, 40.0), 5, TwoLevels);
  EXPECT_FALSE(LookIfDue(check, frame, LightOf(Sun(150.0, 40.0), 1.0)));
  // The second frame, the fourth, one whose sun has moved.
  const auto found = LookIfDue(check, frame, LightOf(Sun(170.0, 40.0), 1.0));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->frame, 5);
  EXPECT_NEAR(DegFromRad(found->angle_rad), AngleDeg(Sun(150.0, 40.0), Sun(170.0, 40.0)), 0.5);
  EXPECT_FALSE(LookIfDue(check, frame, LightOf(Sun(170.0, 40.0), 1.0))) << "the third: no look";
  EXPECT_FALSE(LookIfDue(check, frame, LightOf(Sun(170.0, 40.0), 1.0))) << "said before";
  EXPECT_TRUE(LookIfDue(check, frame, LightOf(Sun(250.0, 40.0), 1.0)));
}

// As though it had never begun: the next look finds the same, of a camera that is new to it, too.
TEST(SunCheck, NothingRemainsOfALookThatIsStopped) {
  const Mesh yard = Yard(4.0f);
  const Frame frame = Photograph(yard, Sun(150.0, 40.0), 5, TwoLevels);
  const Lighting lighting = LightOf(Sun(170.0, 40.0), 1.0);
  SunCheck check(yard, kGround);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(check.Look(frame, lighting, stop.get_token()));
  // In the middle of its work.
  std::stop_source later;
  std::jthread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    later.request_stop();
  });
  const std::optional<SunLook> midway = check.Look(frame, lighting, later.get_token());
  SunCheck other(yard, kGround);
  const auto found = check.Look(frame, lighting);
  const auto expected = other.Look(frame, lighting);
  ASSERT_TRUE(expected);
  // It is said once: now, or by the look above where that ended before it was stopped.
  const auto& said = midway ? midway->contradiction : found;
  ASSERT_TRUE(said);
  EXPECT_EQ(said->shown_enu, expected->shown_enu);
  EXPECT_EQ(found.has_value(), !midway);
}

// Overcast at first, so that nothing is looked at but for the light that has changed.
TEST(SunCheck, LooksWhenTheSunComesOut) {
  const Mesh yard = Yard(4.0f);
  SunCheck check(yard, kGround);
  const Frame clouds =
      Photograph(yard, Sun(150.0, 40.0), 0, [](const glm::vec3&, bool) { return 0.3; });
  const Frame sunny = Photograph(yard, Sun(150.0, 40.0), 1, TwoLevels);
  const glm::dvec3 stated = Sun(185.0, 40.0);
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(LookIfDue(check, clouds, LightOf(stated, 0.0)));
  EXPECT_FALSE(LookIfDue(check, sunny, LightOf(stated, 0.1))) << "the fifth, nothing new";
  EXPECT_TRUE(LookIfDue(check, sunny, LightOf(stated, 3.0)));
}

TEST(ShadowDirectionHardCases, NightZenithAndSpoiltPixelsAddNothing) {
  const Mesh yard = Yard(4.0f);
  const glm::dvec3 sun = Sun(150.0, 35.0);
  Frame spoilt = Photograph(yard, sun, 2, TwoLevels);
  for (glm::vec3& pixel : spoilt.radiance.pixels) {
    pixel = glm::vec3(std::numeric_limits<float>::quiet_NaN());
  }
  ShadowDirectionFinder finder(yard, kGround, Quick());
  finder.Add(Photograph(yard, sun, 0, TwoLevels), Sun(150.0, -10.0));
  finder.Add(Photograph(yard, sun, 1, TwoLevels), {0.0, 0.0, 1.0});
  finder.Add(spoilt, sun);
  const ShadowDirectionResult result = finder.Result();
  ASSERT_EQ(result.frames.size(), 3u);
  EXPECT_FALSE(result.all.determined);
  EXPECT_TRUE(std::isfinite(result.all.azimuth_offset_rad));
  EXPECT_TRUE(std::isfinite(result.all.stddev_rad));
}

TEST(ShadowDirectionHardCases, NoFramesIsNoAnswer) {
  const ShadowDirectionResult result = ShadowDirectionFinder(Yard(4.0f), kGround, Quick()).Result();
  EXPECT_FALSE(result.all.determined);
  EXPECT_TRUE(result.frames.empty());
}

TEST(ShadowDirectionHardCases, RefusesWhatMakesNoSense) {
  EXPECT_THROW(ShadowDirectionFinder(Mesh{}, {}), std::invalid_argument);
  const std::vector<std::string> unknown = {"lawn"};
  EXPECT_THROW(ShadowDirectionFinder(Yard(4.0f), unknown), std::invalid_argument);
  ShadowDirectionOptions options;
  options.step_rad = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(ShadowDirectionFinder(Yard(4.0f), kGround, options), std::invalid_argument);
  options = {};
  options.pixels = 0;
  EXPECT_THROW(ShadowDirectionFinder(Yard(4.0f), kGround, options), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::shadow_direction_test
