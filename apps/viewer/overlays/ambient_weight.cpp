#include "apps/viewer/overlays/per_pixel.h"

namespace pleinair {

// Of the sky's first shape, bounces included, mean over RGB.
Rgba8Image DrawAmbientWeight(const OverlayInput& input) {
  return ColourSurfaces(input.view, [&](std::size_t pixel) {
    if (input.view.sky_response.empty()) return kNoColour;
    const glm::vec3& weight = input.view.sky_response.front().pixels[pixel];
    return ColourOfShare((weight.x + weight.y + weight.z) / 3.0f);
  });
}

}  // namespace pleinair
