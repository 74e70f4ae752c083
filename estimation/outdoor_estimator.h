// From the samples of one frame, and what is known beside them, to its light.
#pragma once

#include <optional>
#include <span>
#include <string>

#include <glm/vec3.hpp>
#include <tl/expected.hpp>

#include "estimation/diffuse_sample.h"
#include "estimation/lighting_fit.h"
#include "estimation/lighting_source.h"
#include "estimation/texture_contrast.h"
#include "scene/weather.h"

namespace pleinair {

// Of one frame, beside its samples. References live for the call only.
struct OutdoorConditions {
  UtcTime time{};
  SunState sun;
  ClearSkyExpectation clear_sky;
  std::span<const std::string> sky_shape_names;
  LightUnits units = LightUnits::kAbsolute;
  ExposureChange exposure_change;  // Looked at where units are relative per frame.
  std::optional<Weather> weather;  // As a person saw it.
  // Looked at without a survey, whose light says more.
  std::optional<TextureContrast> texture;
  std::optional<SurveyedLight> surveyed;
  std::optional<HeldIrradiance> held;
  glm::dvec3 albedo_stddev_rgb{0.0};  // Relative: an error that all samples share.
  double plane_albedo_stddev = 0.0;   // Relative, of each plane by itself.
  CameraErrors camera;
};

// Keeps what it knows of the light from frame to frame. One thread at a time.
class OutdoorEstimator {
 public:
  explicit OutdoorEstimator(const LightingFitOptions& options) : fitter_(options) {}

  // Samples in a shadow that the mesh does not cast are changed: see FindShadows; and is_rejected
  // is set in all.
  tl::expected<LightingEstimate, LightingFailure> Estimate(std::span<DiffuseSample> samples,
                                                           const OutdoorConditions& conditions);

 private:
  LightingFitter fitter_;
  std::optional<UtcTime> last_time_;
  // In the last frame's units, which are climate_gain_ times those of its clear sky.
  std::optional<WeatherBelief> belief_;
  ClearSkyExpectation last_clear_sky_;  // Of belief_.
  double climate_gain_ = 1.0;
  // Of the camera: what earlier pictures say of its response, and when the last one did.
  struct Response {
    double exponent = 0.0;
    double variance = 0.0;
    UtcTime time{};
  };
  std::optional<Response> response_;

  struct Expectation {
    LightingPrior prior;
    WeatherBelief belief;
    double climate_gain = 1.0;  // Of the units that both are in.
  };
  Expectation Expect(const OutdoorConditions& conditions, int sky_shapes);
  void Learn(const Expectation& expectation, const LightingFit& fit);
  void LearnResponse(const CameraErrors& expected, const LightingFit& fit, UtcTime time);
};

}  // namespace pleinair
