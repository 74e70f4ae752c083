#include "apps/frame_faults.h"

#include <cmath>
#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sunmodel/angles.h"

namespace pleinair::frame_faults_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Frame FrameUnder(int index, std::optional<Weather> stated) {
  Frame frame;
  frame.index = index;
  frame.weather = stated;
  return frame;
}

// With the probabilities of overcast, broken and clear.
FrameResult Looking(double overcast, double broken, double clear) {
  FrameResult result;
  result.estimate.samples_used = 500;
  result.estimate.inlier_fraction = 0.9;
  result.estimate.relative_residual = 0.05;
  result.estimate.weather_shares = {overcast, broken, clear};
  return result;
}

TEST(FrameFaults, NamesTheWeatherThatContradictsTheStatedOne) {
  FrameFaults faults(true);
  faults.Add(FrameUnder(3, Weather::kClear), Looking(0.0, 0.1, 0.9));
  faults.Add(FrameUnder(4, Weather::kClear), Looking(0.9, 0.08, 0.02));
  faults.Add(FrameUnder(5, Weather::kClear), Looking(0.97, 0.03, 0.0));
  EXPECT_THAT(faults.Notes(),
              ElementsAre(HasSubstr(
                  "frames that look overcast, against the stated weather: 2 (first: 4)")));
}

TEST(FrameFaults, CountsFramesWithoutASignOfSunOrShade) {
  FrameResult unsure = Looking(0.25, 0.45, 0.3);
  unsure.drawn_lighting.emplace();
  unsure.is_drawn_without_sun = true;
  FrameFaults faults(true);
  faults.Add(FrameUnder(0, std::nullopt), Looking(0.0, 0.1, 0.9));
  faults.Add(FrameUnder(1, std::nullopt), unsure);
  EXPECT_THAT(faults.Notes(),
              ElementsAre(HasSubstr("drawn without a sun, as they show neither sun "
                                    "nor shade: 1 (first: 1); --weather clear")));
}

TEST(FrameFaults, DoubtsNoWeatherThatMayBeOrThatNobodyStated) {
  FrameFaults faults(true);
  faults.Add(FrameUnder(0, Weather::kClear), Looking(0.7, 0.1, 0.2));
  faults.Add(FrameUnder(1, std::nullopt), Looking(1.0, 0.0, 0.0));
  EXPECT_THAT(faults.Notes(), IsEmpty());
}

TEST(FrameFaults, CountsFramesThatTheModelDoesNotExplain) {
  // Nor is its weather known.
  FrameResult covered = Looking(0.0, 0.1, 0.9);
  covered.estimate.relative_residual = 0.4;
  FrameFaults faults(true);
  faults.Add(FrameUnder(1, std::nullopt), Looking(0.0, 0.1, 0.9));
  faults.Add(FrameUnder(2, Weather::kOvercast), covered);
  EXPECT_THAT(faults.Notes(),
              ElementsAre(HasSubstr("frames that do not fit the model: 1 (first: 2)")));
}

// Without samples the weather is not the picture's.
TEST(FrameFaults, CountsFramesWithoutSamplesWhereTheLightIsMeasuredInThem) {
  FrameResult none = Looking(1.0, 0.0, 0.0);
  none.estimate.samples_used = 0;
  FrameFaults measured(true);
  measured.Add(FrameUnder(7, Weather::kClear), none);
  EXPECT_THAT(measured.Notes(),
              ElementsAre(HasSubstr("frames whose light could not be measured: 1 (first: 7)")));
  FrameFaults given(false);
  given.Add(FrameUnder(7, Weather::kClear), none);
  EXPECT_THAT(given.Notes(), IsEmpty());
}

TEST(FrameFaults, CountsFramesThatContradictTheirSkysPicture) {
  FrameResult gain = Looking(0.0, 0.1, 0.9);
  gain.estimate.sky_camera.is_in_other_units = true;
  FrameResult hidden = Looking(0.0, 0.1, 0.9);
  hidden.estimate.sky_camera.shows_another_sun = true;
  FrameFaults faults(false);
  faults.Add(FrameUnder(3, std::nullopt), gain);
  faults.Add(FrameUnder(4, std::nullopt), hidden);
  EXPECT_THAT(faults.Notes(),
              ElementsAre(HasSubstr("in other units or colours than their own: 1 (first: 3)"),
                          HasSubstr("have another sun than their own: 1 (first: 4)")));
}

FrameResult UnderSunAt(double elevation_deg) {
  FrameResult result = Looking(0.0, 0.1, 0.9);
  const double elevation_rad = RadFromDeg(elevation_deg);
  result.estimate.lighting.sun.direction_enu = {
      std::cos(elevation_rad), 0.0, std::sin(elevation_rad)};
  return result;
}

// A sequence that ends at night is one; a day's that is all at night has wrong times.
TEST(FrameFaults, DoubtsTimesThatAreAllAtNight) {
  FrameFaults faults(true);
  faults.Add(FrameUnder(0, std::nullopt), UnderSunAt(-76.0));
  faults.Add(FrameUnder(1, std::nullopt), UnderSunAt(-12.0));
  EXPECT_THAT(faults.Notes(), ElementsAre(HasSubstr("at least 12 deg below the horizon in all")));
  faults.Add(FrameUnder(2, std::nullopt), UnderSunAt(-4.0));
  EXPECT_THAT(faults.Notes(), IsEmpty()) << "dusk";
  FrameFaults without_sun(true);
  FrameResult none = Looking(0.9, 0.1, 0.0);
  none.estimate.lighting.sun.direction_enu = kNoSunDirectionEnu;
  without_sun.Add(FrameUnder(0, std::nullopt), none);
  EXPECT_THAT(without_sun.Notes(), IsEmpty()) << "as stated";
}

TEST(FrameFaults, NamesPicturesThatShowNothingButObjects) {
  FrameResult result = Looking(0.0, 0.1, 0.9);
  result.composite.change = Gray8Image(4, 3, 255);
  FrameFaults faults(true);
  faults.Add(FrameUnder(2, std::nullopt), result);
  EXPECT_THAT(faults.Notes(),
              ElementsAre(HasSubstr("that virtual objects fill completely: 1 (first: 2)")));
  result.composite.change.At(3, 2) = 128;
  FrameFaults almost(true);
  almost.Add(FrameUnder(2, std::nullopt), result);
  EXPECT_THAT(almost.Notes(), IsEmpty());
}

TEST(FrameFaults, CountsFramesThatTheBudgetHasNoTimeFor) {
  FrameResult result = Looking(0.0, 0.1, 0.9);
  result.plan.fits_budget = false;
  FrameFaults faults(true);
  faults.Add(FrameUnder(5, std::nullopt), result);
  EXPECT_THAT(faults.Notes(), ElementsAre(HasSubstr("longer than the budget: 1 (first: 5)")));
}

TEST(FrameFaults, SumsPixelsOverTheFramesThatHaveThem) {
  Frame frame = FrameUnder(0, std::nullopt);
  FrameFaults faults(false);
  faults.Add(frame, {});
  frame.defects.not_finite = 5;
  FrameResult result;
  result.clamped_pixels = 2;
  faults.Add(frame, result);
  faults.Add(frame, {});
  EXPECT_THAT(faults.Notes(),
              ElementsAre(HasSubstr("10 pixels of 2 frames are not finite"),
                          HasSubstr("2 pixels of 1 frames are beyond half floats")));
}

}  // namespace
}  // namespace pleinair::frame_faults_test
