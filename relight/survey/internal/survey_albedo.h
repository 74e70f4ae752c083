// Albedos that explain a survey map under its own light.
#pragma once

#include <span>
#include <vector>

#include "relight/survey/internal/shadow_side.h"
#include "relight/survey/survey.h"
#include "relight/transport/patch_scene.h"
#include "relight/transport/surface_gather.h"
#include "relight/transport/transport.h"

namespace pleinair {

// The survey's geometry and light, ready for albedos.
struct AlbedoInput {
  const RgbImage& radiance;
  const SurveyLight& light;
  const Skyline& skyline;
  double sun_angular_radius_rad = kMeanSunAngularRadiusRad;
  const Image<std::int32_t>& face;  // What each pixel shows.
  const Image<ShadowSide>& side;    // Where the model's shadows are certain.
  const SurfaceGather& gather;
  const PatchTransport& transport;
  int bounces = kAllBounces;
};

// Above it a surface is one that the mesh lacks: see SolveAlbedo.
inline constexpr float kLargestAlbedo = 0.98f;

struct AlbedoResult {
  int iterations = 0;
  double last_change = 0.0;       // Largest move of a face's albedo in the last iteration.
  std::size_t on_wrong_side = 0;  // Pixels beside shadow edges that the mesh misplaces.
};

// Iterates face albedos (in `scene`) and fills albedo_rgb, albedo_measured, sky_response and
// sun_bounce of `view`, whose geometry, sun_visibility and edge_distance_px are there.
//
// Albedo is unknown (and its face's taken) where a channel's irradiance is below what 16 of a
// receiver's rays bring from the open sky: 6 % of it with 256 rays. Fewer rays are too few to
// divide by. Above 0.98 in a channel it is treated as a surface that the mesh lacks (a lamp, glass,
// a sunlit spot in modelled shadow): clamped, and not measured.
//
// Where a shadow's edge may be misplaced (ShadowSide::kUnsure), a pixel may show light that the
// model misplaces. Its albedo then differs from that of its surface's certain pixels by more than
// they scatter. The difference is a quarter or more of that to the albedo under the light of the
// edge's other side. And that surface would have the pixel's level and colour under some mixture of
// the two sides' lights. Pixels that are connected to such ones within 3.4 deg and look as on the
// other side count too: the shadow of an eave that the mesh lacks. All of these take their
// surface's albedo, and are not measured.
AlbedoResult SolveAlbedo(const AlbedoInput& input, PatchScene& scene, SurfaceView& view);

}  // namespace pleinair
