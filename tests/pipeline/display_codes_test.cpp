#include "pipeline/display_codes.h"

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "scene/srgb.h"

namespace pleinair::display_codes_test {
namespace {

// IEC 61966-2-1; between two codes the curve is treated as straight: its second difference there,
// at most a twentieth of a code.
TEST(DisplayCodes, FollowTheCamerasCurve) {
  const DisplayCodes codes(ResponseCurve::Srgb(), 0.01);
  for (double linear = 0.0; linear <= 1.0; linear += 1.0 / 977.0) {
    const auto radiance = static_cast<float>(100.0 * linear);
    EXPECT_NEAR(codes.Code(1, radiance), 255.0 * SrgbFromLinear(linear), 0.05) << linear;
  }
  EXPECT_EQ(codes.Code(0, 1e6f), 255.0f);
  EXPECT_EQ(codes.Code(0, -1.0f), 0.0f);
  EXPECT_EQ(codes.Code(0, std::numeric_limits<float>::quiet_NaN()), 0.0f);
}

// An S-shaped curve too, whose steepest part is in the middle.
TEST(DisplayCodes, NoRiseIsAboveItsBound) {
  ResponseTable table;
  for (auto& channel : table) {
    for (std::size_t i = 0; i < 256; ++i) {
      const double x = static_cast<double>(i) / 255.0;
      channel[i] = static_cast<float>(0.5 - 0.5 * std::cos(3.14159265 * std::pow(x, 1.5)));
    }
  }
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  for (const ResponseCurve& response : {ResponseCurve::Srgb(), ResponseCurve::FromTable(table)}) {
    const DisplayCodes codes(response, 0.5);
    for (int i = 0; i < 10000; ++i) {
      const float least = 2.0f * uniform(random);
      const float base = least + 2.0f * uniform(random);
      const float added = 0.5f * uniform(random) * uniform(random);
      const float bound = codes.LargestRise(glm::vec3(least), glm::vec3(added, 0.0f, 0.0f));
      // Rounding of codes near 255.
      EXPECT_GE(bound + 1e-4f, codes.Code(0, base + added * uniform(random)) - codes.Code(0, base));
    }
  }
}

TEST(DisplayCodes, AnUnstatedExposureBringsTheBrightPartNearWhite) {
  RgbImage picture(100, 1, glm::vec3(2.0f));
  picture.pixels[0] = glm::vec3(1e6f);
  EXPECT_NEAR(ChosenExposure(picture), 0.4, 1e-6);
  EXPECT_EQ(ChosenExposure(RgbImage(4, 4)), 1.0);
  EXPECT_THROW(DisplayCodes(ResponseCurve::Srgb(), 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::display_codes_test
