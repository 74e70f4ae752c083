// Light of frames that show neither sun nor shade.
#include "pipeline/unproven_sun.h"

#include <array>
#include <chrono>
#include <cstddef>
#include <iterator>

#include <gtest/gtest.h>

#include "estimation/light_component.h"

namespace pleinair::unproven_sun_test {
namespace {

using namespace std::chrono_literals;

constexpr double kSun = 500.0;
constexpr double kSky = 200.0;
constexpr double kSunOnLevelGround = 0.5;  // The sine of its elevation.

// What level ground says alone: the sum on it, but hardly how it is shared. The sky is of two
// shapes. `sun_stddev` is absolute, `common` relative.
Lighting SumOnLevelGround(double sun_stddev, double common = 0.0) {
  Lighting lighting;
  lighting.sun.irradiance_rgb = glm::dvec3(kSun);
  lighting.sky = {{"uniform", glm::dvec3(0.75 * kSky)}, {"overcast", glm::dvec3(0.25 * kSky)}};
  lighting.common_stddev_rgb = glm::dvec3(common);
  const double by_sun[] = {1.0, -0.75 * kSunOnLevelGround, -0.25 * kSunOnLevelGround};
  const std::size_t side = SideOf(lighting);
  lighting.covariance.assign(side * side, 0.0);
  for (std::size_t u = 0; u < side; ++u) {
    for (std::size_t v = u % 3; v < side; v += 3) {
      lighting.covariance[u * side + v] =
          sun_stddev * sun_stddev * by_sun[u / 3] * by_sun[v / 3] +
          common * common * Component(lighting, u) * Component(lighting, v);
    }
  }
  return lighting;
}

LightingEstimate Estimate(double sun_stddev,
                          const std::array<double, std::size(kAllWeathers)>& weather_shares,
                          std::chrono::seconds time = 0s) {
  LightingEstimate estimate;
  estimate.lighting = SumOnLevelGround(sun_stddev);
  estimate.lighting.time = UtcTime{} + time;
  estimate.weather_shares = weather_shares;
  return estimate;
}

constexpr std::array kUnsure{0.25, 0.45, 0.30};  // The climate's own.
constexpr double kUnknown = 400.0;
constexpr double kKnown = 20.0;

TEST(LightWithoutSun, KeepsTheBrightnessOfLevelGround) {
  for (const double common : {0.0, 0.25}) {
    const Lighting without = LightWithoutSun(SumOnLevelGround(kUnknown, common));
    EXPECT_EQ(without.sun.irradiance_rgb, glm::dvec3(0.0));
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(without.SkyIrradianceRgb()[c], kSky + kSunOnLevelGround * kSun, 1e-9) << common;
      EXPECT_NEAR(without.sky[0].irradiance_rgb[c], 3.0 * without.sky[1].irradiance_rgb[c], 1e-9);
    }
    EXPECT_EQ(MeanSunIrradiance(without).stddev, 0.0);
    EXPECT_GT(MeanSkyIrradiance(without).stddev, 0.0);
  }
}

// Of a sun that has only the common factor's deviation: what rounding leaves is no slope.
TEST(LightWithoutSunHardCases, RoundingOfTheCommonFactorIsNoCovariance) {
  for (const double common : {0.1, 0.25, 0.3, 0.77}) {
    const Lighting lighting = SumOnLevelGround(0.0, common);
    const Lighting without = LightWithoutSun(lighting);
    EXPECT_EQ(without.SkyIrradianceRgb(), lighting.SkyIrradianceRgb()) << common;
  }
}

// Shaded walls show the sky by itself: it stays where it does not depend on the sun.
TEST(LightWithoutSun, KeepsASkyThatIsKnownByItself) {
  Lighting lighting = SumOnLevelGround(kUnknown);
  const std::size_t side = SideOf(lighting);
  for (std::size_t u = 3; u < side; ++u) {
    for (std::size_t c = 0; c < 3; ++c) {
      lighting.covariance[u * side + c] = lighting.covariance[c * side + u] = 0.0;
    }
  }
  EXPECT_EQ(LightWithoutSun(lighting).SkyIrradianceRgb(), lighting.SkyIrradianceRgb());
}

TEST(LightWithoutSunHardCases, IsNeverNegative) {
  Lighting lighting = SumOnLevelGround(kUnknown);
  const std::size_t side = SideOf(lighting);
  for (std::size_t c = 0; c < 3; ++c) {  // The more sun, the more sky: without sun there is none.
    lighting.covariance[(3 + c) * side + c] = 2.0 * kUnknown * kUnknown;
    lighting.covariance[c * side + 3 + c] = 2.0 * kUnknown * kUnknown;
  }
  const Lighting without = LightWithoutSun(lighting);
  EXPECT_EQ(without.sky[0].irradiance_rgb, glm::dvec3(0.0));
  Lighting black = lighting;
  black.sun.irradiance_rgb = glm::dvec3(0.0);
  black.covariance.assign(side * side, 0.0);
  EXPECT_EQ(LightWithoutSun(black).SkyIrradianceRgb(), lighting.SkyIrradianceRgb());
  black.covariance.clear();
  EXPECT_EQ(LightWithoutSun(black).SkyIrradianceRgb(), lighting.SkyIrradianceRgb());
}

TEST(UnprovenSun, IsDrawnWhereItIsLikelyOrKnown) {
  EXPECT_TRUE(UnprovenSun().Without(Estimate(kUnknown, kUnsure)));
  EXPECT_TRUE(UnprovenSun().Without(Estimate(kUnknown, {0.5, 0.4, 0.1})));
  EXPECT_FALSE(UnprovenSun().Without(Estimate(kKnown, kUnsure)));
  EXPECT_FALSE(UnprovenSun().Without(Estimate(kUnknown, {0.1, 0.3, 0.6})));
  LightingEstimate given = Estimate(kUnknown, kUnsure);
  given.weather_shares.reset();
  EXPECT_FALSE(UnprovenSun().Without(given)) << "its source does not estimate the weather";
  LightingEstimate covered = Estimate(kUnknown, kUnsure);
  covered.samples_used = 500;
  covered.relative_residual = 0.5;
  EXPECT_FALSE(UnprovenSun().Without(covered)) << "the picture shows something else";
}

// From 0.6 on; once drawn, it stays down to 0.5.
TEST(UnprovenSun, DoesNotComeAndGoWithASmallDoubt) {
  const auto with_probability = [](double probability) {
    return Estimate(kUnknown, {1.0 - probability, 0.0, probability});
  };
  UnprovenSun sun;
  EXPECT_TRUE(sun.Without(with_probability(0.59)));
  EXPECT_FALSE(sun.Without(with_probability(0.61)));
  EXPECT_FALSE(sun.Without(with_probability(0.51)));
  EXPECT_TRUE(sun.Without(with_probability(0.49)));
  EXPECT_TRUE(sun.Without(with_probability(0.59)));
}

// A held frame has the light of those before it, whatever its own picture seems to show.
TEST(UnprovenSun, HeldFramesAreDrawnAsTheOnesBefore) {
  LightingEstimate covered = Estimate(kUnknown, {0.0, 0.0, 1.0});
  covered.relative_residual = 2.0;
  UnprovenSun without;
  EXPECT_TRUE(without.Without(Estimate(kUnknown, kUnsure)));
  EXPECT_TRUE(without.Without(covered, true));
  EXPECT_FALSE(without.Without(covered, false));
  UnprovenSun with;
  EXPECT_FALSE(with.Without(Estimate(kUnknown, {0.0, 0.0, 1.0})));
  const LightingEstimate overcast = Estimate(kUnknown, {1.0, 0.0, 0.0});
  EXPECT_FALSE(with.Without(overcast, true));
  EXPECT_TRUE(with.Without(overcast, false));
}

// Before sunrise all is known of a sun that is not there, and nothing of the day's.
TEST(UnprovenSun, IsNotKnownByNight) {
  LightingEstimate night = Estimate(kUnknown, kUnsure);
  night.weather_shares.reset();
  for (std::size_t c = 0; c < 3; ++c) {
    night.lighting.sun.irradiance_rgb = glm::dvec3(0.0);
    ScaleDeviations(c, 0.0, night.lighting);
  }
  UnprovenSun sun;
  EXPECT_FALSE(sun.Without(night));
  EXPECT_TRUE(sun.Without(Estimate(kUnknown, kUnsure, 10s)));
}

// A cloud, or a camera that looks aside, does not make the shadow come and go. The clock may be set
// back.
TEST(UnprovenSun, IsHeldForAnHourAfterItWasKnown) {
  UnprovenSun sun;
  EXPECT_TRUE(sun.Without(Estimate(kUnknown, kUnsure, 0s)));
  EXPECT_FALSE(sun.Without(Estimate(kKnown, kUnsure, 10s)));
  EXPECT_FALSE(sun.Without(Estimate(kUnknown, kUnsure, 3610s)));
  EXPECT_TRUE(sun.Without(Estimate(kUnknown, kUnsure, 3611s)));
  EXPECT_FALSE(sun.Without(Estimate(kUnknown, kUnsure, -3590s)));
  EXPECT_TRUE(sun.Without(Estimate(kUnknown, kUnsure, -3591s)));
}

}  // namespace
}  // namespace pleinair::unproven_sun_test
