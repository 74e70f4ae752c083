#include <cmath>

#include "apps/viewer/overlays/per_pixel.h"

namespace pleinair {
namespace {

// Hues a golden ratio apart: neighbours in the list differ.
glm::vec3 ColourOfRegion(int region) {
  const double turn = std::fmod(0.15 + 0.618034 * region, 1.0);
  glm::vec3 colour;
  for (int c = 0; c < 3; ++c) {
    colour[c] = static_cast<float>(0.5 + 0.5 * std::cos(6.283185307 * (turn - c / 3.0)));
  }
  return colour;
}

}  // namespace

Rgba8Image DrawRegions(const OverlayInput& input) {
  return ColourSurfaces(input.view, [&](std::size_t pixel) {
    const bool may_be_sampled = input.view.may_be_sampled.pixels[pixel] != 0;
    const glm::vec3 colour =
        ColourOfRegion(input.view.region.pixels[pixel]) * (may_be_sampled ? 255.0f : 70.0f);
    return glm::u8vec4(glm::u8vec3(colour), 255);
  });
}

}  // namespace pleinair
