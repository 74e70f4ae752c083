#include "apps/viewer/overlays/per_pixel.h"

namespace pleinair {

Rgba8Image DrawNormals(const OverlayInput& input) {
  return ColourSurfaces(input.view, [&](std::size_t pixel) {
    const glm::vec3 code = 127.5f * (input.view.normal_world.pixels[pixel] + 1.0f) + 0.5f;
    return glm::u8vec4(glm::u8vec3(glm::clamp(code, 0.0f, 255.0f)), 255);
  });
}

}  // namespace pleinair
