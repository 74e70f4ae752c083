// The one-off survey of a site: what its HDR environment map says of sun, sky and albedo.
#pragma once

#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/transport.h"
#include "scene/surface_view.h"

namespace pleinair {

// Sun and sky at the time of the survey, from the map itself.
struct SurveyLight {
  glm::dvec3 sun_direction_enu{0.0, 0.0, 1.0};  // Apparent.
  glm::dvec3 sun_irradiance_rgb{0.0};           // Of the disc, normal to the beam.
  glm::dvec3 sun_irradiance_stddev_rgb{0.0};
  glm::dvec3 sky_irradiance_rgb{0.0};  // Horizontal, unoccluded, without the disc.
  bool sun_clipped = false;            // The disc could not be measured in the map.
  // Lat-long, without the disc, what buildings hide filled in, black below the horizon.
  RgbImage sky_radiance;
  std::vector<std::string> notes;  // What was assumed; for the report.
};

// A lat-long survey map over the patch scene: the paper's offline maps (jensen-2006, section 4.1).
// `view` has the map's size (its camera is not used); albedo, normal, sky_response, sun_visibility
// are the maps of the paper; pixels without a surface show the sky.
struct Survey {
  glm::dvec3 position_m{0.0};
  SurveyLight light;
  SurfaceView view;
};

}  // namespace pleinair
