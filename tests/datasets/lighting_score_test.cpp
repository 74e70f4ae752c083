#include "datasets/lighting_score.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "datasets/statistics.h"

namespace pleinair::lighting_score_test {
namespace {

TruthFrame Truth(glm::dvec3 sun, glm::dvec3 sky) {
  TruthFrame truth;
  truth.sun_direction_enu = {0.0, -0.6, 0.8};
  truth.sun_irradiance_rgb = sun;
  truth.sky_irradiance_rgb = sky;
  return truth;
}

// Places 0, 1, 2, 3 hold 1, 2, 4, 8: share 0.95 is place 2.85, 4 + 0.85 * 4.
TEST(Percentile, InterpolatesBetweenOrderStatistics) {
  EXPECT_DOUBLE_EQ(Percentile({8.0, 1.0, 4.0, 2.0}, 0.5), 3.0);
  EXPECT_DOUBLE_EQ(Percentile({8.0, 1.0, 4.0, 2.0}, 0.95), 7.4);
  EXPECT_DOUBLE_EQ(Percentile({8.0, 1.0, 4.0, 2.0}, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(Percentile({8.0, 1.0, 4.0, 2.0}, 1.0), 8.0);
  EXPECT_DOUBLE_EQ(Percentile({5.0}, 0.95), 5.0);
  EXPECT_THROW(Percentile({}, 0.5), std::invalid_argument);
  EXPECT_THROW(Percentile({1.0}, std::nan("")), std::invalid_argument);
  EXPECT_FALSE(DistributionOf({}));
}

TEST(Median, IsNoneOfNoValues) {
  EXPECT_EQ(Median({8.0, 1.0, 4.0, 2.0}), 3.0);
  EXPECT_EQ(Median({}), std::nullopt);
}

TEST(LightScore, IsZeroForTheTruthItself) {
  const TruthFrame truth = Truth({900.0, 800.0, 700.0}, {60.0, 90.0, 150.0});
  const RecordedLight estimate{truth.sun_direction_enu,
                               truth.sun_irradiance_rgb,
                               truth.sky_irradiance_rgb,
                               glm::dvec3(0.0),
                               glm::dvec3(1.0)};
  const auto score = ScoreLight(estimate, truth, 800.0, glm::dvec3(900.0));
  ASSERT_TRUE(score);
  EXPECT_EQ(score->sun_error, 0.0);
  EXPECT_EQ(score->sky_error, 0.0);
  EXPECT_NEAR(*score->sun_colour_angle_rad, 0.0, 1e-12);
  EXPECT_NEAR(*score->sun_direction_error_rad, 0.0, 1e-12);
  EXPECT_EQ(*score->sun_error_sigmas, glm::dvec3(0.0));
  EXPECT_EQ(score->SaysWhatItDoesNotKnow(), true);
}

// By hand: sun off by (30, 0, -60) of a largest sun of 1000: mean 30 / 1000. Sky off by 20 of 100.
TEST(LightScore, DividesTheSunByTheLargestAndTheSkyByItsOwn) {
  const TruthFrame truth = Truth({500.0, 500.0, 500.0}, {80.0, 100.0, 120.0});
  const RecordedLight estimate{glm::dvec3(0.0, 0.0, 1.0),
                               glm::dvec3(530.0, 500.0, 440.0),
                               glm::dvec3(100.0, 120.0, 140.0),
                               glm::dvec3(20.0, 10.0, 10.0),
                               glm::dvec3(30.0)};
  const auto score = ScoreLight(estimate, truth, 1000.0, glm::dvec3(900.0, 800.0, 700.0));
  ASSERT_TRUE(score);
  EXPECT_NEAR(*score->sun_error, 0.030, 1e-12);
  EXPECT_NEAR(*score->sky_error, 0.2, 1e-12);
  EXPECT_NEAR(*score->sun_direction_error_rad, std::atan2(0.6, 0.8), 1e-12);
  EXPECT_EQ(*score->sun_error_sigmas, glm::dvec3(1.5, 0.0, 6.0));
  EXPECT_NEAR(*score->sun_stddev_of_clear_beam, (40.0 / 3.0) / 800.0, 1e-12);
  EXPECT_EQ(score->SaysWhatItDoesNotKnow(), false);
  // Colours apart: strength alone has no angle.
  const auto brighter = ScoreLight({{}, glm::dvec3(700.0), {}, {}, {}}, truth, 1000.0, {});
  EXPECT_NEAR(*brighter->sun_colour_angle_rad, 0.0, 1e-7);
  EXPECT_FALSE(brighter->sky_error);
  EXPECT_FALSE(brighter->SaysWhatItDoesNotKnow());
}

// Three times the truth's light has its ratio of sun to sky; 10 % more sun in red alone is a mean
// of 0.1 / 3. A sun of 4 % of the largest has no ratio worth the name.
TEST(LightScore, HoldsRelativeLightToTheRatioOfSunToSky) {
  const TruthFrame truth = Truth({500.0, 500.0, 500.0}, {80.0, 100.0, 120.0});
  const RecordedLight estimate{{},
                               glm::dvec3(1650.0, 1500.0, 1500.0),
                               glm::dvec3(240.0, 300.0, 360.0),
                               glm::dvec3(1.0),
                               glm::dvec3(1.0),
                               LightUnits::kRelativePerFrame};
  const auto score = ScoreLight(estimate, truth, 1000.0, {});
  EXPECT_NEAR(*score->sun_to_sky_error, 0.1 / 3.0, 1e-12);
  EXPECT_FALSE(score->sun_error || score->sky_error);
  EXPECT_FALSE(score->sun_colour_angle_rad || score->sky_colour_angle_rad);
  EXPECT_FALSE(score->sun_error_sigmas || score->sky_error_sigmas);
  EXPECT_FALSE(ScoreLight(estimate, truth, 12500.0, {})->sun_to_sky_error);
  const RecordedLight no_sky{{}, glm::dvec3(1650.0), glm::dvec3(0.0), {}, {}};
  EXPECT_FALSE(ScoreLight(no_sky, truth, 1000.0, {})->sun_to_sky_error);
}

// Twice too much and half as much are as wrong, whatever the exposure and white balance.
TEST(LightScore, ComparesSunOverSkyAsALogarithm) {
  const TruthFrame truth = Truth({500.0, 500.0, 500.0}, {80.0, 100.0, 120.0});
  const RecordedLight estimate{
      {}, glm::dvec3(1000.0, 250.0, 15.0), glm::dvec3(80.0, 100.0, 3.6), {}, {}};
  const glm::dvec3 error = LogSunOverSkyError(estimate, truth, 500.0).value();
  EXPECT_NEAR(error.x, std::log(2.0), 1e-12);
  EXPECT_NEAR(error.y, std::log(2.0), 1e-12);
  EXPECT_NEAR(error.z, 0.0, 1e-12);
  const RecordedLight no_sun{{}, glm::dvec3(0.0), glm::dvec3(100.0), {}, {}};
  EXPECT_EQ(LogSunOverSkyError(no_sun, truth, 500.0)->y, std::log(100.0));
  const RecordedLight no_sky{{}, glm::dvec3(500.0), glm::dvec3(0.0), {}, {}};
  EXPECT_EQ(LogSunOverSkyError(no_sky, truth, 500.0)->y, std::log(100.0));
  EXPECT_FALSE(LogSunOverSkyError({}, truth, 500.0));
  EXPECT_FALSE(LogSunOverSkyError(estimate, truth, 1e6)) << "the true sun is noise";
}

TEST(LightScore, IsEmptyForBlackLight) {
  const TruthFrame overcast = Truth(glm::dvec3(0.0), glm::dvec3(200.0));
  const RecordedLight estimate{{}, glm::dvec3(0.0), glm::dvec3(0.0), glm::dvec3(0.0), {}};
  const auto score = ScoreLight(estimate, overcast, 0.0, glm::dvec3(0.0));
  ASSERT_TRUE(score);
  EXPECT_FALSE(score->sun_error);
  EXPECT_FALSE(score->sun_colour_angle_rad);
  EXPECT_FALSE(score->sky_colour_angle_rad);
  EXPECT_FALSE(score->sun_stddev_of_clear_beam);
  EXPECT_EQ(*score->sun_error_sigmas, glm::dvec3(0.0));
  EXPECT_EQ(score->sky_error, 1.0);
  EXPECT_FALSE(ScoreLight({}, overcast, 1.0, glm::dvec3(0.0)));
}

// A certain estimate that is wrong is infinitely many standard deviations off, and not hidden.
TEST(LightScore, CountsAWrongCertaintyAsOutside) {
  const TruthFrame truth = Truth(glm::dvec3(500.0), glm::dvec3(100.0));
  const auto score =
      ScoreLight({{}, glm::dvec3(501.0), {}, glm::dvec3(0.0), {}}, truth, 500.0, glm::dvec3(500.0));
  EXPECT_TRUE(std::isinf(score->sun_error_sigmas->x));
  const LightSummary summary = SummariseLight({*score});
  EXPECT_EQ(summary.sun_sigma->within_2, 0.0);
}

// Normal errors with the stated deviation: 68.3 % and 95.4 % within 1 and 2; the tolerance is four
// standard deviations of a share over 3 * 4000 draws.
TEST(LightSummary, CoversASCalibratedErrorsDo) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0.0, 7.0);
  const TruthFrame truth = Truth(glm::dvec3(500.0), glm::dvec3(100.0));
  std::vector<LightScore> scores;
  for (int i = 0; i < 4000; ++i) {
    const glm::dvec3 error(normal(random), normal(random), normal(random));
    scores.push_back(*ScoreLight({{}, truth.sun_irradiance_rgb + error, {}, glm::dvec3(7.0), {}},
                                 truth,
                                 500.0,
                                 glm::dvec3(500.0)));
  }
  const LightSummary summary = SummariseLight(scores);
  EXPECT_EQ(summary.sun_sigma->count, 12000);
  EXPECT_NEAR(summary.sun_sigma->within_1, 0.6827, 4.0 * std::sqrt(0.6827 * 0.3173 / 12000.0));
  EXPECT_NEAR(summary.sun_sigma->within_2, 0.9545, 4.0 * std::sqrt(0.9545 * 0.0455 / 12000.0));
  EXPECT_FALSE(summary.sky_sigma);
  EXPECT_EQ(summary.frames, 4000);
}

TEST(LargestTrueSun, IsTheMeanOfTheBrightestFrame) {
  EXPECT_EQ(LargestTrueSun({Truth({0.0, 0.0, 900.0}, {}), Truth({400.0, 400.0, 400.0}, {})}),
            400.0);
  EXPECT_EQ(LargestTrueSun({}), 0.0);
}

}  // namespace
}  // namespace pleinair::lighting_score_test
