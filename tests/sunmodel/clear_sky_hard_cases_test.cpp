#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sunmodel/angles.h"
#include "sunmodel/clear_sky.h"

namespace pleinair::clear_sky_hard_cases_test {
namespace {

using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const double kHeightsM[] = {-430.0, 0.0, 8848.0, 400e3};

template <typename Call>
std::string ErrorOf(const Call& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

TEST(ClearSkyHardCases, IsContinuousAndNeverNegativeThroughTheHorizon) {
  for (const double height_m : kHeightsM) {
    ClearSkyIrradiance before = ComputeClearSky({0.0, 0.0, height_m}, -std::numbers::pi / 2.0);
    constexpr double kStepDeg = 0.005;
    for (int i = 1; i <= 36000; ++i) {
      const double elevation_deg = std::min(-90.0 + i * kStepDeg, 90.0);
      const ClearSkyIrradiance sky =
          ComputeClearSky({0.0, 0.0, height_m}, RadFromDeg(elevation_deg));
      for (int c = 0; c < 3; ++c) {
        ASSERT_GE(sky.beam_rgb[c], 0.0) << elevation_deg;
        ASSERT_GE(sky.diffuse_rgb[c], 0.0) << elevation_deg;
        // The steepest: in orbit the whole beam appears within the disc's 0.533 deg, 1.5 times as
        // fast in the middle, 1361 x 1.5 x 0.005 / 0.533 = 19 W/m2 a step. The sky's twilight and
        // its low sun stay far below that.
        ASSERT_LT(std::abs(sky.beam_rgb[c] - before.beam_rgb[c]), 20.0) << elevation_deg;
        ASSERT_LT(std::abs(sky.diffuse_rgb[c] - before.diffuse_rgb[c]), 0.5) << elevation_deg;
        // A higher sun is never weaker, but for the last 1e-6 of the air mass formula, whose least
        // value is 0.016 deg off the zenith.
        ASSERT_GE(sky.beam_rgb[c], (1.0 - 1e-6) * before.beam_rgb[c]) << elevation_deg;
      }
      if (elevation_deg <= 0.0) {
        ASSERT_EQ(sky.beam_rgb, glm::dvec3(0.0)) << elevation_deg;
      }
      before = sky;
    }
  }
}

TEST(ClearSkyHardCases, NightIsDark) {
  for (const double height_m : kHeightsM) {
    const ClearSkyIrradiance night = ComputeClearSky({0.0, 0.0, height_m}, RadFromDeg(-18.0));
    EXPECT_EQ(night.beam_rgb, glm::dvec3(0.0));
    EXPECT_LT(std::max({night.diffuse_rgb.x, night.diffuse_rgb.y, night.diffuse_rgb.z}), 1e-5);
  }
}

// Blue loses most to the air: what thins with height.
TEST(ClearSkyHardCases, BeamGrowsWithHeight) {
  double before = 0.0;
  for (const double height_m : kHeightsM) {
    const double blue = ComputeClearSky({0.0, 0.0, height_m}, 0.5).beam_rgb.z;
    EXPECT_GT(blue, before);
    EXPECT_LT(blue, 1361.0);
    before = blue;
  }
}

TEST(ClearSkyHardCases, TakesTheCornersOfItsConditions) {
  for (const double aerosol : {0.0, 5.0}) {
    for (const double ozone : {0.0, 1.0}) {
      for (const double albedo : {0.0, 1.0}) {
        for (double elevation_deg = -90.0; elevation_deg <= 90.0; elevation_deg += 2.5) {
          const ClearSkyIrradiance sky =
              ComputeClearSky({}, RadFromDeg(elevation_deg), {aerosol, ozone, albedo, 1.0});
          for (int c = 0; c < 3; ++c) {
            EXPECT_TRUE(sky.beam_rgb[c] >= 0.0 && sky.beam_rgb[c] <= 1361.0);
            EXPECT_TRUE(sky.diffuse_rgb[c] >= 0.0 && sky.diffuse_rgb[c] <= 2.0 * 1361.0);
          }
        }
      }
    }
  }
}

TEST(ClearSkyHardCases, RefusesBadInputByName) {
  EXPECT_THAT(ErrorOf([] { ComputeClearSky({}, kNan); }),
              HasSubstr("apparent_elevation_rad is nan"));
  EXPECT_THAT(ErrorOf([] { ComputeClearSky({}, 45.0); }),
              HasSubstr("apparent_elevation_rad is 45"));
  EXPECT_THAT(ErrorOf([] { ComputeClearSky({kNan, 0.0, 0.0}, 0.5); }), HasSubstr("latitude_rad"));
  EXPECT_THAT(ErrorOf([] {
                ComputeClearSky({}, 0.5, {kNan, 0.3, 0.2, 1.0});
              }),
              HasSubstr("aerosol_optical_depth_500nm is nan"));
  EXPECT_THAT(ErrorOf([] {
                ComputeClearSky({}, 0.5, {0.1, 343.8, 0.2, 1.0});
              }),
              HasSubstr("ozone_atm_cm is 343.8"));
  EXPECT_THAT(ErrorOf([] {
                ComputeClearSky({}, 0.5, {0.1, 0.3, 1.2, 1.0});
              }),
              HasSubstr("ground_albedo is 1.2"));
  EXPECT_THAT(ErrorOf([] {
                ComputeClearSky({}, 0.5, {0.1, 0.3, 0.2, 149.6});
              }),
              HasSubstr("sun_distance_au is 149.6"));
}

}  // namespace
}  // namespace pleinair::clear_sky_hard_cases_test
