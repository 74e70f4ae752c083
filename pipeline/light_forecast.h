// Predicts a camera's picture under a clear sky, and the accuracy of the light that is estimated
// from it, before anything is recorded.
#pragma once

#include <cstdint>
#include <optional>

#include <glm/vec3.hpp>
#include <tl/expected.hpp>

#include "estimation/lighting_source.h"
#include "estimation/outdoor_lighting_source.h"
#include "pipeline/sun_state.h"
#include "relight/prepared_scene.h"
#include "relight/surface_view_builder.h"
#include "scene/camera.h"
#include "scene/image.h"
#include "scene/utc_time.h"
#include "sunmodel/site.h"

namespace pleinair {

// The forecast for one time. Irradiances in the scene's units.
struct LightForecast {
  UtcTime time{};
  SunState sun;
  // Shares of the picture's pixels with diffuse surfaces that may be sampled. Lit: the sun is 6 deg
  // or more above the surface. Shaded: in a shadow, or turned away from the sun.
  double lit_share = 0.0;
  double shaded_share = 0.0;
  // The clear sky's, with which the picture below is rendered.
  glm::dvec3 sun_irradiance_rgb{0.0};  // Normal to the beam.
  glm::dvec3 sky_irradiance_rgb{0.0};  // Horizontal.
  // The mesh as an 8-bit sRGB camera with automatic exposure would show it: with noise, and with
  // albedos that are off by 5 % from patch to patch. Empty where the sun is below the horizon.
  Rgb8Image picture;
  // The estimate from that picture only, without earlier frames. None where the sun is below the
  // horizon.
  std::optional<tl::expected<LightingEstimate, LightingFailure>> estimate;
  // Standard deviations by the estimate's covariance, relative to the clear sky's light; mean over
  // RGB. None without an estimate.
  std::optional<double> sun_relative_stddev;
  std::optional<double> sky_relative_stddev;
};

// Set-up of the forecast.
struct LightForecastOptions {
  SurfaceViewOptions view;
  OutdoorLightingOptions light;  // Its haze is set to the scene's.
  // Units of the light in the camera's frames: whether exposure is known.
  LightUnits units = LightUnits::kAbsolute;
  // Larger pictures are computed at this width: shares and deviations hardly depend on the number
  // of pixels. At least 16.
  int most_width_px = 480;
  std::uint64_t seed = 1;  // Seed of the camera's noise and the albedos' errors.
};

// Forecasts for one camera at one site. One thread at a time.
class LightForecaster {
 public:
  // `scene` outlives it. Throws std::invalid_argument naming the option.
  LightForecaster(const PreparedScene& scene,
                  const Site& site,
                  const Camera& camera,
                  const LightForecastOptions& options = {});

  // A pure function of `time`. Cost: transport of a new sun over the view.
  LightForecast At(UtcTime time);

 private:
  Rgb8Image PictureOf(const SurfaceView& view,
                      const ClearSkyExpectation& light,
                      const glm::dvec3& sun_direction_enu,
                      double& exposure) const;

  const PreparedScene& scene_;
  Site site_;
  Camera camera_;
  LightForecastOptions options_;
  ScaledClearSky clear_sky_;
  SurfaceViewBuilder view_builder_;
};

}  // namespace pleinair
