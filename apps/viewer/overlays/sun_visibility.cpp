#include "apps/viewer/overlays/per_pixel.h"

namespace pleinair {

Rgba8Image DrawSunVisibility(const OverlayInput& input) {
  const glm::vec3 sun(input.view.sun_direction_enu);
  return ColourSurfaces(input.view, [&](std::size_t pixel) {
    const bool faces_it = glm::dot(input.view.normal_world.pixels[pixel], sun) > 0.0f;
    const float share = faces_it ? input.view.sun_visibility.pixels[pixel] : 0.0f;
    const glm::vec3 colour = share * glm::vec3(255.0f, 220.0f, 60.0f) + 0.5f;
    return glm::u8vec4(glm::u8vec3(colour), 255);
  });
}

}  // namespace pleinair
