#include "apps/viewer/overlays/per_pixel.h"

namespace pleinair {

Rgba8Image DrawAlbedo(const OverlayInput& input) {
  return ColourSurfaces(input.view, [&](std::size_t pixel) {
    const glm::vec3& albedo = input.view.albedo_rgb.pixels[pixel];
    return glm::u8vec4(DisplayCode(albedo.x), DisplayCode(albedo.y), DisplayCode(albedo.z), 255);
  });
}

}  // namespace pleinair
