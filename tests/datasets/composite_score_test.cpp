#include "datasets/composite_score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "scene/srgb.h"

namespace pleinair::composite_score_test {
namespace {

// Radiance that a display shows as this code value at exposure 1, rounded to half precision as a
// composite's file would (9 bits to spare at these values: 1e-3 relative, 0.05 codes).
float RadianceOfCode(double code) { return static_cast<float>(LinearFromSrgb(code / 255.0)); }

struct Scene {
  Scene() : input(4, 2, glm::vec3(0.25f)) {
    composite = input;
    with_object = input;
    coverage = Gray8Image(4, 2);
    change = Gray8Image(4, 2);
  }
  CompositeScore Score() const {
    return ScoreComposite({input,
                           composite,
                           input,
                           with_object,
                           coverage,
                           &change,
                           has_specular ? &specular : nullptr,
                           1.0});
  }
  RgbImage input;
  RgbImage composite;
  RgbImage with_object;
  Gray8Image coverage;
  Gray8Image change;
  Gray8Image specular{4, 2};
  bool has_specular = false;
};

TEST(CompositeScore, IsPerfectWhereNothingIsToBeDone) {
  const CompositeScore score = Scene().Score();
  EXPECT_FALSE(score.object_psnr_db);
  EXPECT_FALSE(score.object_psnr_without_specular_db);
  EXPECT_FALSE(score.effect_psnr_db);
  EXPECT_EQ(score.identical_outside_mask, 1.0);
  EXPECT_EQ(score.changed_of_unchanged, 0.0);
}

// Two flat pictures differ by their means alone: SSIM is (2 a b + c) / (a^2 + b^2 + c), c the
// constant of the means, 2.55^2.
TEST(CompositeScore, SimilarityOfFlatPicturesIsThatOfTheirMeans) {
  Scene scene;
  scene.input = RgbImage(32, 20, glm::vec3(RadianceOfCode(100.0)));
  scene.with_object = scene.input;
  scene.composite = RgbImage(32, 20, glm::vec3(RadianceOfCode(120.0)));
  scene.coverage = Gray8Image(32, 20);
  scene.change = Gray8Image(32, 20);
  EXPECT_FALSE(scene.Score().similarity);
  scene.coverage.At(7, 5) = scene.coverage.At(20, 15) = 1;
  const double expected =
      (2.0 * 100.0 * 120.0 + 2.55 * 2.55) / (100.0 * 100.0 + 120.0 * 120.0 + 2.55 * 2.55);
  EXPECT_NEAR(*scene.Score().similarity, expected, 1e-5);  // Float radiances.
  scene.composite = scene.with_object;
  EXPECT_NEAR(*scene.Score().similarity, 1.0, 1e-12);
}

// Noise of variance v on a flat reference: a window has no covariance with it, so that SSIM is
// about c / (v + c), c the constant of the variances, 7.65^2.
TEST(CompositeScore, NoiseIsNotStructure) {
  Scene scene;
  scene.input = RgbImage(64, 64, glm::vec3(RadianceOfCode(100.0)));
  scene.with_object = scene.composite = scene.input;
  std::mt19937 random(3);
  std::normal_distribution<double> gauss(100.0, 15.0);
  for (glm::vec3& pixel : scene.composite.pixels) {
    pixel = glm::vec3(RadianceOfCode(std::clamp(gauss(random), 1.0, 254.0)));
  }
  scene.coverage = Gray8Image(64, 64, 255);
  scene.change = Gray8Image(64, 64);
  // A window of about 28 independent pixels estimates the variance to a quarter, and 1 / v is skew.
  const double expected = 7.65 * 7.65 / (15.0 * 15.0 + 7.65 * 7.65);
  EXPECT_NEAR(*scene.Score().similarity, expected, 0.15 * expected);
}

// Off by 10 codes in every channel of every object pixel: 20 log10(255 / 10) = 28.13 dB.
TEST(CompositeScore, MeasuresTheObjectInCodeValues) {
  Scene scene;
  scene.coverage.At(0, 0) = scene.coverage.At(1, 0) = 255;
  scene.coverage.At(2, 0) = 254;  // The edge belongs to no set, however wrong.
  scene.composite.At(2, 0) = glm::vec3(1.0f);
  for (int x = 0; x < 2; ++x) {
    scene.with_object.At(x, 0) = glm::vec3(RadianceOfCode(100.0));
    scene.composite.At(x, 0) = glm::vec3(RadianceOfCode(110.0));
  }
  CompositeScore score = scene.Score();
  EXPECT_EQ(score.object_pixels, 2);
  EXPECT_NEAR(*score.object_psnr_db, 20.0 * std::log10(25.5), 1e-4);
  EXPECT_FALSE(score.object_psnr_without_specular_db);
  EXPECT_EQ(score.changed_of_unchanged, 0.0);

  scene.has_specular = true;
  scene.specular.At(0, 0) = 1;
  scene.composite.At(0, 0) = glm::vec3(1.0f);
  score = scene.Score();
  EXPECT_LT(*score.object_psnr_db, 10.0);
  EXPECT_NEAR(*score.object_psnr_without_specular_db, 20.0 * std::log10(25.5), 1e-4);
}

// A shadow that the composite has half as deep: 137.0 -> 117 in truth, 127 in the composite.
TEST(CompositeScore, MeasuresTheEffectBesideTheObject) {
  Scene scene;
  scene.with_object.At(3, 1) = glm::vec3(RadianceOfCode(117.0));
  scene.composite.At(3, 1) = glm::vec3(RadianceOfCode(127.0));
  scene.with_object.At(2, 1) = glm::vec3(RadianceOfCode(255.0 * SrgbFromLinear(0.25) + 1.9));
  const CompositeScore score = scene.Score();
  EXPECT_EQ(score.effect_pixels, 1);
  EXPECT_NEAR(*score.effect_psnr_db, 20.0 * std::log10(25.5), 1e-4);
  // The pixel of 1.9 codes is in neither set.
  EXPECT_EQ(score.changed_of_unchanged, 0.0);
}

TEST(CompositeScore, CountsWhatChangedWithoutReason) {
  Scene scene;
  const double code = 255.0 * SrgbFromLinear(0.25);
  scene.composite.At(0, 0) = glm::vec3(RadianceOfCode(code + 1.1));
  scene.composite.At(1, 0) = glm::vec3(RadianceOfCode(code + 0.9));
  scene.change.At(0, 0) = 128;
  const CompositeScore score = scene.Score();
  EXPECT_EQ(score.changed_of_unchanged, 1.0 / 8.0);
  // Of the 7 pixels that the mask calls untouched one is not the camera's own.
  EXPECT_EQ(score.identical_outside_mask, 6.0 / 7.0);
}

TEST(CompositeScore, ComparesWithTheInputInHalfPrecision) {
  Scene scene;
  scene.input.At(0, 0) = glm::vec3(0.1f);
  scene.composite.At(0, 0) = glm::vec3(0.0999755859375f);  // 0.1 as a half.
  scene.input.At(1, 0) = glm::vec3(std::numeric_limits<float>::quiet_NaN());
  scene.composite.At(1, 0) = scene.input.At(1, 0);
  EXPECT_EQ(scene.Score().identical_outside_mask, 1.0);
  EXPECT_EQ(CountIdenticalPixels(scene.input, scene.composite), 8);
  scene.composite.At(0, 0) = glm::vec3(0.10003662109375f);  // The next half.
  EXPECT_EQ(CountIdenticalPixels(scene.input, scene.composite), 7);
}

TEST(CompositeScore, ClipsAsTheDisplayDoes) {
  Scene scene;
  scene.coverage.At(0, 0) = 255;
  scene.with_object.At(0, 0) = glm::vec3(3.0f);
  scene.composite.At(0, 0) = glm::vec3(60000.0f);
  EXPECT_EQ(scene.Score().object_psnr_db, kHighestPsnrDb);
}

TEST(CompositeScore, RefusesPicturesOfOtherSizes) {
  Scene scene;
  scene.coverage = Gray8Image(2, 4);
  EXPECT_THROW(scene.Score(), std::invalid_argument);
  scene = Scene();
  scene.composite = RgbImage(3, 2);
  EXPECT_THROW(scene.Score(), std::invalid_argument);
  EXPECT_THROW(CountIdenticalPixels(scene.input, scene.composite), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::composite_score_test
