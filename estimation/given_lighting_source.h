// Light that is known before the frame: replayed from an earlier run, measured by other means, or
// invented.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "estimation/lighting_source.h"
#include "scene/utc_time.h"
#include "sunmodel/clear_sky.h"

namespace pleinair {

// The light of one frame, in the frame's radiance units.
struct GivenLight {
  std::optional<UtcTime> time;  // Where known, the frame's must not be more than an hour off.
  // Replaces the frame's own, which the source gets from its caller.
  std::optional<glm::dvec3> sun_direction_enu;
  glm::dvec3 sun_irradiance_rgb{0.0};  // Normal to the beam.
  glm::dvec3 sky_irradiance_rgb{0.0};  // Horizontal, without the disc.
  // At most one of the two; shapes are used in the order of kAllSkyShapeKinds. With neither, the
  // sky's shape is fitted to the frame, with its horizontal irradiance held.
  std::map<std::string, glm::dvec3> sky_shares;    // By the shape's name; add up to 1 per channel.
  std::optional<std::filesystem::path> sky_image;  // Lat-long radiance, without the disc; its
                                                   // scale does not matter.
  bool sun_observable = false;                     // As stated with the measurement.

  // Throws std::invalid_argument, without naming the frame. It refuses a value below 0 or not
  // finite, shares of an unknown shape or that do not add up to 1 within 1 %, and both a shape and
  // an image.
  void Validate() const;
};

// Returns a source of the light in `by_frame`, by the frame's index; BasisFor fails for a frame
// that is not there, or whose time the light's contradicts. `shape_source` fits the shapes of skies
// that have none: it must respect LightingObservation::held. The haze is that of clear skies among
// the given shares.
std::unique_ptr<LightingSource> MakeGivenLightingSource(
    std::map<int, GivenLight> by_frame,
    std::unique_ptr<LightingSource> shape_source,
    double aerosol_optical_depth_500nm = kStandardAerosolDepth500nm);

}  // namespace pleinair
