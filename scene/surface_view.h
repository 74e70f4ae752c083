// The real scene in one camera view, pixel by pixel: the common model of the lighting estimate and
// the composite. Made by relight, plain data.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/camera.h"
#include "scene/image.h"
#include "scene/judged_sun.h"
#include "scene/state_id.h"

namespace pleinair {

// Response of an ideal white surface at the pixel to unit basis lights, so that
//   radiance = albedo / pi * (sum_k sky_irradiance_k * sky[k] + sun_irradiance * SunResponse)
// (jensen-2006, section 4.2, with bounces). All images have the view's size; a pixel that shows no
// surface has region kNoRegion and zeros elsewhere.
struct SurfaceView {
  static constexpr std::int32_t kNoRegion = -1;

  Camera camera;
  // False: only the pixels that somebody looks at are made, and the others are as if they showed no
  // surface.
  bool is_whole = true;
  std::vector<std::string> region_names;  // The mesh's groups.
  Image<std::int32_t> region;             // Into region_names, or kNoRegion.
  Image<glm::vec3> position_world_m;
  Image<glm::vec3> normal_world;  // Unit, turned to the camera.
  Image<glm::vec3> albedo_rgb;
  Image<std::uint8_t> albedo_measured;  // 1: from the survey, 0: filled by material or Kd.
  Image<std::uint8_t> may_be_sampled;   // 1: diffuse region, inside the masks, reliable.
  // kUnknown outside the frame's sample polygons; empty where it has none.
  Image<JudgedSun> judged_sun;
  std::vector<std::string> sky_shape_names;    // As in lighting.jsonl's sky_shape.
  std::vector<Image<glm::vec3>> sky_response;  // Per sky shape: c + c_bounce.
  Image<float> sun_visibility;                 // s, visible share of the disc, 0..1.
  Image<glm::vec3> sun_bounce;                 // s_bounce.
  // Distance to the nearest pixel where the model jumps: mesh edge, shadow edge of now, shadow edge
  // of the survey, picture border.
  Image<float> edge_distance_px;
  Image<float> footprint_radius_px;  // Half a survey texel, in pixels of this view; at least 0.5.

  glm::dvec3 sun_direction_enu{0.0, 0.0, 1.0};  // The sun of the sun_* images.

  // A new identity whenever the images change that it stands for: the keys of what is derived from
  // them or uploaded. Where they are not set, nothing is kept.
  StateId geometry_id;  // Of all other images.
  StateId sky_id;       // Of sky_response.
  StateId sun_id;       // Of the sun_* images and edge_distance_px.

  int Width() const { return region.width; }
  int Height() const { return region.height; }
};

// s * max(0, n.l) + s_bounce, with n.l for `sun_direction_enu` (which may have moved a little since
// the visibility was cast).
glm::vec3 SunResponse(const SurfaceView& view,
                      std::size_t pixel,
                      const glm::dvec3& sun_direction_enu);

}  // namespace pleinair
