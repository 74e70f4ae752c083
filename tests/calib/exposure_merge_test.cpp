#include "calib/exposure_merge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "calib/frame_average.h"
#include "scene/srgb.h"
#include "tests/calib/linear_from_code.h"
#include "tests/calib/synthetic_bracket.h"

namespace pleinair::exposure_merge_test {
namespace {

const std::vector<double> kStops{4.0, 1.0, 0.25, 0.0625};

// The merged light lies on the true one: no bias beyond the mean's own noise, and as far from it as
// the standard deviations say (chi squared per pixel 1; rounding is not quite Gaussian: 10 %).
TEST(MergeExposures, GivesTheLightBackWithItsNoise) {
  const SyntheticBracket bracket =
      MakeBracket([](double linear) { return 255.0 * SrgbFromLinear(linear); }, kStops);
  const MergedExposures merged = MergeExposures(bracket.pictures, ResponseCurve::Srgb());
  double ratio = 0.0;
  double chi_squared = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < merged.radiance.pixels.size(); ++i) {
    if (merged.clipped.pixels[i] != 0 || merged.at_noise_floor.pixels[i] != 0) continue;
    const double truth = bracket.radiance.pixels[i].y;
    // Well inside the bracket's range: near its ends clipping leaves out the high or low half.
    if (truth * 4.0 < 0.02 || truth * 0.0625 > 0.8) continue;
    const double error = merged.radiance.pixels[i].y - truth;
    ratio += error / truth;
    chi_squared += std::pow(error / merged.stddev.pixels[i].y, 2.0);
    ++count;
  }
  EXPECT_GT(count, 30000);
  EXPECT_NEAR(ratio / count, 0.0, 0.002);
  EXPECT_NEAR(chi_squared / count, 1.0, 0.1);
  EXPECT_LT(merged.median_difference, 0.15);  // Its noise.
}

// Long brackets of a small sensor are no different views.
TEST(MergeExposures, PicturesOfOneViewAgreeThoughTheyAreNoisy) {
  const CameraNoise phone{.full_well_electrons = 4000.0, .read_noise_electrons = 6.0};
  const SyntheticBracket bracket =
      MakeBracket([](double linear) { return 255.0 * SrgbFromLinear(linear); },
                  {16.0, 8.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.125, 0.0625},
                  phone);
  EXPECT_LT(MergeExposures(bracket.pictures, ResponseCurve::Srgb()).median_difference, 0.25);
}

TEST(MergeExposures, SaysHowFarPicturesOfDifferentViewsDiffer) {
  SyntheticBracket bracket =
      MakeBracket([](double linear) { return 255.0 * SrgbFromLinear(linear); }, kStops);
  std::ranges::reverse(bracket.pictures[1].codes.pixels);
  EXPECT_GT(MergeExposures(bracket.pictures, ResponseCurve::Srgb()).median_difference, 0.5);
}

TEST(MergeExposures, FlagsWhatIsClippedEverywhereAndKeepsItsBound) {
  const ResponseCurve srgb = ResponseCurve::Srgb();
  std::vector<ExposedPicture> pictures{{Rgb8Image(3, 1, glm::u8vec3(255)), 1.0},
                                       {Rgb8Image(3, 1, glm::u8vec3(100)), 0.1}};
  pictures[1].codes.pixels[1] = glm::u8vec3(100, 254, 100);
  pictures[1].codes.pixels[2] = glm::u8vec3(255);
  const MergedExposures merged = MergeExposures(pictures, srgb);
  EXPECT_EQ(merged.clipped.pixels, (std::vector<std::uint8_t>{0, 1, 1}));
  const float of_100 = LinearFromCode(srgb, glm::u8vec3(100)).x;
  EXPECT_NEAR(merged.radiance.pixels[0].x, of_100 / 0.1f, 1e-4f);
  EXPECT_NEAR(merged.radiance.pixels[1].x, of_100 / 0.1f, 1e-4f);
  EXPECT_GT(merged.radiance.pixels[1].y, 9.8f) << "254 of the shortest exposure";
  EXPECT_FLOAT_EQ(merged.radiance.pixels[2].x, 10.0f);
}

TEST(MergeExposures, FlagsWhatIsDarkEverywhere) {
  std::vector<ExposedPicture> pictures{{Rgb8Image(2, 1, glm::u8vec3(2)), 1.0},
                                       {Rgb8Image(2, 1, glm::u8vec3(0)), 0.1}};
  pictures[0].codes.pixels[1] = glm::u8vec3(40);
  const MergedExposures merged = MergeExposures(pictures, ResponseCurve::Srgb());
  EXPECT_EQ(merged.at_noise_floor.pixels, (std::vector<std::uint8_t>{1, 0}));
  EXPECT_EQ(merged.clipped.pixels, (std::vector<std::uint8_t>{0, 0}));
  EXPECT_LT(merged.radiance.pixels[0].x, LinearFromCode(ResponseCurve::Srgb(), {3, 3, 3}).x);
}

// A camera that clips at code 200: its curve is flat from there on, and no code of that end counts.
TEST(MergeExposures, LeavesOutTheCurvesFlatEnd) {
  ResponseTable table{};
  for (auto& channel : table) {
    for (int code = 0; code < 256; ++code) {
      channel[static_cast<std::size_t>(code)] = static_cast<float>(std::min(code, 200)) / 200.0f;
    }
  }
  const std::vector<ExposedPicture> pictures{{Rgb8Image(1, 1, glm::u8vec3(201)), 1.0},
                                             {Rgb8Image(1, 1, glm::u8vec3(199)), 0.5},
                                             {Rgb8Image(1, 1, glm::u8vec3(100)), 0.1}};
  const MergedExposures merged = MergeExposures(pictures, ResponseCurve::FromTable(table));
  EXPECT_EQ(merged.clipped.pixels[0], 0);
  EXPECT_NEAR(merged.radiance.pixels[0].x, 5.0f, 1e-5f);
}

TEST(MergeExposures, RefusesWhatCannotBeMerged) {
  const ResponseCurve srgb = ResponseCurve::Srgb();
  EXPECT_THROW(MergeExposures({}, srgb), std::invalid_argument);
  std::vector<ExposedPicture> pictures{{Rgb8Image(2, 2), 1.0}, {Rgb8Image(2, 1), 0.5}};
  EXPECT_THROW(MergeExposures(pictures, srgb), std::invalid_argument);
  pictures[1] = {Rgb8Image(2, 2), 0.0};
  EXPECT_THROW(MergeExposures(pictures, srgb), std::invalid_argument);
  pictures[1].exposure = std::nan("");
  EXPECT_THROW(MergeExposures(pictures, srgb), std::invalid_argument);
  pictures[1].exposure = 1.0;
  EXPECT_THROW(MergeExposures(pictures, srgb, {0.0, 7.0}), std::invalid_argument);
}

// 64 frames of noise 0.1: the mean's error is 0.1 / 8, and the average says so itself (its own
// relative error is 1 / sqrt(2 * 63) a pixel, over 3000 values 0.2 %).
TEST(FrameAverage, FallsWithTheRootOfTheNumber) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal(0.0f, 0.1f);
  FrameAverage average;
  for (int frame = 0; frame < 64; ++frame) {
    RgbImage image(50, 20);
    for (glm::vec3& pixel : image.pixels) {
      pixel = 1e4f + glm::vec3(normal(random), normal(random), normal(random));
    }
    average.Add(image);
  }
  EXPECT_EQ(average.FrameCount(), 64);
  const RgbImage mean = average.Mean();
  const RgbImage error = average.StandardError();
  double squared = 0.0;
  double claimed = 0.0;
  for (std::size_t i = 0; i < mean.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      squared += std::pow(mean.pixels[i][c] - 1e4, 2.0) / 3000.0;
      claimed += error.pixels[i][c] * error.pixels[i][c] / 3000.0;
    }
  }
  // Floats near 1e4 round to 1e-3.
  EXPECT_NEAR(std::sqrt(squared), 0.0125, 0.0125 * 0.06);
  EXPECT_NEAR(std::sqrt(claimed), 0.0125, 0.0125 * 0.02);
}

TEST(FrameAverage, LeavesOutWhatIsNotFinite) {
  FrameAverage average;
  RgbImage image(2, 1, glm::vec3(1.0f));
  average.Add(image);
  EXPECT_TRUE(std::isinf(average.StandardError().pixels[0].x));
  image.pixels[0] = glm::vec3(3.0f);
  image.pixels[1] = glm::vec3(1.0f, std::numeric_limits<float>::quiet_NaN(), 1.0f);
  average.Add(image);
  EXPECT_EQ(average.Mean().pixels[0], glm::vec3(2.0f));
  EXPECT_EQ(average.Mean().pixels[1], glm::vec3(1.0f));
  EXPECT_EQ(average.StandardError().pixels[0], glm::vec3(1.0f));
  EXPECT_EQ(average.LeftOutCount(), 1);
  EXPECT_THROW(average.Add(RgbImage(1, 2)), std::invalid_argument);
  EXPECT_THROW(FrameAverage().Add(RgbImage()), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::exposure_merge_test
