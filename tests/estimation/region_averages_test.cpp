#include "estimation/region_averages.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/estimation/synthetic_fisheye.h"

namespace pleinair::region_averages_test {
namespace {

constexpr int kSidePx = 101;  // Odd: runs of every length, multiples of four and others.

RgbImage RandomPicture(std::mt19937& random) {
  std::uniform_real_distribution<float> value(0.0f, 5.0f);
  RgbImage picture(kSidePx, kSidePx);
  for (glm::vec3& pixel : picture.pixels) pixel = {value(random), value(random), value(random)};
  return picture;
}

// Pixel by pixel, in double precision. `radiance` holds what each pixel counts as.
std::vector<glm::dvec3> AveragesOf(const FisheyePixelTable& table,
                                   const SkyRegions& regions,
                                   const std::vector<glm::dvec3>& radiance) {
  std::vector<glm::dvec3> sum(regions.Count(), glm::dvec3(0.0));
  std::vector<double> weight(regions.Count(), 0.0);
  for (std::size_t pixel = 0; pixel < radiance.size(); ++pixel) {
    const double solid_angle_sr = table.solid_angle_sr.pixels[pixel];
    const auto region = regions.RegionOf(glm::dvec3(table.direction_world.pixels[pixel]));
    if (!(solid_angle_sr > 0.0) || !region || !std::isfinite(radiance[pixel].x)) continue;
    sum[*region] += solid_angle_sr * radiance[pixel];
    weight[*region] += solid_angle_sr;
  }
  for (std::size_t region = 0; region < sum.size(); ++region) sum[region] /= weight[region];
  return sum;
}

TEST(RegionAverages, AgreesWithSumsPixelByPixel) {
  std::mt19937 random(1);
  const FisheyePixelTable table = MakeFisheyePixelTable(testing::SkyCamera(kSidePx));
  const SkyRegions regions;
  RgbImage picture = RandomPicture(random);
  const std::size_t middle = table.direction_world.Index(kSidePx / 2, kSidePx / 2);
  const auto replaced_pixel = static_cast<std::uint32_t>(middle + 3);
  const glm::vec3 replacement(100.0f, 200.0f, 300.0f);
  std::vector<glm::dvec3> counts_as(picture.pixels.begin(), picture.pixels.end());
  counts_as[replaced_pixel] = glm::dvec3(replacement);
  // Defects left out, one of each kind, alone and side by side.
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<glm::vec3> defects{
      {nan, 1.0f, 1.0f}, {1.0f, std::numeric_limits<float>::infinity(), 1.0f}, {1.0f, 1.0f, -1.0f}};
  for (std::size_t i = 0; i < defects.size(); ++i) {
    for (const std::size_t pixel : {middle + 10 * kSidePx + 7 * i, middle - 12 * kSidePx + i}) {
      picture.pixels[pixel] = defects[i];
      counts_as[pixel] = glm::dvec3(std::numeric_limits<double>::quiet_NaN());
    }
  }
  RegionAverages averages(table, regions);
  averages.Average(picture, std::vector{replaced_pixel}, replacement);
  const std::vector<glm::dvec3> expected = AveragesOf(table, regions, counts_as);
  ASSERT_EQ(averages.Radiance().size(), expected.size());
  for (std::size_t region = 0; region < expected.size(); ++region) {
    for (int c = 0; c < 3; ++c) {
      // Some 50 terms of a row in single precision, half a rounding each.
      EXPECT_NEAR(
          averages.Radiance()[region][c], expected[region][c], 50 * 6e-8 * expected[region][c])
          << "region " << region;
    }
  }
}

TEST(RegionAverages, KeepsNothingOfEarlierPictures) {
  std::mt19937 random(2);
  const FisheyePixelTable table = MakeFisheyePixelTable(testing::SkyCamera(kSidePx));
  const RgbImage picture = RandomPicture(random);
  RegionAverages kept(table, SkyRegions());
  kept.Average(RandomPicture(random), {}, glm::vec3(0.0f));
  kept.Average(picture, {}, glm::vec3(0.0f));
  RegionAverages fresh(table, SkyRegions());
  fresh.Average(picture, {}, glm::vec3(0.0f));
  for (std::size_t region = 0; region < fresh.Radiance().size(); ++region) {
    EXPECT_EQ(kept.Radiance()[region], fresh.Radiance()[region]);
  }
}

// A picture without a good pixel measures nothing: black, not NaN.
TEST(RegionAverages, IsBlackWhereNoPixelIsMeasured) {
  const FisheyePixelTable table = MakeFisheyePixelTable(testing::SkyCamera(kSidePx));
  RgbImage picture(kSidePx, kSidePx);
  for (glm::vec3& pixel : picture.pixels) {
    pixel = glm::vec3(std::numeric_limits<float>::quiet_NaN());
  }
  RegionAverages averages(table, SkyRegions());
  averages.Average(picture, {}, glm::vec3(0.0f));
  for (const glm::dvec3& radiance : averages.Radiance()) EXPECT_EQ(radiance, glm::dvec3(0.0));
}

}  // namespace
}  // namespace pleinair::region_averages_test
