// What a camera's picture would show under a clear sky, and how well the estimate would know that
// light: before anything is recorded.
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

struct LightForecast {
  UtcTime time{};
  SunState sun;
  // Shares of the picture's pixels: diffuse surfaces that may be sampled, in the sun (it stands 6
  // deg or more above the surface), and in a shadow or turned away from the sun.
  double lit_share = 0.0;
  double shaded_share = 0.0;
  // What the picture below was made with: the clear sky's.
  glm::dvec3 sun_irradiance_rgb{0.0};  // Normal to the beam.
  glm::dvec3 sky_irradiance_rgb{0.0};  // Horizontal.
  // As an 8-bit sRGB camera with automatic exposure would show the mesh, noise included, with
  // albedos that are patchily off by 5 %; empty where the sun is below the horizon.
  Rgb8Image picture;
  // The estimate from that picture by itself, without frames before. None where the sun is below
  // the horizon.
  std::optional<tl::expected<LightingEstimate, LightingFailure>> estimate;
  // Standard deviations by the estimate's covariance, relative to the clear sky's light; mean over
  // RGB. None without an estimate.
  std::optional<double> sun_relative_stddev;
  std::optional<double> sky_relative_stddev;
};

struct LightForecastOptions {
  SurfaceViewOptions view;
  OutdoorLightingOptions light;  // Its haze is set to the scene's.
  // In which the camera's frames give light: what exposure is known.
  LightUnits units = LightUnits::kAbsolute;
  // Larger pictures are worked out at this width: neither shares nor deviations depend on the
  // number of pixels much. At least 16.
  int most_width_px = 480;
  std::uint64_t seed = 1;  // Of the camera's noise and of the albedos' errors.
};

class LightForecaster {
 public:
  // `scene` outlives it. Throws std::invalid_argument naming the option.
  LightForecaster(const PreparedScene& scene,
                  const Site& site,
                  const Camera& camera,
                  const LightForecastOptions& options = {});

  // A pure function of `time`. Cost: transport of a new sun over the view.
  LightForecast At(UtcTime time);

  // What At has made its picture from; of the last time with the sun up.
  const SurfaceView* View() const { return view_; }

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
  const SurfaceView* view_ = nullptr;
};

}  // namespace pleinair
