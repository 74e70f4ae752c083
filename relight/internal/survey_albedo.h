// Albedos that explain a survey map under its own light.
#pragma once

#include <span>
#include <vector>

#include "relight/internal/surface_gather.h"
#include "relight/patch_scene.h"
#include "relight/survey.h"
#include "relight/transport.h"

namespace pleinair {

// The survey's geometry and light, ready for albedos.
struct AlbedoInput {
  const RgbImage& radiance;
  const SurveyLight& light;
  double sun_angular_radius_rad = kMeanSunAngularRadiusRad;
  const Image<std::int32_t>& face;  // What each pixel shows.
  const SurfaceGather& gather;
  const PatchTransport& transport;
  int bounces = kAllBounces;
};

struct AlbedoResult {
  int iterations = 0;
  double last_change = 0.0;  // Largest move of a face's albedo in the last iteration.
};

// Iterates face albedos (in `scene`) and fills albedo_rgb, albedo_measured, sky_response and
// sun_bounce of `view`, whose geometry, sun_visibility and edge_distance_px are there.
//
// Albedo is unknown (and its face's taken) where a channel's irradiance is below what 16 of a
// receiver's rays bring from the open sky: 6 % of it with 256 rays. Fewer rays are too few to
// divide by. Above 0.98 in a channel it is taken for a surface that the mesh lacks (a lamp, glass,
// a sunlit spot in modelled shadow): clamped, and not measured.
AlbedoResult SolveAlbedo(const AlbedoInput& input, PatchScene& scene, SurfaceView& view);

}  // namespace pleinair
