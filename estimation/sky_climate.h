// The light of each kind of weather: sun and sky, and their colours, as distributions.
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>
#include <glm/vec3.hpp>

#include "scene/weather.h"

namespace pleinair {

// Sun RGB (normal to the beam), then sky RGB (horizontal, over all shapes).
using SunAndSky = Eigen::Matrix<double, 6, 1>;
using SunAndSkyMatrix = Eigen::Matrix<double, 6, 6>;

// A normal distribution of sun and sky, in irradiance units.
struct LightGaussian {
  SunAndSky mean = SunAndSky::Zero();
  SunAndSkyMatrix covariance = SunAndSkyMatrix::Zero();
};

// Multiplies the light by `gain`.
void ScaleBy(double gain, LightGaussian& light);
// Adds the variance of a factor common to all of the light; `stddev` is relative.
void AddGainError(double stddev, LightGaussian& light);
// Adds the variances of factors, one a channel and common to sun and sky; `stddev` is relative.
void AddChannelGainError(double stddev, LightGaussian& light);

// Light under a cloudless sky, and how well its units are tied to the frame's.
struct ClearSkyExpectation {
  glm::dvec3 beam_rgb{0.0};        // Normal to the beam.
  glm::dvec3 diffuse_rgb{0.0};     // Horizontal, without the disc.
  double sine_of_elevation = 0.0;  // Sine of the sun's elevation.
  // False where the units are not tied: then only ratios have a meaning.
  bool absolute = false;
  // Standard deviation of the factor between these units and the frame's, relative, where absolute.
  double gain_stddev = 0.0;
};

// States of the sky. The middle three are one weather, which changes between them within minutes.
enum class SkyState { kClear, kSunAmongClouds, kVeiledSun, kCoveredSun, kOvercast };
inline constexpr int kSkyStates = 5;

// The distribution of light for each state of the sky.
struct SkyClimate {
  struct State {
    double share = 0.0;  // Share of daytime; all add up to 1.
    LightGaussian light;
  };
  std::array<State, kSkyStates> states;
};

// The climate under `clear_sky`, per state and channel, with B the clear beam and
// G = B max(0, sine_of_elevation) + D the clear global irradiance:
//   sun = b B,   sky = k D + g G,
// with b, k and g normally distributed and common to the channels, and an additional error of hue.
// Clear blue and cloud grey are the two ends of a sky's colour, so no channel can vanish.
//
// Source     Shares and spreads are assumptions, set by hand and not fitted to measurements;
//            docs/weather.md compares them with one measured day.
// Throws     std::invalid_argument for a clear sky that is negative or not finite.
SkyClimate MakeSkyClimate(const ClearSkyExpectation& clear_sky);

// Restricts the states to a person's judgement. Other weathers keep a hundredth of their share,
// since judgements err.
void Believe(Weather seen, SkyClimate& climate);

// Returns the weather that a state belongs to.
Weather WeatherOf(SkyState state);

}  // namespace pleinair
