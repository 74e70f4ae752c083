// A real pixel in new light: what the composite makes of it.
#pragma once

#include <glm/vec3.hpp>

namespace pleinair {

struct PixelInNewLight {
  glm::vec3 camera{0.0f};  // Radiance, as all light here in one unit.
  bool clipped = false;    // Then a lower bound.
  glm::vec3 albedo{0.0f};  // The model's.
  bool albedo_measured = false;
  glm::vec3 irradiance_before{0.0f};  // By the model: as the camera saw the pixel,
  glm::vec3 irradiance_after{0.0f};   // and with virtual objects.
};

struct RelitRadiance {
  glm::vec3 radiance{0.0f};
  bool is_changed = false;  // By more than a half float rounds off.
};

// Channels that lose light are scaled, camera * after / before: a clipped one from the model's
// radiance, where that is the brighter, and never to more than the camera's. Channels that gain
// light gain what the surface reflects of it,
//   camera + r (after - before),    r = camera / before,
// which is the same ratio wherever the model is right. `before` may be far too small, or 0, where
// it is wrong (a shadow that the mesh lacks, a channel of the light that vanished), so that r is
// held to what the surface can do: to 1 / pi, as it sends back no more than it gets, and to
// kMostAlbedoSigmas of the albedo's error above the model's, or above what the median channel has
// of that where it is darker. So a pixel brightens by no more than the radiance of what shines on
// it, and does not turn coloured with the light's weakest channel.
//
// Accuracy  the shader's to rounding.
RelitRadiance Relit(const PixelInNewLight& pixel);

// What a half float would round off is no change; relative.
inline constexpr float kLeastRelitChange = 1.0f / 2048.0f;
inline constexpr float kMostAlbedoSigmas = 2.0f;
// Least albedo of real surfaces; soot and black velvet are the darkest with 0.02 or so.
inline constexpr float kLeastAlbedo = 0.02f;

}  // namespace pleinair
