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

#include "estimation/diffuse_sample.h"
#include "estimation/exposure_change.h"
#include "estimation/sky_climate.h"
#include "estimation/weather_belief.h"
#include "scene/frame.h"
#include "scene/lighting.h"
#include "scene/sky_shape.h"
#include "scene/sun_state.h"
#include "scene/surface_view.h"
#include "scene/weather.h"

namespace pleinair {

// Light that is known, so that only the sky's shape is left to find.
struct HeldIrradiance {
  glm::dvec3 sun_rgb{0.0};  // Normal to the beam.
  glm::dvec3 sky_rgb{0.0};  // Horizontal, without the disc.
};

// What a source may look at for one frame. References live for the call only.
struct LightingObservation {
  const Frame& frame;
  const SurfaceView& view;  // Of frame.camera, for `sun` and the source's own sky basis.
  SunState sun;
  ClearSkyExpectation clear_sky;
  std::optional<HeldIrradiance> held = std::nullopt;
  // Of the view's albedo, relative: an error that all samples share.
  glm::dvec3 albedo_stddev_rgb{0.0};
  // Of each plane's albedo by itself, relative: where somebody has guessed them.
  double plane_albedo_stddev = 0.0;
  std::optional<SurveyedLight> surveyed = std::nullopt;
};

struct LightingEstimate {
  Lighting lighting;
  LightUnits units = LightUnits::kAbsolute;
  // Since the last frame; of light that is relative per frame alone.
  ExposureChange exposure_change;
  bool sun_observable = false;
  int samples_used = 0;
  double inlier_fraction = 0.0;
  double condition_number = 0.0;
  double new_sample_set_ms = 0.0;  // Spent on drawing samples in this call; 0 when they were kept.
  // Of each region of a source that measures the sky itself; empty for others.
  std::vector<glm::dvec3> sky_radiance_rgb;
  // How probable each weather is, in kAllWeathers' order; none where the source does not ask.
  std::optional<std::array<double, std::size(kAllWeathers)>> weather_shares;
  // How far the data are from the model, as a relative rms over inliers.
  double relative_residual = 0.0;
};

// Whether the picture and the model are too far apart for the stated deviations to be trusted: a
// mesh, a pose or a sun in the wrong place, wet ground, a façade that is not of one colour.
// Surveyed albedos of textured walls leave residuals of 2 to 13 %, unseen windows and plants up to
// a third of outliers.
inline bool ModelMismatch(const LightingEstimate& estimate) {
  constexpr double kLargestResidual = 0.2;
  constexpr double kFewestInliers = 0.6;
  return estimate.samples_used > 0 && !(estimate.relative_residual <= kLargestResidual &&
                                        estimate.inlier_fraction >= kFewestInliers);
}

// Whether sun and sky are known apart well enough to be believed: the sun to a third of all light.
// Otherwise the light is that of the last frame that was known, or of the climate.
bool LightIsKnown(const Lighting& lighting);

struct LightingFailure {
  std::string reason;
};

// Fixed functions of direction, in the order of Lighting::sky.
using SkyBasis = std::span<const std::shared_ptr<const SkyShape>>;

class LightingSource {
 public:
  virtual ~LightingSource() = default;
  // What the sky of `frame` will be told as a mix of, and what the view's sky_response has to stand
  // for when `frame` is estimated. A shape that has not changed is the same object as in the last
  // call. The basis lives until the next call. `sun` may be a step of time off the frame's.
  virtual tl::expected<SkyBasis, LightingFailure> BasisFor(const Frame& frame,
                                                           const SunState& sun) = 0;
  // Called after BasisFor the same frame.
  virtual tl::expected<LightingEstimate, LightingFailure> Estimate(
      const LightingObservation& observation) = 0;
  // What the last estimate was made from, until the next call; empty of a source without any.
  virtual std::span<const DiffuseSample> Samples() const { return {}; }
};

}  // namespace pleinair
