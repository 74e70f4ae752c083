// The prior of sun and sky: what is known before the picture is used. Irradiances in the frame's
// radiance units times sr: sun normal to the beam, sky horizontal.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <glm/vec3.hpp>

#include "calib/response_correction.h"
#include "estimation/diffuse_sample.h"
#include "estimation/sky_climate.h"
#include "estimation/weather_belief.h"
#include "scene/weather.h"

namespace pleinair {

inline constexpr int kMaxLightUnknowns = 3 * (1 + kMaxSkyShapes);
inline constexpr int kMaxCameraErrors = 5;  // CameraErrors.
inline constexpr int kMaxFitUnknowns = kMaxLightUnknowns + kMaxCameraErrors;

// Over (sun RGB, sky[0] RGB, sky[1] RGB, ...), Lighting::covariance's order. Never on the heap.
using LightVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxFitUnknowns, 1>;
using LightMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxFitUnknowns, kMaxFitUnknowns>;

// A curve may be steep, but not upside down. Not even the widest lens has corners much darker.
inline constexpr double kMostResponseExponent = 0.5;
inline constexpr double kMostVignetting = 0.6;
inline constexpr double kLeastSaturation = -0.4;
inline constexpr double kMostSaturation = 1.0;

// Errors of the camera that all pixels share, noise excluded. Deviations of 0: none.
struct CameraErrors {
  // Light that is added everywhere (haze, flare in the lens, a wrong black level), as a share of
  // the picture's mean radiance.
  glm::dvec3 mean_radiance_rgb{0.0};
  double veil_stddev = 0.0;
  // Share of light that is lost in the picture's corners, elsewhere with the square of the distance
  // from the centre.
  double vignetting = 0.0;
  double vignetting_stddev = 0.0;
  LensCircle lens_circle;
  // The share by which colours are farther from grey than those of light.
  double saturation = 0.0;
  double saturation_stddev = 0.0;
  // The g of a response curve that differs from the stated one:
  //   recorded / white = (radiance / white)^(1 + g).
  double exponent = 0.0;
  double exponent_stddev = 0.0;
  // Standard deviation of the share of a measured pattern's contrast that the picture lacks. A
  // pattern that lies beside its place, by an error of pose, mesh or north, explains only a part of
  // the picture's contrast (Fuller 1987, section 1.1). Without this unknown,
  // the response would seem flat.
  double pattern_stddev = 0.0;
  double white_radiance = 1.0;  // > 0. Any value where the exposure is not known.
};

// A mixture of Gaussians: one common factor in information form,
//   minus twice its logarithm = x' information x - 2 x' information_times_mean + constant,
// which is singular where nothing is known, times the sum over the weathers.
struct LightingPrior {
  int sky_shapes = 1;
  LightMatrix information;
  LightVector information_times_mean;

  // Gaussians over the sun and the sum of the sky's shapes. None: nothing is known of the weather.
  std::vector<WeatherLight> weathers;
  double repeats = 0.0;  // See WeatherBelief.
  // Likelihood of other evidence in the picture, per weather; empty: none.
  std::vector<double> log_likelihood;
  // The weathers' light is known up to one factor, which the picture gives.
  bool gain_is_free = false;
  // Standard deviation of a factor of each channel, common to sun and sky: white balance, colour of
  // the albedos.
  double channel_gain_stddev = 0.0;

  // The shape that is scattered light of the beam, as around the sun in clear air; below 0: none.
  // Where the fit finds hardly any of a clear sky's beam, this shape has hardly a share. How much
  // beam a clear sky has is the sun over the entire sky, below. Where that is small itself, as at
  // sunset, or not known (0), the share is not restricted.
  int beam_shape = -1;
  glm::dvec3 clear_sun_to_sky_rgb{0.0};

  CameraErrors camera;
  // Standard deviation of each plane's albedo, relative, where larger than
  // LightingFitOptions::shared_error.
  double albedo_stddev = 0.0;

  // Irradiance of usual size: the unit where there is no sample. 0 where unknown.
  glm::dvec3 scale_rgb{0.0};

  // Returns a prior without information. Throws std::invalid_argument when sky_shapes is outside 1
  // .. kMaxSkyShapes.
  static LightingPrior Nothing(int sky_shapes);
  bool SaysSomething() const;
};

// The prior of architecture section 4: `belief`, wide enough not to influence a frame that can
// separate sun and sky by itself.
LightingPrior MakeLightingPrior(const WeatherBelief& belief,
                                const SkyClimate& climate,
                                int sky_shapes);

// The prior of the climate only. `seen`: the weather as judged by a person.
LightingPrior MakeClimatePrior(const ClearSkyExpectation& clear_sky,
                               int sky_shapes,
                               const std::optional<Weather>& seen = std::nullopt);

// Sets beam_shape to the clear shape, where it is among `shape_names`.
void SetBeamShape(std::span<const std::string> shape_names,
                  const ClearSkyExpectation& clear_sky,
                  LightingPrior& prior);

// Holds sun and entire sky to within 10^-4 of the larger, so that the samples determine only the
// sky's shape.
void HoldIrradiance(const glm::dvec3& sun_rgb, const glm::dvec3& sky_rgb, LightingPrior& prior);

}  // namespace pleinair
