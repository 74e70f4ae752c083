// One measured patch of a diffuse surface, and how it answers to each basis light.
#pragma once

#include <array>
#include <cstdint>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace pleinair {

// The most sky shapes that one estimate can distinguish; it bounds the size of the fit's matrices.
inline constexpr int kMaxSkyShapes = 5;

// Means over one footprint, so that under a Lighting
//   radiance = sun_irradiance * sun_transport + sum_k sky_irradiance_k * sky_transport[k]
// (jensen-2006, the rendering equation of section 4.2, with albedo / pi folded in). RGB throughout.
struct DiffuseSample {
  glm::dvec3 radiance_rgb{0.0};
  glm::dvec3 sun_transport_rgb{0.0};  // albedo / pi * SunResponse
  std::array<glm::dvec3, kMaxSkyShapes> sky_transport_rgb{};
  // Its albedo where a survey has measured it; else 0. Known to the fit of the light only to tell a
  // pattern on a surface from light.
  glm::dvec3 measured_albedo_rgb{0.0};
  glm::dvec3 radiance_stddev_rgb{0.0};  // From the camera's noise only; 0 where negligible.
  double weight = 1.0;                  // Share of an ordinary sample's information; 0 leaves out.
  // Samples of one plane (region and facing; lit and shaded) share a part of their model's error.
  std::int32_t plane = 0;
  bool is_lit = false;  // By the sun, directly, as the model has it.
  glm::ivec2 pixel{0};
  // Where it was drawn: the same from frame to frame while the place is in view.
  glm::vec3 place_world_m{0.0f};
  int pixels = 1;  // The number of pixels that radiance_rgb is the mean of.
  // The last estimate gave it a robust weight of 0, or could not use it at all.
  bool is_rejected = false;
};

}  // namespace pleinair
