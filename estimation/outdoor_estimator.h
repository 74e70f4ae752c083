// The light of one frame from its samples and from what else is known.
#pragma once

#include <optional>
#include <span>
#include <string>

#include <glm/vec3.hpp>
#include <tl/expected.hpp>

#include "estimation/camera_errors.h"
#include "estimation/diffuse_sample.h"
#include "estimation/lighting_fit.h"
#include "estimation/lighting_source.h"
#include "estimation/texture_contrast.h"
#include "scene/weather.h"

namespace pleinair {

// What is known of one frame, its samples excluded. References live for the call only.
struct OutdoorConditions {
  UtcTime time{};
  SunState sun;
  ClearSkyExpectation clear_sky;
  std::span<const std::string> sky_shape_names;
  LightUnits units = LightUnits::kAbsolute;
  ExposureChange exposure_change;  // Used where units are relative per frame.
  std::optional<Weather> weather;  // As judged by a person.
  // Used only without a survey, whose light is better evidence.
  std::optional<TextureContrast> texture;
  std::optional<SurveyedLight> surveyed;
  std::optional<HeldIrradiance> held;
  glm::dvec3 albedo_stddev_rgb{0.0};  // Relative: an error that all samples share.
  double plane_albedo_stddev = 0.0;   // Relative, of each plane by itself.
  CameraErrors camera;
};

// The residual that the fit's own errors of albedo explain: guessed albedos leave more.
double TrustedResidual(double plane_albedo_stddev);

// Keeps its belief of the light from frame to frame. One thread at a time.
class OutdoorEstimator {
 public:
  explicit OutdoorEstimator(const LightingFitOptions& options) : fitter_(options) {}

  // Returns the light, or why there is none. Changes samples in a shadow that the mesh does not
  // cast (see FindShadows), and sets is_rejected of all samples.
  tl::expected<LightingEstimate, LightingFailure> Estimate(std::span<DiffuseSample> samples,
                                                           const OutdoorConditions& conditions);

 private:
  LightingFitter fitter_;
  std::optional<UtcTime> last_time_;
  // In the last frame's units: climate_gain_ times those of its clear sky.
  std::optional<WeatherBelief> belief_;
  ClearSkyExpectation last_clear_sky_;  // That belief_ holds under.
  double climate_gain_ = 1.0;
  // The camera's response as learned from earlier pictures, and the time of the last one.
  struct Response {
    LearnedError vignetting;
    LearnedError saturation;
    LearnedError exponent;
    UtcTime time{};
  };
  std::optional<Response> response_;

  struct Expectation {
    LightingPrior prior;
    WeatherBelief belief;
    double climate_gain = 1.0;      // Ratio of the units of both.
    bool exposure_changed = false;  // By a known factor, since the last picture.
  };
  Expectation Expect(const OutdoorConditions& conditions, int sky_shapes);
  // `trust`: the share of the picture's evidence of the weather that counts.
  void Learn(const Expectation& expectation, const LightingFit& fit, double trust);
  void LearnResponse(const CameraErrors& expected, const LightingFit& fit, UtcTime time);
};

}  // namespace pleinair
