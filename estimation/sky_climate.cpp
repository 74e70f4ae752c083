#include "estimation/sky_climate.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "estimation/internal/square.h"

namespace pleinair {
namespace {

using estimation_internal::Square;

struct Spread {
  double mean;
  double stddev;
};

struct StateModel {
  double share;
  Spread beam;     // b: of the clear beam.
  Spread clear;    // k: of the clear sky's diffuse light.
  Spread clouded;  // g: of the clear global irradiance, as light of clouds.
};

// In SkyState's order.
constexpr StateModel kModels[kSkyStates] = {
    {0.30, {1.00, 0.13}, {1.15, 0.30}, {0.03, 0.04}},
    {0.20, {0.95, 0.15}, {0.95, 0.35}, {0.15, 0.10}},
    {0.12, {0.45, 0.28}, {0.80, 0.40}, {0.22, 0.12}},
    {0.13, {0.02, 0.03}, {0.60, 0.35}, {0.20, 0.12}},
    {0.25, {0.00, 0.01}, {0.10, 0.10}, {0.32, 0.15}},
};

// Error of one channel against the others, relative: haze, dust and ozone redden the beam, clouds
// and the ground colour the sky.
constexpr double kSunHueStddev = 0.06;
constexpr double kSkyHueStddev = 0.12;
// A sun at the horizon has no beam, and its Gaussian no width: this part of the sky.
constexpr double kLeastStddev = 0.002;

void Check(const char* field, const glm::dvec3& rgb) {
  for (int c = 0; c < 3; ++c) {
    if (!(rgb[c] >= 0.0) || !std::isfinite(rgb[c])) {
      throw std::invalid_argument(std::string("ClearSkyExpectation::") + field + " is " +
                                  std::to_string(rgb[c]) + ": expected a finite irradiance >= 0");
    }
  }
}

LightGaussian LightOf(const StateModel& model, const ClearSkyExpectation& clear_sky) {
  LightGaussian light;
  SunAndSky beam = SunAndSky::Zero();
  SunAndSky clear = SunAndSky::Zero();
  SunAndSky clouded = SunAndSky::Zero();
  for (int c = 0; c < 3; ++c) {
    beam[c] = clear_sky.beam_rgb[c];
    clear[3 + c] = clear_sky.diffuse_rgb[c];
    clouded[3 + c] = clear_sky.diffuse_rgb[c] +
                     std::max(0.0, clear_sky.sine_of_elevation) * clear_sky.beam_rgb[c];
  }
  light.mean = model.beam.mean * beam + model.clear.mean * clear + model.clouded.mean * clouded;
  light.covariance = Square(model.beam.stddev) * beam * beam.transpose() +
                     Square(model.clear.stddev) * clear * clear.transpose() +
                     Square(model.clouded.stddev) * clouded * clouded.transpose();
  for (int c = 0; c < 3; ++c) {
    const double least = Square(kLeastStddev * light.mean[3 + c]);
    light.covariance(c, c) += Square(kSunHueStddev * light.mean[c]) + least;
    light.covariance(3 + c, 3 + c) += Square(kSkyHueStddev * light.mean[3 + c]) + least;
  }
  return light;
}

}  // namespace

void ScaleBy(double gain, LightGaussian& light) {
  light.mean *= gain;
  light.covariance *= Square(gain);
}

void AddGainError(double stddev, LightGaussian& light) {
  light.covariance += Square(stddev) * light.mean * light.mean.transpose();
}

void AddChannelGainError(double stddev, LightGaussian& light) {
  for (int c = 0; c < 3; ++c) {
    for (const int a : {c, 3 + c}) {
      for (const int b : {c, 3 + c}) {
        light.covariance(a, b) += Square(stddev) * light.mean[a] * light.mean[b];
      }
    }
  }
}

SkyClimate MakeSkyClimate(const ClearSkyExpectation& clear_sky) {
  Check("beam_rgb", clear_sky.beam_rgb);
  Check("diffuse_rgb", clear_sky.diffuse_rgb);
  SkyClimate climate;
  for (std::size_t s = 0; s < kSkyStates; ++s) {
    climate.states[s] = {kModels[s].share, LightOf(kModels[s], clear_sky)};
  }
  return climate;
}

void Believe(Weather seen, SkyClimate& climate) {
  constexpr double kMisjudged = 0.01;
  double sum = 0.0;
  for (std::size_t s = 0; s < kSkyStates; ++s) {
    double& share = climate.states[s].share;
    if (WeatherOf(static_cast<SkyState>(s)) != seen) share *= kMisjudged;
    sum += share;
  }
  for (SkyClimate::State& state : climate.states) state.share /= sum;
}

Weather WeatherOf(SkyState state) {
  switch (state) {
    case SkyState::kClear:
      return Weather::kClear;
    case SkyState::kOvercast:
      return Weather::kOvercast;
    case SkyState::kSunAmongClouds:
    case SkyState::kVeiledSun:
    case SkyState::kCoveredSun:
      break;
  }
  return Weather::kBroken;
}

}  // namespace pleinair
