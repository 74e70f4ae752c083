// The sun of a survey from its shadows: lit and shaded points of one material.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <glm/vec3.hpp>

#include "relight/survey/internal/shadow_side.h"
#include "relight/transport/patch_scene.h"
#include "scene/image.h"
#include "scene/surface_view.h"

namespace pleinair {

// Prior of the sun's irradiance, before the shadows are used: its logarithm is normal, the channels
// share a part of its error and each has one of its own.
struct SunPrior {
  glm::dvec3 median_rgb{0.0};  // > 0.
  double shared_log_stddev = 0.0;
  double hue_log_stddev = 0.0;
  double chance_of_none = 0.0;  // In [0, 1): probability that there was no sun at all.
};

struct ShadowPairsInput {
  const RgbImage& radiance;
  // Over the map: sun_bounce, and sky_response[0] of the survey's own sky.
  const SurfaceView& view;
  const Image<ShadowSide>& side;
  // Distance to the nearest edge of the mesh, and how near to one a pixel may show what is behind.
  const GrayImage& mesh_edge_distance_px;
  Misplacement misplacement;
  glm::vec3 origin_m{0.0f};         // Of the map.
  const Image<std::int32_t>& face;  // What each pixel shows.
  const PatchScene& scene;
  std::span<const std::uint8_t> patch_is_diffuse;
  const Gray8Image* mask = nullptr;  // Null, or 255 where pixels may be used.
  glm::dvec3 sky_irradiance_rgb{0.0};
  SunPrior prior;
};

struct SunFromShadows {
  glm::dvec3 irradiance_rgb{0.0};  // Normal to the beam. 0: there was none.
  glm::dvec3 stddev_rgb{0.0};
  int comparisons = 0;    // Of a lit and a shaded set of pixels.
  int shaded_pixels = 0;  // In them.
};

// The sun's irradiance under which surfaces have the same albedo in the sun and in the shade.
//
// For a lit point i and a shaded one j of one albedo, with C and S the responses to sky and sun,
// bounces included (architecture, section 4; C_i = C_j there),
//   L_i / L_j = (P_sky C_i + P_sun S_i) / (P_sky C_j + P_sun S_j).
// One such pair errs by the surface's stains, 20 % and more; so all pairs of a material are taken
// at once: P_sun is where the medians of the albedos pi L / (P_sky C + P_sun S) of the lit and of
// the shaded pixels meet. Cast shadows are compared with the sunlit part of surfaces that face the
// same way, surfaces turned from the sun with all that is sunlit. Pixels whose side of a shadow's
// edge or whose surface a misplaced mesh could change are left out.
//
// Each comparison errs by the scatter of its albedos over the map and by what its surfaces share:
// 5 %, where they face different ways 10 %; most of it common to all channels. The estimate is the
// maximum of prior and comparisons, found from the prior's median on. Comparisons have Student's t
// distribution of 4 degrees of freedom: one that contradicts the prior is left out, several that
// agree overrule it. Where there may have been no sun, that is the answer if it explains the
// comparisons better than the best sun does, by the evidence of each (Laplace's approximation).
// None where no comparison has enough pixels, or a channel of the sky is black.
std::optional<SunFromShadows> MeasureSunFromShadows(const ShadowPairsInput& input);

}  // namespace pleinair
