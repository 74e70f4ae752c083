// Where the light comes from: one interface for every way to measure it.
#pragma once

#include <array>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>
#include <tl/expected.hpp>

#include "calib/response_correction.h"
#include "estimation/diffuse_sample.h"
#include "estimation/exposure_change.h"
#include "estimation/light_change.h"
#include "estimation/sky_climate.h"
#include "estimation/weather_belief.h"
#include "scene/camera.h"
#include "scene/frame.h"
#include "scene/lighting.h"
#include "scene/pixel_rect.h"
#include "scene/sky_shape.h"
#include "scene/sun_state.h"
#include "scene/surface_view.h"
#include "scene/weather.h"

namespace pleinair {

// Light that is known, so that only the sky's shape is to be found.
struct HeldIrradiance {
  glm::dvec3 sun_rgb{0.0};  // Normal to the beam.
  glm::dvec3 sky_rgb{0.0};  // Horizontal, without the disc.
};

// A source's input for one frame. References live for the call only.
struct LightingObservation {
  const Frame& frame;
  const SurfaceView& view;  // View of frame.camera, for `sun` and the source's own sky basis.
  SunState sun;
  ClearSkyExpectation clear_sky;
  std::optional<HeldIrradiance> held = std::nullopt;
  // Standard deviation of the view's albedo, relative: an error that all samples share.
  glm::dvec3 albedo_stddev_rgb{0.0};
  // Standard deviation of each plane's own albedo, relative: for guessed albedos.
  double plane_albedo_stddev = 0.0;
  std::optional<SurveyedLight> surveyed = std::nullopt;
};

// How the frame's own picture contradicts the picture of another camera, which sees the sky.
struct SkyCameraCheck {
  // What the other camera's light was multiplied by: to the units of the frame's picture where
  // these are relative, or where is_in_other_units.
  glm::dvec3 factor_rgb{1.0};
  bool is_in_other_units = false;  // Its exposure or colours are not those that were stated.
  // The sun was measured on surfaces: it is hidden or too bright in the other picture, or not as it
  // was when that was taken.
  bool shows_another_sun = false;
};

// The light of one frame, and how it was estimated. Irradiances are in the units of `units`: sun
// normal to the beam, sky horizontal without the disc.
struct LightingEstimate {
  Lighting lighting;
  LightUnits units = LightUnits::kAbsolute;
  // Of the frame's codes: `lighting` is light, not what is recorded of it.
  ResponseCorrection response;
  // Since the last frame; only for light that is relative per frame.
  ExposureChange exposure_change;
  // Since the last estimate, by the surfaces that both frames show; none where they do not show it.
  std::optional<LightChange> light_change;
  bool sun_observable = false;
  int samples_used = 0;
  double inlier_fraction = 0.0;
  double condition_number = 0.0;
  double new_sample_set_ms = 0.0;  // Time to draw samples in this call; 0 when they were kept.
  // Where a source that sees the sky finds the sun, if not where it was stated; its light is
  // measured there.
  std::optional<glm::dvec3> sun_elsewhere_enu;
  // For each region, from a source that measures the sky itself; empty for others.
  std::vector<glm::dvec3> sky_radiance_rgb;
  SkyCameraCheck sky_camera;  // From such a source.
  // Probability of each weather, in kAllWeathers' order; none where the source does not estimate
  // it.
  std::optional<std::array<double, std::size(kAllWeathers)>> weather_shares;
  // Difference of data and model, as a relative rms over inliers.
  double relative_residual = 0.0;
};

// Surveyed albedos of textured walls have residuals of 2 to 13 %.
inline constexpr double kLargestTrustedResidual = 0.2;

// Whether the picture and the model differ too much for the light to be trusted. Causes are things
// in front of the surfaces, a mesh, a pose or a sun in the wrong place, wet ground, or a façade of
// several colours. Unseen windows and plants give up to a third of outliers.
inline bool ModelMismatch(const LightingEstimate& estimate) {
  constexpr double kFewestInliers = 0.6;
  return estimate.samples_used > 0 && !(estimate.relative_residual <= kLargestTrustedResidual &&
                                        estimate.inlier_fraction >= kFewestInliers);
}

// Whether sun and sky are separated well enough to be used: the sun to a third of all light,
// without the factor that all light has in common. Otherwise the light is that of the last frame
// that was known, or of the climate.
bool LightIsKnown(const Lighting& lighting);

// Why a frame has no estimate: one line.
struct LightingFailure {
  std::string reason;
};

// Fixed functions of direction, in the order of Lighting::sky.
using SkyBasis = std::span<const std::shared_ptr<const SkyShape>>;

// Estimates the light of frames. One thread at a time.
class LightingSource {
 public:
  virtual ~LightingSource() = default;
  // Returns the shapes whose mix is the sky of `frame`. The view's sky_response must be for these
  // shapes when `frame` is estimated. A shape that has not changed is the same object as in the
  // last call. The basis lives until the next call. `sun` may be a step of time off the frame's.
  virtual tl::expected<SkyBasis, LightingFailure> BasisFor(const Frame& frame,
                                                           const SunState& sun) = 0;
  // Before a frame of a camera that has moved: the pixels of its view that Estimate is likely to
  // look at, so that the others need not be made. None: any of them.
  virtual std::optional<std::vector<PixelRect>> PixelsLookedAt(const Camera& /*camera*/) const {
    return std::nullopt;
  }
  // Whether Estimate can do with a view of these pixels alone; else it needs the whole view.
  virtual bool IsServedBy(const LightingObservation& /*observation*/) const { return true; }
  // Estimates the light of one frame, after BasisFor the same frame.
  virtual tl::expected<LightingEstimate, LightingFailure> Estimate(
      const LightingObservation& observation) = 0;
  // The samples of the last estimate, valid until the next call; empty for a source without
  // samples.
  virtual std::span<const DiffuseSample> Samples() const { return {}; }
};

}  // namespace pleinair
