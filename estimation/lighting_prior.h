// What is known of sun and sky before the picture is looked at.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <glm/vec3.hpp>

#include "estimation/diffuse_sample.h"
#include "estimation/sky_climate.h"
#include "estimation/weather_belief.h"

namespace pleinair {

inline constexpr int kMaxLightUnknowns = 3 * (1 + kMaxSkyShapes);
inline constexpr int kMaxCameraErrors = 2;  // CameraErrors: a veil and an exponent.
inline constexpr int kMaxFitUnknowns = kMaxLightUnknowns + kMaxCameraErrors;

// Over (sun RGB, sky[0] RGB, sky[1] RGB, ...), Lighting::covariance's order. Never on the heap.
using LightVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxFitUnknowns, 1>;
using LightMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxFitUnknowns, kMaxFitUnknowns>;

// What the camera does to all pixels alike, beside noise. Deviations of 0: it does not.
struct CameraErrors {
  // Light that is added everywhere (haze, flare in the lens, a wrong black level), as a share of
  // the picture's mean radiance.
  glm::dvec3 mean_radiance_rgb{0.0};
  double veil_stddev = 0.0;
  // g of a response curve that is not the stated one:
  //   recorded / white = (radiance / white)^(1 + g).
  double exponent = 0.0;
  double exponent_stddev = 0.0;
  double white_radiance = 1.0;  // > 0. Where the exposure is not known any will do.
};

// A mixture of Gaussians: one common factor in information form,
//   minus twice its logarithm = x' information x - 2 x' information_times_mean + constant,
// which is singular where it says nothing, times the sum over the weathers.
struct LightingPrior {
  int sky_shapes = 1;
  LightMatrix information;
  LightVector information_times_mean;

  // Of sun and sky as the sum over its shapes. None: nothing is known of the weather.
  std::vector<WeatherLight> weathers;
  double repeats = 0.0;  // See WeatherBelief.
  // Of what else the picture shows, per weather; empty: nothing.
  std::vector<double> log_likelihood;
  // The weathers' light is known up to one factor, which the picture gives.
  bool gain_is_free = false;
  // Of a factor of each channel, common to sun and sky: white balance, albedos' colour.
  double channel_gain_stddev = 0.0;

  // The shape whose light comes of the beam, as around the sun in clear air: where hardly any of
  // the beam is found that a clear sky has, it has hardly a share. Below 0: none does. Sun over the
  // whole sky under a clear sky gives how much that is; where it is little itself, as at sunset, or
  // not known (0), nothing is said.
  int beam_shape = -1;
  glm::dvec3 clear_sun_to_sky_rgb{0.0};

  CameraErrors camera;
  // Of each plane's albedo, relative, where it is less known than LightingFitOptions::shared_error.
  double albedo_stddev = 0.0;

  // Irradiance of usual size, for when there is no sample to take the unit from; 0 where unknown.
  glm::dvec3 scale_rgb{0.0};

  // Says nothing. Throws std::invalid_argument when sky_shapes is outside 1 .. kMaxSkyShapes.
  static LightingPrior Nothing(int sky_shapes);
  bool SaysSomething() const;
};

// The prior of architecture section 4: `belief`, wide enough that a frame which can separate sun
// and sky by itself does not feel it.
LightingPrior MakeLightingPrior(const WeatherBelief& belief,
                                const SkyClimate& climate,
                                int sky_shapes);

// The climate alone.
LightingPrior MakeClimatePrior(const ClearSkyExpectation& clear_sky, int sky_shapes);

// Makes the clear shape, where it is among those of these names, the one that comes of the beam.
void SetBeamShape(std::span<const std::string> shape_names,
                  const ClearSkyExpectation& clear_sky,
                  LightingPrior& prior);

// Holds sun and whole sky to within 10^-4 of the larger, so that the samples decide the sky's shape
// alone.
void HoldIrradiance(const glm::dvec3& sun_rgb, const glm::dvec3& sky_rgb, LightingPrior& prior);

}  // namespace pleinair
