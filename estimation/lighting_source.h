// Where the light comes from: one interface for every way to measure it.
#pragma once

#include <string>

#include <tl/expected.hpp>

#include "datasets/frame_source.h"
#include "scene/lighting.h"
#include "scene/surface_view.h"

namespace pleinair {

// Clear-sky light at the frame's time in the frame's radiance units, to fall back on.
struct ClearSkyExpectation {
  glm::dvec3 beam_rgb{0.0};     // Normal to the beam.
  glm::dvec3 diffuse_rgb{0.0};  // Horizontal, without the disc.
  // False where no survey ties the units: then only the ratio of the two has a meaning.
  bool absolute = false;
};

// What a source may look at for one frame. References live for the call only.
struct LightingObservation {
  const Frame& frame;
  const SurfaceView& view;                      // Of frame.camera, for sun_direction_enu.
  glm::dvec3 sun_direction_enu{0.0, 0.0, 1.0};  // Apparent.
  double sun_angular_radius_rad = kMeanSunAngularRadiusRad;
  ClearSkyExpectation clear_sky;
};

struct LightingEstimate {
  Lighting lighting;
  bool sun_observable = false;
  int samples_used = 0;
  double inlier_fraction = 0.0;
  double condition_number = 0.0;
  double new_sample_set_ms = 0.0;  // Spent on drawing samples in this call; 0 when they were kept.
  // How far the data are from the model, as a relative rms over inliers.
  double relative_residual = 0.0;
};

struct LightingFailure {
  std::string reason;
};

class LightingSource {
 public:
  virtual ~LightingSource() = default;
  virtual tl::expected<LightingEstimate, LightingFailure> Estimate(
      const LightingObservation& observation) = 0;
};

}  // namespace pleinair
