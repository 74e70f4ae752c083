// Figures of plausibility against made light and pictures whose answer is known.
#include "pipeline/plausibility.h"

#include <chrono>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace pleinair::plausibility_test {
namespace {

using std::chrono::minutes;

FrameFacts LitBy(const glm::dvec3& sun, const glm::dvec3& sky, minutes after = minutes(0)) {
  FrameFacts frame;
  frame.time = UtcTime{std::chrono::hours(12)} + after;
  frame.sun_irradiance_rgb = sun;
  frame.sky_irradiance_rgb = sky;
  return frame;
}

// A grey picture, nothing of which is changed.
struct Picture {
  RgbImage camera{64, 48, glm::vec3(1.0f)};
  Composite composite{camera, Gray8Image(64, 48, 0)};

  void Change(int x, int y, PixelChange change, const glm::vec3& rgb) {
    composite.change.At(x, y) = static_cast<std::uint8_t>(change);
    composite.radiance.At(x, y) = rgb;
  }
  std::int64_t Glowing() const { return CountGlowingPixels(camera, composite); }
};

TEST(Plausibility, HueIsOfTheWeakestChannel) {
  EXPECT_DOUBLE_EQ(*SkyHue(LitBy({}, {1e-6, 50.0, 100.0})), 1e-8);
  EXPECT_DOUBLE_EQ(*SkyHue(LitBy({}, {80.0, 90.0, 100.0})), 0.8);
  EXPECT_FALSE(SkyHue(LitBy({}, {}))) << "night";
}

TEST(Plausibility, SunOverSkyIsOfMeansAndNeverUndefined) {
  EXPECT_DOUBLE_EQ(SunOverSky(LitBy({900.0, 800.0, 700.0}, {80.0, 100.0, 120.0})), 8.0);
  EXPECT_DOUBLE_EQ(SunOverSky(LitBy({}, {})), 0.0);
  EXPECT_TRUE(std::isinf(SunOverSky(LitBy(glm::dvec3(1.0), {}))));
  EXPECT_TRUE(ShowsSun(LitBy(glm::dvec3(120.0), glm::dvec3(400.0))));
  EXPECT_FALSE(ShowsSun(LitBy(glm::dvec3(50.0), glm::dvec3(400.0))));
}

TEST(Plausibility, StepsAreLogRatiosOfSuccessiveFrames) {
  const glm::dvec3 sky(100.0);
  const std::vector<FrameFacts> frames{LitBy(3.0 * sky, sky),
                                       LitBy(3.0 * sky, 1.1 * sky, minutes(10)),
                                       LitBy(7.0 * sky, sky, minutes(70))};
  EXPECT_NEAR(*LargestSkyStep(frames), std::log(1.1), 1e-12);
  EXPECT_NEAR(*LargestContrastStep(frames), std::log(8.0 / (1.0 + 3.0 / 1.1)), 1e-12);
}

// A sun that comes out, months, and an unknown exposure are no fault of the light's.
TEST(Plausibility, NoStepIsTakenWhereLightMayMove) {
  const glm::dvec3 sky(100.0);
  std::vector<FrameFacts> frames{LitBy({}, sky), LitBy(9.0 * sky, 3.0 * sky, minutes(61))};
  EXPECT_FALSE(LargestContrastStep(frames));
  frames[1].time = frames[0].time;
  EXPECT_TRUE(LargestContrastStep(frames));
  frames[0].judged_sunshine = false;
  frames[1].judged_sunshine = true;
  EXPECT_FALSE(LargestContrastStep(frames));
  frames[0].judged_sunshine = true;
  frames[1].has_common_unit = false;
  EXPECT_TRUE(LargestContrastStep(frames));
  EXPECT_FALSE(LargestSkyStep(frames));
}

TEST(PlausibilityHardCases, StepsToAndFromNothingAreFinite) {
  const glm::dvec3 light(100.0);
  const double most = std::log(100.0);
  EXPECT_DOUBLE_EQ(*LargestSkyStep({LitBy({}, light), LitBy({}, {})}), most);
  EXPECT_DOUBLE_EQ(*LargestSkyStep({LitBy({}, {}), LitBy({}, light)}), most);
  EXPECT_DOUBLE_EQ(*LargestContrastStep({LitBy(light, {}), LitBy({}, light)}), most);
  EXPECT_DOUBLE_EQ(*LargestContrastStep({LitBy({}, {}), LitBy({}, {})}), 0.0);
}

TEST(Plausibility, ARealPixelGlowsWhereNothingAroundIsHalfAsBright) {
  Picture picture;
  picture.Change(30, 20, PixelChange::kScaled, glm::vec3(1.9f));
  EXPECT_EQ(picture.Glowing(), 0);
  picture.Change(30, 20, PixelChange::kScaled, glm::vec3(0.1f, 2.1f, 0.1f));
  EXPECT_EQ(picture.Glowing(), 1);
  picture.camera.At(46, 36) = glm::vec3(1.1f);
  EXPECT_EQ(picture.Glowing(), 0) << "16 px off in both directions";
  picture.camera.At(46, 36) = glm::vec3(1.0f);
  picture.camera.At(47, 36) = glm::vec3(1.1f);
  EXPECT_EQ(picture.Glowing(), 1) << "17 px off";
  picture.Change(20, 20, PixelChange::kCovered, glm::vec3(1.1f));
  EXPECT_EQ(picture.Glowing(), 0) << "beside a bright object";
}

TEST(PlausibilityHardCases, PixelsThatAreNoNumberGlowAndLendNoLight) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Picture picture;
  picture.camera.At(30, 21) = glm::vec3(nan, 9.0f, 9.0f);
  picture.Change(30, 20, PixelChange::kScaled, glm::vec3(2.1f));
  picture.Change(5, 5, PixelChange::kScaled, glm::vec3(nan));
  picture.Change(6, 5, PixelChange::kScaled, glm::vec3(std::numeric_limits<float>::infinity()));
  EXPECT_EQ(picture.Glowing(), 3);
  EXPECT_EQ(CountGlowingPixels({}, {}), 0);
}

TEST(Plausibility, UntouchedPixelsAreTheCamerasBitForBit) {
  Picture picture;
  EXPECT_EQ(UntouchedShare(picture.camera, picture.composite), 1.0);
  picture.Change(3, 3, PixelChange::kNone, glm::vec3(1.0f, 1.0f, 1.0001f));
  EXPECT_DOUBLE_EQ(*UntouchedShare(picture.camera, picture.composite), 1.0 - 1.0 / (64 * 48));
  const auto covered = static_cast<std::uint8_t>(PixelChange::kCovered);
  picture.composite.change = Gray8Image(64, 48, covered);
  EXPECT_FALSE(UntouchedShare(picture.camera, picture.composite));
}

}  // namespace
}  // namespace pleinair::plausibility_test
