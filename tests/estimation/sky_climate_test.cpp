#include "estimation/sky_climate.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "tests/estimation/synthetic_scene.h"

namespace pleinair::sky_climate_test {
namespace {

using testing::SyntheticClearSky;

const LightGaussian& LightOf(const SkyClimate& climate, SkyState state) {
  return climate.states[static_cast<std::size_t>(state)].light;
}

TEST(SkyClimate, SharesOfTheStatesAddUpToOne) {
  double sum = 0.0;
  for (const SkyClimate::State& state : MakeSkyClimate(SyntheticClearSky()).states) {
    sum += state.share;
  }
  EXPECT_NEAR(sum, 1.0, 1e-12);
}

// An open wall or ground under any of them is lit by less than the sun that is there could send.
TEST(SkyClimate, CloudsHideTheBeamAndBrightenTheSky) {
  const SkyClimate climate = MakeSkyClimate(SyntheticClearSky());
  const LightGaussian& clear = LightOf(climate, SkyState::kClear);
  const LightGaussian& covered = LightOf(climate, SkyState::kCoveredSun);
  const LightGaussian& overcast = LightOf(climate, SkyState::kOvercast);
  for (int c = 0; c < 3; ++c) {
    const double beam = SyntheticClearSky().beam_rgb[c];
    EXPECT_DOUBLE_EQ(clear.mean[c], beam);
    EXPECT_LT(covered.mean[c], 0.05 * beam);
    EXPECT_EQ(overcast.mean[c], 0.0);
    EXPECT_GT(covered.mean[3 + c], clear.mean[3 + c]);
  }
  // Cloud is greyer than the blue sky.
  EXPECT_LT(overcast.mean[5] / overcast.mean[3], clear.mean[5] / clear.mean[3]);
}

// Four standard deviations of hue: no channel of a sky can be a quarter of its neighbour by itself.
TEST(SkyClimate, NoChannelVanishes) {
  for (const SkyClimate::State& state : MakeSkyClimate(SyntheticClearSky()).states) {
    const SunAndSkyMatrix& covariance = state.light.covariance;
    for (int c = 0; c < 3; ++c) {
      const int d = 3 + (c + 1) % 3;
      const int a = 3 + c;
      // Of log sky_c - log sky_d.
      const double variance = covariance(a, a) / std::pow(state.light.mean[a], 2) +
                              covariance(d, d) / std::pow(state.light.mean[d], 2) -
                              2.0 * covariance(a, d) / (state.light.mean[a] * state.light.mean[d]);
      const double hue = std::abs(std::log(state.light.mean[a] / state.light.mean[d]));
      EXPECT_LT(hue + 4.0 * std::sqrt(variance), std::log(4.0));
    }
  }
}

TEST(SkyClimate, ScalesWithTheClearSky) {
  ClearSkyExpectation twice = SyntheticClearSky();
  twice.beam_rgb *= 2.0;
  twice.diffuse_rgb *= 2.0;
  const SkyClimate one = MakeSkyClimate(SyntheticClearSky());
  const SkyClimate two = MakeSkyClimate(twice);
  for (std::size_t s = 0; s < kSkyStates; ++s) {
    LightGaussian scaled = one.states[s].light;
    ScaleBy(2.0, scaled);
    EXPECT_TRUE(two.states[s].light.mean.isApprox(scaled.mean, 1e-12));
    EXPECT_TRUE(two.states[s].light.covariance.isApprox(scaled.covariance, 1e-12));
  }
}

TEST(SkyClimate, HasWidthAtSunset) {
  ClearSkyExpectation sunset = SyntheticClearSky();
  sunset.beam_rgb = glm::dvec3(0.0);
  sunset.sine_of_elevation = -0.001;
  for (const SkyClimate::State& state : MakeSkyClimate(sunset).states) {
    const Eigen::SelfAdjointEigenSolver<SunAndSkyMatrix> eigen(state.light.covariance);
    EXPECT_GT(eigen.eigenvalues().minCoeff(), 0.0);
  }
}

TEST(SkyClimate, AStatedWeatherLeavesTheOthersOneHundredth) {
  SkyClimate climate = MakeSkyClimate(SyntheticClearSky());
  Believe(Weather::kOvercast, climate);
  double others = 0.0;
  double sum = 0.0;
  for (std::size_t s = 0; s < kSkyStates; ++s) {
    sum += climate.states[s].share;
    if (WeatherOf(static_cast<SkyState>(s)) != Weather::kOvercast)
      others += climate.states[s].share;
  }
  EXPECT_NEAR(sum, 1.0, 1e-12);
  EXPECT_GT(others, 0.0);
  EXPECT_LT(others, 0.04);
}

TEST(SkyClimate, RefusesWhatIsNoLight) {
  ClearSkyExpectation bad = SyntheticClearSky();
  bad.beam_rgb.y = -1.0;
  EXPECT_THROW(MakeSkyClimate(bad), std::invalid_argument);
  bad = SyntheticClearSky();
  bad.diffuse_rgb.z = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(MakeSkyClimate(bad), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::sky_climate_test
