// What light the kinds of weather bring: sun and sky, and their colours, as distributions.
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

struct LightGaussian {
  SunAndSky mean = SunAndSky::Zero();
  SunAndSkyMatrix covariance = SunAndSkyMatrix::Zero();
};

// Of light that is `gain` times as strong.
void ScaleBy(double gain, LightGaussian& light);
// Of a factor common to all of it, relative.
void AddGainError(double stddev, LightGaussian& light);

// Light under a cloudless sky, and how far its units are those of the frame.
struct ClearSkyExpectation {
  glm::dvec3 beam_rgb{0.0};        // Normal to the beam.
  glm::dvec3 diffuse_rgb{0.0};     // Horizontal, without the disc.
  double sine_of_elevation = 0.0;  // Of the sun.
  // False where nothing ties the units: then only ratios have a meaning.
  bool absolute = false;
  // Of the factor between these units and the frame's, relative, where they are absolute.
  double gain_stddev = 0.0;
};

// What the sky does with the sun. The middle three are one weather, which changes between them
// within minutes.
enum class SkyState { kClear, kSunAmongClouds, kVeiledSun, kCoveredSun, kOvercast };
inline constexpr int kSkyStates = 5;

struct SkyClimate {
  struct State {
    double share = 0.0;  // Of daytime; all add up to 1.
    LightGaussian light;
  };
  std::array<State, kSkyStates> states;
};

// The climate under `clear_sky`, per state and channel, with B the clear beam and
// G = B max(0, sine_of_elevation) + D the clear global irradiance:
//   sun = b B,   sky = k D + g G,
// b, k and g normally distributed and common to the channels, and an error of hue beside: clear
// blue and cloud grey are the two ends of a sky's colour, so no channel can vanish.
//
// Source     Shares and spreads are assumptions, set by hand and not fitted to measurements;
//            docs/weather.md compares them with one measured day.
// Throws     std::invalid_argument for a clear sky that is negative or not finite.
SkyClimate MakeSkyClimate(const ClearSkyExpectation& clear_sky);

// The states that a person's word leaves: those of other weathers keep a hundredth of their share,
// since judgments err.
void Believe(Weather seen, SkyClimate& climate);

Weather WeatherOf(SkyState state);

}  // namespace pleinair
