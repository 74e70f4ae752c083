// What counts as worse.
#include "pipeline/regression.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pleinair::regression_test {
namespace {

using Outcome = FigureComparison::Outcome;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

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
  RunFacts facts;
  facts.frames_done = 3;
  facts.inlier_fraction = {0.9, 0.8, 0.7};
  facts.untouched_pixels = {1.0, 0.99};
  const std::map<std::string, double> figures = FiguresOf(facts, nullptr);
  EXPECT_EQ(figures.size(), 3u);
  EXPECT_EQ(figures.at("frames_done"), 3.0);
  EXPECT_EQ(figures.at("inlier_share_median"), 0.8);
  EXPECT_EQ(figures.at("untouched_pixels_smallest"), 0.99);
}

TEST(Regression, FiguresOfAScoreAreItsOwn) {
  Score score;
  score.light.all.frames = 10;
  score.light.all.sun_error = Distribution{10, 0.0, 0.01, 0.05, 0.1};
  score.light.well_posed.frames = 4;
  score.light.well_posed.sun_error = Distribution{4, 0.0, 0.02, 0.06, 0.1};
  score.composite.object_psnr_db =
      Distribution{4, 0.0, std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
  std::map<std::string, double> figures = FiguresOf({}, &score);
  EXPECT_EQ(figures.at("sun_error_95th"), 0.05);
  EXPECT_EQ(figures.at("well_posed_sun_error_median"), 0.02);
  EXPECT_EQ(figures.count("object_psnr_median_db"), 0u) << "not a number is not a figure";
  score.light.well_posed.frames = 10;
  figures = FiguresOf({}, &score);
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
