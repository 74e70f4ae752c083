#include "estimation/weather_belief.h"

#include <chrono>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "tests/estimation/synthetic_scene.h"

namespace pleinair::weather_belief_test {
namespace {

using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;
using testing::SyntheticClearSky;

const UtcTime kNoon{hours(12)};

const WeatherLight& StateOf(const WeatherBelief& belief, SkyState state) {
  return belief.states[static_cast<std::size_t>(state)];
}

SkyClimate Climate() { return MakeSkyClimate(SyntheticClearSky()); }

SurveyedLight Overcast() {
  return {.time = kNoon,
          .sun_rgb = glm::dvec3(0.0),
          .sun_stddev_rgb = glm::dvec3(0.0),
          .sky_rgb = {190.0, 195.0, 200.0},
          .clear_sky = SyntheticClearSky()};
}

SurveyedLight Clear() {
  return {.time = kNoon,
          .sun_rgb = {840.0, 790.0, 700.0},
          .sun_stddev_rgb = {8.0, 8.0, 7.0},
          .sky_rgb = {85.0, 100.0, 120.0},
          .clear_sky = SyntheticClearSky()};
}

void ExpectSameBelief(const WeatherBelief& a, const WeatherBelief& b, double tolerance) {
  for (std::size_t s = 0; s < kSkyStates; ++s) {
    EXPECT_NEAR(a.states[s].share, b.states[s].share, tolerance);
    if (b.states[s].share == 0.0) continue;  // Nobody asks for its light.
    EXPECT_TRUE(a.states[s].light.mean.isApprox(b.states[s].light.mean, tolerance));
    EXPECT_TRUE(a.states[s].light.covariance.isApprox(b.states[s].light.covariance, tolerance));
  }
}

TEST(WeatherBelief, ASurveysLightDecidesItsWeather) {
  const WeatherBelief overcast = BeliefFromSurvey(Overcast());
  EXPECT_GT(
      StateOf(overcast, SkyState::kOvercast).share + StateOf(overcast, SkyState::kCoveredSun).share,
      0.99);
  EXPECT_GT(StateOf(BeliefFromSurvey(Clear()), SkyState::kClear).share, 0.7);
}

// A survey's shadows may say that there was no sun, to a part of the sky.
TEST(WeatherBelief, ASunOfNoneKeepsItsDeviation) {
  SurveyedLight survey = Overcast();
  survey.sun_rgb = glm::dvec3(0.0);
  survey.sun_stddev_rgb = 0.2 * survey.sky_rgb;
  const WeatherBelief belief = BeliefFromSurvey(survey);
  const LightGaussian& light = StateOf(belief, SkyState::kOvercast).light;
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(
        std::sqrt(light.covariance(c, c)), 0.2 * survey.sky_rgb[c], 0.01 * survey.sky_rgb[c]);
  }
}

// A sun that the map clips is assumed to be a clear sky's, give or take 60 %. However grey the
// map's sky, a sun of nearly nothing is no error of 60 %: hours later a covered sun is the
// climate's share, and not what the survey showed. Where the map did not see the sun's place it may
// be.
TEST(WeatherBelief, ASunThatOutshoneItsSkyWasNotCovered) {
  SurveyedLight survey = Clear();
  survey.sun_rgb = SyntheticClearSky().beam_rgb;
  survey.sun_stddev_rgb = 0.6 * survey.sun_rgb;
  const auto sunless = [&] {
    const WeatherBelief belief = BeliefFromSurvey(survey);
    return StateOf(belief, SkyState::kCoveredSun).share +
           StateOf(belief, SkyState::kOvercast).share;
  };
  for (const double grey : {100.0, 130.0, 160.0}) {
    survey.sky_rgb = grey * glm::dvec3(0.97, 1.0, 1.03);
    survey.clear_sky.gain_stddev = 0.5;
    survey.sun_may_be_covered = false;
    EXPECT_LT(sunless(), 0.01) << grey;
    survey.sun_may_be_covered = true;
    EXPECT_GT(sunless(), 0.2) << grey;
  }
}

// An overcast morning is no sunny noon: what was wrong with a prior that relaxed to a clear sky.
TEST(WeatherBelief, AnOvercastHourStaysOvercast) {
  const WeatherBelief survey = BeliefFromSurvey(Overcast());
  for (const auto gap : {seconds(1), seconds(10), seconds(600), seconds(3600)}) {
    const WeatherBelief now = Predict(survey, Climate(), kNoon + gap);
    const double sunless =
        StateOf(now, SkyState::kOvercast).share + StateOf(now, SkyState::kCoveredSun).share;
    EXPECT_GT(sunless, 0.75) << gap.count() << " s";
  }
}

TEST(WeatherBelief, ForgetsNothingAtOnceAndAllInTheEnd) {
  const WeatherBelief survey = BeliefFromSurvey(Clear());
  ExpectSameBelief(Predict(survey, Climate(), kNoon), survey, 1e-9);
  ExpectSameBelief(Predict(survey, Climate(), kNoon + hours(24 * 30)),
                   BeliefFromClimate(Climate(), kNoon),
                   1e-6);
}

TEST(WeatherBelief, BeforeAndAfterAreAlike) {
  const WeatherBelief survey = BeliefFromSurvey(Clear());
  ExpectSameBelief(Predict(survey, Climate(), kNoon + minutes(7)),
                   Predict(survey, Climate(), kNoon - minutes(7)),
                   1e-12);
}

// The sun comes and goes among broken clouds within minutes, while their sky goes on.
TEST(WeatherBelief, AmongBrokenCloudsTheSunIsSoonTheClimates) {
  WeatherBelief covered = BeliefFromClimate(Climate(), kNoon);
  for (WeatherLight& state : covered.states) state.share = 0.0;
  covered.states[static_cast<std::size_t>(SkyState::kCoveredSun)].share = 1.0;
  const WeatherBelief soon = Predict(covered, Climate(), kNoon + minutes(5));
  EXPECT_GT(StateOf(soon, SkyState::kSunAmongClouds).share, 0.2);
  EXPECT_LT(StateOf(soon, SkyState::kOvercast).share, 0.05);
}

// 10^3 random gaps and weathers, with correlated climates whose units are hardly known: shares add
// up to 1, and every covariance is positive definite.
TEST(WeatherBelief, IsADistributionAtAllTimes) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform;
  for (int trial = 0; trial < 1000; ++trial) {
    SurveyedLight survey = uniform(random) < 0.5 ? Overcast() : Clear();
    survey.sun_rgb *= uniform(random);
    SkyClimate climate = Climate();
    for (SkyClimate::State& state : climate.states) AddGainError(0.5, state.light);
    const auto gap = seconds(static_cast<int>(std::pow(10.0, 6.0 * uniform(random))));
    const WeatherBelief now = Predict(BeliefFromSurvey(survey), climate, kNoon + gap);
    double sum = 0.0;
    for (const WeatherLight& state : now.states) {
      sum += state.share;
      const Eigen::SelfAdjointEigenSolver<SunAndSkyMatrix> eigen(state.light.covariance);
      ASSERT_GT(eigen.eigenvalues().minCoeff(), 0.0) << "trial " << trial;
    }
    ASSERT_NEAR(sum, 1.0, 1e-9);
  }
}

// A clear noon's survey says of a clear evening that it is clear, not that it is as bright.
TEST(WeatherBelief, GoesWithTheSun) {
  ClearSkyExpectation evening = SyntheticClearSky();
  evening.beam_rgb *= 0.5;
  evening.diffuse_rgb *= 0.6;
  WeatherBelief belief = BeliefFromSurvey(Clear());
  const WeatherBelief noon = belief;
  FollowTheSun(Climate(), Climate(), belief);
  ExpectSameBelief(belief, noon, 1e-12);

  FollowTheSun(Climate(), MakeSkyClimate(evening), belief);
  const LightGaussian& clear = StateOf(belief, SkyState::kClear).light;
  const LightGaussian& before = StateOf(noon, SkyState::kClear).light;
  EXPECT_NEAR(clear.mean[1], 0.5 * before.mean[1], 1e-9);
  EXPECT_GT(clear.mean[4], 0.5 * before.mean[4]);
  EXPECT_LT(clear.mean[4], 0.6 * before.mean[4] + 1e-9);
  EXPECT_NEAR(clear.covariance(0, 0), 0.25 * before.covariance(0, 0), 1e-9);

  // At night there is nothing to go by, and nothing breaks.
  evening.beam_rgb = glm::dvec3(0.0);
  FollowTheSun(Climate(), MakeSkyClimate(evening), belief);
  FollowTheSun(MakeSkyClimate(evening), Climate(), belief);
  for (const WeatherLight& state : belief.states) {
    const Eigen::SelfAdjointEigenSolver<SunAndSkyMatrix> eigen(state.light.covariance);
    EXPECT_GT(eigen.eigenvalues().minCoeff(), 0.0);
  }
}

TEST(WeatherBelief, RescalesWithThePicture) {
  WeatherBelief belief = BeliefFromSurvey(Clear());
  const WeatherBelief before = belief;
  Rescale({2.0, 3.0, 4.0}, belief);
  EXPECT_DOUBLE_EQ(belief.states[0].light.mean[1], 3.0 * before.states[0].light.mean[1]);
  EXPECT_DOUBLE_EQ(belief.states[0].light.mean[5], 4.0 * before.states[0].light.mean[5]);
  EXPECT_DOUBLE_EQ(belief.states[0].light.covariance(0, 4),
                   6.0 * before.states[0].light.covariance(0, 4));
}

}  // namespace
}  // namespace pleinair::weather_belief_test
