// A day at the bundled courtyard before anything is recorded there.
#include "session/check/site_forecast.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimation/outdoor_lighting_source.h"
#include "pipeline/light_trials.h"
#include "scene/stopwatch.h"
#include "sunmodel/time_text.h"
#include "tests/session/bundled_courtyard.h"

namespace pleinair::site_forecast_test {
namespace {

using std::chrono::minutes;

class SiteForecast : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    options_ = BundledCourtyard();
    loaded_ = LoadSequence(options_);
  }
  static void TearDownTestSuite() { loaded_.reset(); }

  static SiteDay Midsummer(minutes step) {
    return ForecastDay(*loaded_, options_, ParseUtcTime("2005-06-21T12:00:00Z"), step);
  }
  // For what does not depend on the light in its pictures.
  static SiteDay MidsummerOfCoarseViews(minutes step) {
    SessionOptions coarse = options_;
    coarse.pipeline.view.receiver_block_px = 32;
    coarse.pipeline.view.sun_block_px = 8;
    return ForecastDay(*loaded_, coarse, ParseUtcTime("2005-06-21T12:00:00Z"), step);
  }

  inline static SessionOptions options_;
  inline static std::shared_ptr<const LoadedSequence> loaded_;
};

TEST_F(SiteForecast, IsOfTheHoursFromSunriseToSunset) {
  const SiteDay day = Midsummer(minutes(240));
  ASSERT_GE(day.hours.size(), 4u);
  for (const SiteHour& hour : day.hours) {
    EXPECT_GE(hour.light.time, *day.sun.sunrise);
    EXPECT_LE(hour.light.time, *day.sun.sunset);
    EXPECT_EQ(hour.light.time.time_since_epoch() % minutes(240), minutes(0));
    EXPECT_LE(hour.light.lit_share + hour.light.shaded_share, 1.0);
  }
}

// The deviations are those that real pictures of clear hours give: within a factor of 2, as the
// haze, the camera's exposure and what passes through the real picture are others.
TEST_F(SiteForecast, DeviationsAreThoseOfTheRecordedFrames) {
  const auto frames = MakeRecordedFrameSource(loaded_->sequence, FrameKind::kLinear);
  LightTrials trials(loaded_->scene, loaded_->sequence.site, {});
  LightForecaster forecaster(
      loaded_->scene, *loaded_->sequence.site, loaded_->sequence.CameraOfFrame(0));
  int compared = 0;
  while (const auto frame = frames->Next()) {
    std::vector<std::unique_ptr<LightingSource>> sources;
    sources.push_back(MakeOutdoorLightingSource({}));
    const auto recorded = trials.Process(**frame, sources);
    ASSERT_TRUE(recorded && recorded->front());
    const LightingEstimate& estimate = recorded->front()->estimate;
    const MeanIrradiance sun = MeanSunIrradiance(estimate.lighting);
    const LightForecast forecast = forecaster.At((*frame)->time);
    ASSERT_TRUE(forecast.sun_relative_stddev && forecast.sky_relative_stddev);
    const MeanIrradiance clear = {(forecast.sun_irradiance_rgb.x + forecast.sun_irradiance_rgb.y +
                                   forecast.sun_irradiance_rgb.z) /
                                  3.0};
    if (sun.mean < 0.8 * clear.mean) continue;  // A cloud.
    ++compared;
    const double ratio = *forecast.sun_relative_stddev / (sun.stddev / sun.mean);
    EXPECT_GT(ratio, 0.5) << FormatUtcTime((*frame)->time);
    EXPECT_LT(ratio, 2.0) << FormatUtcTime((*frame)->time);
  }
  EXPECT_GE(compared, 2);
}

// The estimate finds the light that the picture was made with, to four of its own deviations.
TEST_F(SiteForecast, TheEstimateFindsThePredictedLight) {
  int known = 0;
  for (const SiteHour& hour : Midsummer(minutes(180)).hours) {
    if (!SunWillBeKnown(hour)) continue;
    ++known;
    const Lighting& lighting = (*hour.light.estimate)->lighting;
    const MeanIrradiance sun = MeanSunIrradiance(lighting);
    const glm::dvec3& made = hour.light.sun_irradiance_rgb;
    EXPECT_NEAR(sun.mean, (made.x + made.y + made.z) / 3.0, 4.0 * sun.stddev)
        << FormatUtcTime(hour.light.time);
  }
  EXPECT_GE(known, 2);
}

TEST_F(SiteForecast, SunReachesTheObjectAsARayFromItDoes) {
  const SiteDay day = MidsummerOfCoarseViews(minutes(60));
  const auto lit = [](const SiteHour& hour) { return hour.sun_on_objects.value_or(0.0) > 0.9; };
  // The courtyard's object stands in the open: in the sun at noon, behind buildings at sunrise.
  const auto noon = std::find_if(day.hours.begin(), day.hours.end(), [&](const SiteHour& hour) {
    return hour.light.time >= day.sun.noon;
  });
  ASSERT_NE(noon, day.hours.end());
  EXPECT_TRUE(lit(*noon));
  EXPECT_FALSE(lit(day.hours.front()));
}

TEST_F(SiteForecast, PromisesNothingWhileTheSunIsDown) {
  LightForecaster forecaster(
      loaded_->scene, *loaded_->sequence.site, loaded_->sequence.CameraOfFrame(0));
  const LightForecast midnight = forecaster.At(ParseUtcTime("2005-06-21T23:20:00Z"));
  EXPECT_FALSE(midnight.estimate);
  EXPECT_FALSE(midnight.sun_relative_stddev);
  EXPECT_EQ(midnight.lit_share, 0.0);
}

TEST_F(SiteForecast, AStepOfADayIsNoon) {
  const SiteDay day =
      ForecastDay(*loaded_, options_, ParseUtcTime("2005-06-21T12:00:00Z"), minutes(1440));
  ASSERT_EQ(day.hours.size(), 1u);
  EXPECT_EQ(day.hours[0].light.time, day.sun.noon);
}

TEST_F(SiteForecast, KeepsPicturesOfSomeHoursAlone) {
  const SiteDay day = MidsummerOfCoarseViews(minutes(40));
  ASSERT_GT(day.hours.size(), kMostDayPictures);
  std::size_t pictures = 0;
  for (const SiteHour& hour : day.hours) pictures += hour.light.picture.pixels.empty() ? 0 : 1;
  EXPECT_LE(pictures, kMostDayPictures);
  EXPECT_GE(pictures, kMostDayPictures - 1);  // One may be of the sun at the horizon.
}

TEST_F(SiteForecast, RefusesAStepOfNothing) {
  EXPECT_THROW(Midsummer(minutes(0)), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::site_forecast_test
