#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "relight/volume/environment.h"
#include "scene/sky_shape.h"
#include "tests/relight/probe_test_scenes.h"

namespace pleinair::environment_hard_cases_test {
namespace {

const glm::dvec3 kSun = glm::normalize(glm::dvec3(-0.5, 0.3, 0.6));

std::vector<EnvironmentBasis> YardBasis(LatLongSize size) {
  const Survey survey = SurveyOf(Yard(), {0.0, 0.0, 1.5}, size, kSun);
  return {EnvironmentOfSun(survey, kSun), EnvironmentOfSky(survey, 0, *MakeUniformSkyShape())};
}

Lighting SunAndSky(double scale) {
  Lighting lighting;
  lighting.sun.irradiance_rgb = scale * glm::dvec3(800.0, 760.0, 700.0);
  lighting.sky = {{"uniform", scale * glm::dvec3(120.0, 140.0, 190.0)}};
  return lighting;
}

TEST(EnvironmentHardCases, SameBitsForAnyNumberOfThreads) {
  const std::vector<EnvironmentBasis> basis = YardBasis({512, 256});
  std::vector<RgbImage> maps;
  for (const std::size_t threads : {1u, 2u, 8u}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    SynthesiseEnvironment(basis, SunAndSky(1.0), maps.emplace_back());
  }
  EXPECT_EQ(maps[0].pixels, maps[1].pixels);
  EXPECT_EQ(maps[0].pixels, maps[2].pixels);
}

// Powers of two change the exponent alone: the map must scale without a rounding.
TEST(EnvironmentHardCases, ScalesWithTheLightOverSixteenDecades) {
  const std::vector<EnvironmentBasis> basis = YardBasis({64, 32});
  RgbImage unit;
  SynthesiseEnvironment(basis, SunAndSky(1.0), unit);
  for (const double scale : {std::ldexp(1.0, -27), std::ldexp(1.0, 27)}) {
    RgbImage scaled;
    SynthesiseEnvironment(basis, SunAndSky(scale), scaled);
    for (std::size_t i = 0; i < unit.pixels.size(); ++i) {
      ASSERT_EQ(scaled.pixels[i], static_cast<float>(scale) * unit.pixels[i]);
    }
  }
}

TEST(EnvironmentHardCases, SunBelowTheHorizonLeavesTheGroundToTheBounces) {
  const Survey survey = SurveyOf(Yard(), {0.0, 0.0, 1.5}, {64, 32}, kSun);
  const EnvironmentBasis night = EnvironmentOfSun(survey, {0.0, 0.6, -0.8});
  const int x = 20, y = 31;  // Straight down.
  ASSERT_EQ(survey.view.normal_world.At(x, y), glm::vec3(0.0f, 0.0f, 1.0f));
  const glm::vec3 expected =
      survey.view.albedo_rgb.At(x, y) / 3.14159265f * survey.view.sun_bounce.At(x, y);
  for (glm::length_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(night.radiance.At(x, y)[c], expected[c], 1e-6f * expected[c]);
  }
}

TEST(EnvironmentHardCases, NoMapGivesNoMap) {
  const std::vector<EnvironmentBasis> basis(2);  // As without a survey.
  RgbImage environment(3, 2);
  SynthesiseEnvironment(basis, SunAndSky(1.0), environment);
  EXPECT_TRUE(environment.Empty());
  EXPECT_EQ(environment.width, 0);
}

TEST(EnvironmentHardCases, RefusesLightThatIsNotANumber) {
  const std::vector<EnvironmentBasis> basis = YardBasis({16, 8});
  RgbImage environment;
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), 1e300}) {
    Lighting lighting = SunAndSky(1.0);
    lighting.sky[0].irradiance_rgb.y = bad;
    try {
      SynthesiseEnvironment(basis, lighting, environment);
      FAIL() << "took " << bad;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("sky[0]"));
    }
  }
}

TEST(EnvironmentHardCases, RefusesLightsThatDoNotFitTheBasis) {
  std::vector<EnvironmentBasis> basis = YardBasis({16, 8});
  RgbImage environment;
  Lighting lighting = SunAndSky(1.0);
  lighting.sky.resize(2);
  EXPECT_THROW(SynthesiseEnvironment(basis, lighting, environment), std::invalid_argument);
  basis[1].radiance = RgbImage(8, 16);  // As many pixels, another shape.
  EXPECT_THROW(SynthesiseEnvironment(basis, SunAndSky(1.0), environment), std::invalid_argument);
  EXPECT_THROW(SynthesiseEnvironment({}, SunAndSky(1.0), environment), std::invalid_argument);
}

TEST(EnvironmentHardCases, RefusesASurveyWhoseMapsDifferInSize) {
  Survey survey = SurveyOf(Yard(), {0.0, 0.0, 1.5}, {16, 8}, kSun);
  EXPECT_THROW(EnvironmentOfSky(survey, 1, *MakeUniformSkyShape()), std::invalid_argument);
  survey.view.albedo_rgb = Image<glm::vec3>(8, 4);
  EXPECT_THROW(EnvironmentOfSun(survey, kSun), std::invalid_argument);
  EXPECT_THROW(EnvironmentOfSky(survey, 0, *MakeUniformSkyShape()), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::environment_hard_cases_test
