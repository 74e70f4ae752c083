// Where the real shadows in a picture say the sun is: a check on north, pose and time.
#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "datasets/frame_source.h"
#include "scene/ray_caster.h"
#include "scene/surface_view.h"

namespace pleinair {

struct ShadowDirectionOptions {
  double largest_offset_rad = 0.26;  // Candidates reach this far to either side (15 deg).
  double step_rad = 0.00873;         // Between candidates (0.5 deg); the minimum is interpolated.
  int pixels = 20000;                // At most, evenly over the picture.
};

struct ShadowDirection {
  // Azimuth of the sun by the real shadows minus the computed one: also the angle on level ground
  // between the shadow of a real upright thing and that of a virtual one.
  double azimuth_offset_rad = 0.0;
  double stddev_rad = 0.0;  // By leaving out one block of the picture after the other.
};

// Turns the sun about the vertical, casts the mesh's shadows for each candidate, and takes the one
// under which the picture's brightness (over albedo), plane by plane, falls best into a lit and a
// shaded level. Says none where no plane shows both, or where the best candidate is at the end of
// the range: then the shadows tell nothing.
std::optional<ShadowDirection> MeasureShadowDirection(const Frame& frame,
                                                      const SurfaceView& view,
                                                      const RayCaster& caster,
                                                      const glm::dvec3& sun_direction_enu,
                                                      const ShadowDirectionOptions& options = {});

}  // namespace pleinair
