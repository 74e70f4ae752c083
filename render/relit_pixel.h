// The composite's radiance of a real pixel in new light.
#pragma once

#include <glm/vec3.hpp>

namespace pleinair {

// A real pixel, and the light on it before and after.
struct PixelInNewLight {
  glm::vec3 camera{0.0f};  // Radiance, as all light here in one unit.
  bool clipped = false;    // Then a lower bound.
  glm::vec3 albedo{0.0f};  // The model's.
  bool albedo_measured = false;
  glm::vec3 irradiance_before{0.0f};  // By the model: without virtual objects,
  glm::vec3 irradiance_after{0.0f};   // and with them.
};

// The pixel's new radiance.
struct RelitRadiance {
  glm::vec3 radiance{0.0f};
  bool is_changed = false;  // By more than the rounding of half floats.
};

// Channels that lose light are scaled, camera * after / before. A clipped one starts from the
// model's radiance, where that is brighter, and never exceeds the camera's. Channels that gain
// light gain what the surface reflects of it,
//   camera + r (after - before),    r = camera / before,
// which is the same ratio wherever the model is right. Where the model is wrong, `before` may be
// far too small, or 0 (a shadow that the mesh lacks, a channel of the light that vanished). So r is
// limited to what a surface can do. It is at most 1 / pi, as no surface reflects more than it gets.
// It is also at most kMostAlbedoSigmas of the albedo's error above the model's value; where the
// median channel is darker than the model, that limit is reduced in the same proportion. So a pixel
// brightens by no more than the radiance of the added light's source, and does not turn coloured
// with the light's weakest channel.
//
// Accuracy  equal to the shader's up to rounding.
RelitRadiance Relit(const PixelInNewLight& pixel);

// Least relative change: less is within the rounding of half floats.
inline constexpr float kLeastRelitChange = 1.0f / 2048.0f;
inline constexpr float kMostAlbedoSigmas = 2.0f;
// Least albedo of real surfaces; soot and black velvet are the darkest with 0.02 or so.
inline constexpr float kLeastAlbedo = 0.02f;

}  // namespace pleinair
