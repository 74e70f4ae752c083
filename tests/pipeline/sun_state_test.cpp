#include "pipeline/sun_state.h"

#include <cmath>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "sunmodel/angles.h"
#include "sunmodel/time_text.h"

namespace pleinair::sun_state_test {
namespace {

const Site kAalborg{0.99569, 0.17317, 15.0};

glm::dvec3 DirectionAt(double elevation_rad) {
  return {std::cos(elevation_rad), 0.0, std::sin(elevation_rad)};
}

SurveyLight ClearSurvey(const glm::dvec3& sun_direction_enu, double scale) {
  const ClearSkyIrradiance clear = ComputeClearSky(kAalborg, std::asin(sun_direction_enu.z));
  SurveyLight light;
  light.sun_direction_enu = sun_direction_enu;
  light.sun_irradiance_rgb = scale * 0.8 * clear.beam_rgb;
  light.sky_irradiance_rgb = scale * 1.5 * clear.diffuse_rgb;
  return light;
}

TEST(ScaledClearSky, GivesTheSurveysOwnLightBackAtItsTime) {
  const SurveyLight survey = ClearSurvey(DirectionAt(0.7), 42.0);
  const ScaledClearSky clear_sky(kAalborg, &survey);
  const ClearSkyExpectation now = clear_sky.At(survey.sun_direction_enu);
  EXPECT_TRUE(now.absolute);
  for (int channel = 0; channel < 3; ++channel) {
    EXPECT_NEAR(now.beam_rgb[channel] / survey.sun_irradiance_rgb[channel], 1.0, 1e-12);
    EXPECT_NEAR(now.diffuse_rgb[channel] / survey.sky_irradiance_rgb[channel], 1.0, 1e-12);
  }
}

// An overcast sky sends a third of the clear global irradiance: treated as a clear sky's blue light
// it would promise a beam several times too strong.
TEST(ScaledClearSky, ASurveyUnderCloudTiesTheUnitsRoughly) {
  SurveyLight survey = ClearSurvey(DirectionAt(0.7), 1.0);
  const ClearSkyExpectation clear = ScaledClearSky(kAalborg, &survey).At(DirectionAt(0.7));
  survey.sun_irradiance_rgb = glm::dvec3(0.0);
  survey.sky_irradiance_rgb = 0.3 * (clear.diffuse_rgb + DirectionAt(0.7).z * clear.beam_rgb);
  const ClearSkyExpectation found = ScaledClearSky(kAalborg, &survey).At(DirectionAt(0.7));
  EXPECT_TRUE(found.absolute);
  EXPECT_GT(found.gain_stddev, clear.gain_stddev);
  EXPECT_NEAR(found.beam_rgb.y / clear.beam_rgb.y, 1.0, found.gain_stddev);
}

TEST(ScaledClearSky, WithoutASurveyOnlyRatiosCount) {
  EXPECT_FALSE(ScaledClearSky(kAalborg, nullptr).At(DirectionAt(0.5)).absolute);
}

TEST(ScaledClearSky, HasNoBeamBelowTheHorizon) {
  const SurveyLight survey = ClearSurvey(DirectionAt(0.7), 1.0);
  const ClearSkyExpectation night = ScaledClearSky(kAalborg, &survey).At(DirectionAt(-0.2));
  EXPECT_EQ(night.beam_rgb, glm::dvec3(0.0));
  EXPECT_TRUE(std::isfinite(night.diffuse_rgb.x));
}

// What stands in the true east stands 10 deg left of the east of a model whose +Y points to 10 deg.
TEST(SunOverSite, IsInTheModelsFrame) {
  Site turned = kAalborg;
  turned.model_north_azimuth_rad = RadFromDeg(10.0);
  const UtcTime time = ParseUtcTime("2005-06-21T09:50:00Z");
  const glm::dvec3 sun = SunOverSite(kAalborg, time).direction_enu;
  const glm::dvec3 in_model = SunOverSite(turned, time).direction_enu;
  EXPECT_NEAR(
      DegFromRad(std::atan2(sun.x, sun.y) - std::atan2(in_model.x, in_model.y)), 10.0, 1e-9);
  EXPECT_NEAR(sun.z, in_model.z, 1e-15);
}

TEST(SunOfFrame, TakesTheFramesOwnDirectionFirst) {
  Frame frame;
  frame.time = ParseUtcTime("2005-06-21T09:50:00Z");
  const SunState computed = SunOfFrame(kAalborg, frame);
  frame.sun_direction_enu = glm::dvec3(0.0, 0.6, 0.8);
  EXPECT_EQ(SunOfFrame(kAalborg, frame).direction_enu, *frame.sun_direction_enu);
  EXPECT_GT(glm::distance(computed.direction_enu, *frame.sun_direction_enu), 0.1);
}

TEST(SunOfFrame, RefusesAFrameWithNeitherSiteNorDirectionUnlessItIsOvercast) {
  Frame frame;
  EXPECT_THROW(SunOfFrame(std::nullopt, frame), std::invalid_argument);
  frame.weather = Weather::kClear;
  // Callers name the frame.
  EXPECT_THAT(
      [&] { SunOfFrame(std::nullopt, frame); },
      testing::ThrowsMessage<std::invalid_argument>(testing::StartsWith("expected a site")));
  frame.weather = Weather::kOvercast;
  EXPECT_EQ(SunOfFrame(std::nullopt, frame).direction_enu, kNoSunDirectionEnu);
}

// Clouds have a colour without place and time, too: no channel of their light can vanish.
TEST(ScaledClearSky, HasTheColoursOfCloudsWhereNoSunIsStated) {
  const ClearSkyExpectation any = ScaledClearSky(std::nullopt, nullptr).At(kNoSunDirectionEnu);
  EXPECT_FALSE(any.absolute);
  const glm::dvec3 global = any.diffuse_rgb + any.sine_of_elevation * any.beam_rgb;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(global[c] / MeanOf(global), 1.0, 0.1);

  // A survey without a sun does not say how high it stood: it ties no size.
  SurveyLight overcast;
  overcast.sun_direction_enu = kNoSunDirectionEnu;
  overcast.sky_irradiance_rgb = {20.0, 21.0, 22.0};
  EXPECT_FALSE(ScaledClearSky(std::nullopt, &overcast).At(kNoSunDirectionEnu).absolute);
}

}  // namespace
}  // namespace pleinair::sun_state_test
