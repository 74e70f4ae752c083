#include "estimation/lighting_prior.h"

#include <chrono>
#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "tests/estimation/synthetic_scene.h"

namespace pleinair::lighting_prior_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::SyntheticClearSky;

const UtcTime kNoon{std::chrono::hours(12)};

CarriedLighting Earlier() {
  CarriedLighting earlier;
  earlier.time = kNoon;
  earlier.mean = LightVector(6);
  earlier.mean << 800.0, 760.0, 690.0, 90.0, 105.0, 120.0;
  earlier.covariance = 100.0 * LightMatrix::Identity(6, 6);
  return earlier;
}

double SunSigma(const LightingPrior& prior) { return 1.0 / std::sqrt(prior.information(0, 0)); }

double SunMean(const LightingPrior& prior) {
  return prior.information.ldlt().solve(prior.information_times_mean)[0];
}

LightingPrior After(std::chrono::nanoseconds gap) {
  return MakeLightingPrior(SyntheticClearSky(), Earlier(), kNoon + gap, 1);
}

TEST(LightingPrior, TakesTheSunToBeAnywhereUnderTheBeam) {
  const LightingPrior prior = MakeLightingPrior(SyntheticClearSky(), std::nullopt, kNoon, 1);
  const double beam = SyntheticClearSky().beam_rgb.x;
  EXPECT_NEAR(SunMean(prior), 0.5 * beam, 1e-9 * beam);
  // No sun and the whole beam are equally likely, and both within two sigma.
  EXPECT_LT(0.5 * beam / SunSigma(prior), 2.0);
  EXPECT_LT(SunSigma(prior), 0.4 * beam);
}

TEST(LightingPrior, FadesFromTheEarlierAnswerToTheClearSky) {
  const double beam = SyntheticClearSky().beam_rgb.x;
  EXPECT_NEAR(SunMean(After(milliseconds(33))), Earlier().mean[0], 0.01 * beam);
  double last_sigma = 0.0;
  double last_mean = Earlier().mean[0] + 1.0;
  for (int gap_s = 0; gap_s <= 600; gap_s += 5) {
    const LightingPrior prior = After(seconds(gap_s));
    EXPECT_GE(SunSigma(prior), last_sigma * (1.0 - 1e-9)) << gap_s;
    EXPECT_LE(SunMean(prior), last_mean * (1.0 + 1e-9)) << gap_s;
    EXPECT_LE(SunSigma(prior), kSunPriorSigma * beam * (1.0 + 1e-9)) << gap_s;
    if (gap_s > 0) {
      EXPECT_LT(last_mean - SunMean(prior), 0.05 * beam) << gap_s;
    }
    last_sigma = SunSigma(prior);
    last_mean = SunMean(prior);
  }
  // Ten times the weather's memory: e^-20 is left, so the cut behind it is no jump.
  EXPECT_NEAR(last_mean, kSunPriorMean * beam, 1e-6 * beam);
  EXPECT_NEAR(last_sigma, kSunPriorSigma * beam, 1e-6 * beam);
}

TEST(LightingPrior, ForgetsAnAnswerFromLaterOrLongAgo) {
  const LightingPrior fresh = MakeLightingPrior(SyntheticClearSky(), std::nullopt, kNoon, 1);
  EXPECT_EQ(After(seconds(-1)).information, fresh.information);
  EXPECT_EQ(After(seconds(601)).information, fresh.information);
  EXPECT_EQ(After(std::chrono::hours(24 * 365 * 90)).information, fresh.information);
}

// A chain of frames that see nothing must not talk itself into certainty.
TEST(LightingPrior, CarryingNothingAtAllAddsNothing) {
  const double beam = SyntheticClearSky().beam_rgb.x;
  std::optional<CarriedLighting> carried;
  LightVector mean(6);
  UtcTime time = kNoon;
  for (int frame = 0; frame < 1000; ++frame, time += milliseconds(33)) {
    const LightingPrior prior = MakeLightingPrior(SyntheticClearSky(), carried, time, 1);
    mean = prior.information.ldlt().solve(prior.information_times_mean);
    carried = CarryForward(SyntheticClearSky(), carried, time, mean, LightMatrix::Zero(6, 6));
  }
  EXPECT_NEAR(mean[0], kSunPriorMean * beam, 1e-6 * beam);
  EXPECT_NEAR(std::sqrt(carried->covariance(0, 0)), kSunPriorSigma * beam, 0.01 * beam);
}

TEST(LightingPrior, KnowsOnlyTheRatioWithoutASurvey) {
  ClearSkyExpectation relative = SyntheticClearSky();
  relative.absolute = false;
  const LightingPrior prior = MakeLightingPrior(relative, std::nullopt, kNoon, 1);
  EXPECT_FALSE(prior.SaysSomething());
  EXPECT_NEAR(prior.sun_to_sky_rgb.x, 850.0 / 70.0, 1e-12);
  EXPECT_EQ(prior.sun_to_sky_weight, 1.0);
}

TEST(LightingPrior, IsSilentWhereNothingIsKnown) {
  const LightingPrior prior = MakeLightingPrior({}, std::nullopt, kNoon, 1);
  EXPECT_FALSE(prior.SaysSomething());
  EXPECT_EQ(prior.sun_to_sky_rgb, glm::dvec3(0.0));
}

TEST(LightingPrior, RefusesAnImpossibleNumberOfSkyShapes) {
  EXPECT_THROW(LightingPrior::Nothing(0), std::invalid_argument);
  EXPECT_THROW(LightingPrior::Nothing(kMaxSkyShapes + 1), std::invalid_argument);
}

// The survey counts as an answer at its time and fades into the clear sky, before it and after.
TEST(LightingPrior, TheSurveyIsAnEarlierAnswer) {
  const SurveyedLight survey{.time = UtcTime{std::chrono::hours(10)},
                             .sun_rgb = {3.0, 2.0, 1.0},
                             .sun_stddev_rgb = {0.3, 0.2, 0.1},
                             .sky_rgb = {90.0, 100.0, 110.0}};
  ClearSkyExpectation clear_sky;
  clear_sky.beam_rgb = glm::dvec3(800.0);
  clear_sky.diffuse_rgb = glm::dvec3(80.0);
  clear_sky.absolute = true;
  const auto mean_at = [&](std::chrono::seconds after) {
    const UtcTime time = survey.time + after;
    const LightingPrior prior =
        MakeLightingPrior(clear_sky, CarryFromSurvey(survey, time, 3), time, 3);
    // Tells the shares apart, too, so that it has a mean.
    EXPECT_TRUE(prior.information.ldlt().isPositive());
    return LightVector(prior.information.ldlt().solve(prior.information_times_mean));
  };
  const LightVector now = mean_at(std::chrono::seconds(0));
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(now[c], survey.sun_rgb[c], 1e-6 * 800.0);
    EXPECT_NEAR(now[3 + c] + now[6 + c] + now[9 + c], survey.sky_rgb[c], 1e-6 * 800.0);
  }
  const double before = mean_at(std::chrono::seconds(-60))[0];
  const double after = mean_at(std::chrono::seconds(60))[0];
  EXPECT_NEAR(before, after, 1e-6 * 800.0);
  EXPECT_GT(after, 100.0);
  EXPECT_LT(after, kSunPriorMean * 800.0);
}

}  // namespace
}  // namespace pleinair::lighting_prior_test
