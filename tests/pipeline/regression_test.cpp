// What counts as worse.
#include "pipeline/regression.h"

#include <chrono>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pleinair::regression_test {
namespace {

using Outcome = FigureComparison::Outcome;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::Pair;
using testing::UnorderedElementsAre;

FigureComparison Compare(const std::string& name,
                         const std::vector<double>& baseline,
                         const std::vector<double>& now) {
  const std::vector<FigureComparison> all = CompareFigures({{name, baseline}}, {{name, now}});
  EXPECT_EQ(all.size(), 1u);
  return all.at(0);
}

// Seeds from 0.02 to 0.03: a noise of 0.01, so up to 0.04 is no worse, from 0.01 on no better.
TEST(Regression, NoiseIsTheSpreadOfTheBaselinesSeeds) {
  const std::vector<double> seeds{0.024, 0.02, 0.03};
  EXPECT_EQ(Compare("sun_error_median", seeds, {0.0399}).outcome, Outcome::kSame);
  EXPECT_EQ(Compare("sun_error_median", seeds, {0.0401}).outcome, Outcome::kWorse);
  EXPECT_EQ(Compare("sun_error_median", seeds, {0.0101}).outcome, Outcome::kSame);
  EXPECT_EQ(Compare("sun_error_median", seeds, {0.0099}).outcome, Outcome::kBetter);
  const FigureComparison worse = Compare("sun_error_median", seeds, {0.05});
  EXPECT_DOUBLE_EQ(*worse.baseline, 0.024);
  EXPECT_NEAR(worse.noise, 0.01, 1e-15);
  EXPECT_NEAR(worse.limit, 0.04, 1e-15);
  EXPECT_THAT(worse.Reason(), HasSubstr("0.05, in the baseline 0.024"));
  EXPECT_THAT(worse.Reason(), HasSubstr("expected 0.04 or less"));
  EXPECT_THAT(worse.Reason(), Not(HasSubstr("\n")));
}

TEST(Regression, MoreIsBetterWhereTheFigureSaysSo) {
  const std::vector<double> seeds{33.0, 34.0};
  EXPECT_EQ(Compare("object_psnr_median_db", seeds, {32.1}).outcome, Outcome::kSame);
  EXPECT_EQ(Compare("object_psnr_median_db", seeds, {31.9}).outcome, Outcome::kWorse);
  EXPECT_EQ(Compare("object_psnr_median_db", seeds, {35.1}).outcome, Outcome::kBetter);
  EXPECT_EQ(Compare("frames_done", {24, 24}, {23}).outcome, Outcome::kWorse);
}

// A fish-eye's figures do not depend on the seed, and still differ a little between machines.
TEST(Regression, RoundingIsNoRegression) {
  EXPECT_EQ(Compare("object_psnr_median_db", {30.0, 30.0}, {29.95}).outcome, Outcome::kSame);
  EXPECT_EQ(Compare("object_psnr_median_db", {30.0, 30.0}, {29.85}).outcome, Outcome::kWorse);
}

TEST(Regression, JudgesTheMedianOfManySeeds) {
  EXPECT_EQ(Compare("sky_error_median", {0.02, 0.03}, {0.9, 0.03, 0.02}).outcome, Outcome::kSame);
}

TEST(Regression, AFigureThatVanishesIsWorseAndANewOneIsNot) {
  const std::vector<FigureComparison> all =
      CompareFigures({{"sky_error_median", {0.02}}}, {{"sun_error_median", {0.01}}});
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].outcome, Outcome::kNew);
  EXPECT_FALSE(all[0].GotWorse());
  EXPECT_THAT(all[0].Reason(), IsEmpty());
  EXPECT_EQ(all[1].outcome, Outcome::kGone);
  EXPECT_TRUE(all[1].GotWorse());
  EXPECT_THAT(all[1].Reason(), HasSubstr("not there any more"));
}

TEST(Regression, WithoutTruthARunIsHeldToWhatItSaysOfItself) {
  RunToJudge run;
  run.frames_failed = 2;
  for (const double share : {0.9, 0.8, 0.7}) {
    FrameFacts& frame = run.done.emplace_back();
    frame.time = UtcTime{std::chrono::hours(24 * static_cast<int>(run.done.size()))};
    frame.sky_irradiance_rgb = {100.0 * share, 100.0, 80.0};
    frame.inlier_fraction = share;
    frame.untouched_share = share < 0.75 ? std::nullopt : std::optional(share);
    frame.light_is_known = share > 0.75;
  }
  run.done[1].glowing_pixels = 5;
  run.done[2].glowing_pixels = 7;
  const std::map<std::string, double> figures = FiguresOf(run);
  EXPECT_THAT(figures,
              UnorderedElementsAre(Pair("frames_done", 3.0),
                                   Pair("frames_failed", 2.0),
                                   Pair("light_hardly_known", 1.0),
                                   Pair("inlier_share_median", 0.8),
                                   Pair("sky_hue_smallest", 0.7),
                                   Pair("untouched_pixels_smallest", 0.8),
                                   Pair("glowing_pixels", 12.0)));
}

TEST(Regression, APersonsJudgmentIsComparedWithTheLight) {
  RunToJudge run;
  const auto add = [&](std::optional<bool> judged, double sun_over_sky) {
    FrameFacts& frame = run.done.emplace_back();
    frame.time = UtcTime{std::chrono::hours(24 * static_cast<int>(run.done.size()))};
    frame.judged_sunshine = judged;
    frame.sun_irradiance_rgb = glm::dvec3(100.0 * sun_over_sky);
    frame.sky_irradiance_rgb = glm::dvec3(100.0);
  };
  add(std::nullopt, 9.0);
  add(true, 4.0);
  add(true, 0.1);
  add(false, 0.02);
  add(false, 0.2);
  const std::map<std::string, double> figures = FiguresOf(run);
  EXPECT_EQ(figures.at("sunshine_right"), 0.75);
  EXPECT_DOUBLE_EQ(figures.at("sunny_sun_over_sky_smallest"), 0.1);
  EXPECT_DOUBLE_EQ(figures.at("sunless_sun_over_sky_largest"), 0.2);
  run.done.resize(1);
  EXPECT_EQ(FiguresOf(run).count("sunshine_right"), 0u) << "nobody has judged";
}

TEST(Regression, FiguresOfAScoreAreItsOwn) {
  Score score;
  score.light.all.frames = 10;
  score.light.all.sun_error = Distribution{10, 0.0, 0.01, 0.05, 0.1};
  score.light.all.sun_colour_angle_rad = Distribution{10, 0.0, std::numbers::pi / 180.0, 0.0, 0.0};
  score.light.all.sun_sigma = SigmaCoverage{30, 0.5, 0.9};
  score.light.well_posed.frames = 4;
  score.light.well_posed.sun_error = Distribution{4, 0.0, 0.02, 0.06, 0.1};
  score.composite.object_psnr_db =
      Distribution{4, 0.0, std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
  std::map<std::string, double> figures = FiguresOf({{}, 0, score});
  EXPECT_EQ(figures.at("sun_error_95th"), 0.05);
  EXPECT_NEAR(figures.at("sun_colour_angle_median_deg"), 1.0, 1e-12);
  EXPECT_EQ(figures.at("sun_within_2_stddev"), 0.9);
  EXPECT_EQ(figures.at("well_posed_sun_error_median"), 0.02);
  EXPECT_EQ(figures.count("object_psnr_median_db"), 0u) << "not a number is not a figure";
  score.light.well_posed.frames = 10;
  figures = FiguresOf({{}, 0, score});
  EXPECT_EQ(figures.count("well_posed_sun_error_median"), 0u) << "all frames are well posed";
}

TEST(Regression, EveryFigureHasANameOfItsOwn) {
  SeededFigures all;
  for (const FigureKind& kind : AllFigureKinds()) AddSeed({{kind.name, 1.0}}, all);
  EXPECT_EQ(all.size(), AllFigureKinds().size());
  EXPECT_EQ(CompareFigures(all, all).size(), all.size());
}

}  // namespace
}  // namespace pleinair::regression_test
