// The one-off survey of a site: what its HDR environment map says of sun, sky and albedo.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/transport/transport.h"
#include "scene/lighting.h"
#include "scene/skyline.h"
#include "scene/surface_view.h"
#include "scene/utc_time.h"

namespace pleinair {

class SurfaceGather;  // relight/transport/surface_gather.h

// How far mesh and map may be from their stated places: two standard deviations of a site that was
// measured by hand.
struct Misplacement {
  double turned_rad = 0.025;  // The map about the vertical, against the mesh; less than 0.5.
  double moved_m = 0.06;      // Vertices of the mesh.
};

// A lat-long HDR map of a site, and where and when it was taken.
struct SurveyMap {
  RgbImage radiance;  // Repaired (see RepairRadiance).
  glm::dvec3 position_m{0.0};
  glm::dvec3 sun_direction_enu{0.0, 0.0, 1.0};  // Apparent, at the time of the map.
  double sun_angular_radius_rad = kMeanSunAngularRadiusRad;
  std::optional<UtcTime> time = std::nullopt;  // For callers that compare its light with a frame's.
  // Clear-sky beam over horizontal diffuse at that time, per channel, under the standard haze, for
  // a map that does not show the entire disc.
  glm::dvec3 clear_sky_beam_to_diffuse_rgb{0.0};
  Misplacement misplacement = {};
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// What the survey's sun was measured from.
enum class SunOrigin {
  kNone,      // It was below the horizon.
  kMap,       // The map around the sun's place: the disc, or an overcast sky without one.
  kShadows,   // Pairs of surfaces in its light and its shade; the result may be no sun.
  kClearSky,  // The map's sky and the clear-sky model.
};

// Sun and sky at the time of the survey, from the map itself.
struct SurveyLight {
  glm::dvec3 sun_direction_enu{0.0, 0.0, 1.0};  // Apparent.
  glm::dvec3 sun_irradiance_rgb{0.0};           // Irradiance of the disc, normal to the beam.
  glm::dvec3 sun_irradiance_stddev_rgb{0.0};
  SunOrigin sun_origin = SunOrigin::kMap;
  glm::dvec3 sky_irradiance_rgb{0.0};  // Horizontal, unoccluded, without the disc.
  bool sun_clipped = false;            // The disc could not be measured in the map.
  // A building hides it, and no shadow says that there was none: clouds may hide it, too.
  bool sun_hidden = false;
  // What the sun's deviation makes of the albedo of surfaces that the survey saw in the sun,
  // relative. The same error for all of them.
  glm::dvec3 albedo_stddev_rgb{0.0};
  // The clear-sky model's beam, normal to it, for the map's sky without its clouds and, in part,
  // for its haze. Where the map does not determine these, for all of the sky, under the standard
  // haze.
  glm::dvec3 clear_sky_beam_rgb{0.0};
  // Haze of the map's sky at 500 nm. None where the sky does not determine it.
  std::optional<double> aerosol_optical_depth_500nm;
  // Lat-long, without the disc, what buildings and the skyline hide filled in, black below the
  // horizon.
  RgbImage sky_radiance;
  std::vector<std::string> notes;  // What was assumed; for the report.
};

// A lat-long survey map over the patch scene: the paper's offline maps (jensen-2006, section 4.1).
// `view` has the map's size (its camera is not used); albedo, normal, sky_response, sun_visibility
// are the maps of the paper; pixels without a surface show the sky. As made, sky_response holds the
// map's own sky (OwnSkyShape) and the sun_* images stand for the sun of the survey, so that
// relighting with `light` gives the map back wherever albedo_measured and no unmodelled_shade.
struct Survey {
  glm::dvec3 position_m{0.0};
  SurveyLight light;
  Skyline skyline;  // What the map shows against the sky and the mesh lacks.
  SurfaceView view;
  // 1 where the map shows shade that the mesh does not cast (internal/unmodelled_shade.h):
  // albedo_rgb is the surface's all the same, but none of it may be sampled.
  Gray8Image unmodelled_shade;
  std::shared_ptr<const SurfaceGather> gather;  // For other skies and suns.
};

// The shape of the survey's own sky, seen past its skyline.
std::shared_ptr<const SkyShape> OwnSkyShape(const SurveyLight& light, const Skyline& skyline);

struct SurveyOptions {
  GatherOptions gather;
  int bounces = kAllBounces;
  // As SurfaceViewOptions::receiver_block_px, in map pixels.
  int receiver_block_px = 4;
  int sun_disc_samples = 16;
};

// What may be sampled.
struct DiffuseParts {
  std::span<const std::uint8_t> patch_is_diffuse;  // Per patch.
  const Gray8Image* mask = nullptr;  // Has the map's size; 255 may be sampled; null: all.
};

// Surveys `map`: light, then albedo = pi L / E. E is gathered at each pixel from the map's own sky,
// its sun and the light that faces reflect. Face albedos are means over the map's pixels and
// iterated to convergence (as in grosch-2005). Faces that the map does not see get their material's
// mean, or its diffuse albedo where the map sees none of it. Sets scene.face_albedo_rgb and
// scene.skyline.
//
// Where the disc is clipped or hidden, or holds less than half of the light that shadows indicate,
// the shadows determine the sun. It follows from lit and shaded points of one surface, together
// with the albedo. Without shadows it is the clear-sky model's for the map's sky.
//
// Throws std::invalid_argument for a map with defects, or sizes that don't fit.
Survey MakeSurvey(const SurveyMap& map,
                  const PatchTransport& transport,
                  const DiffuseParts& diffuse,
                  const SurveyOptions& options,
                  PatchScene& scene);

}  // namespace pleinair
