#include <glm/geometric.hpp>

#include "apps/viewer/overlay.h"

namespace pleinair {

Rgba8Image DrawSampleKinds(const OverlayInput& input) {
  constexpr glm::u8vec4 kLit{255, 210, 40, 255};
  constexpr glm::u8vec4 kShaded{60, 110, 255, 255};
  constexpr glm::u8vec4 kOutlier{230, 30, 30, 255};
  constexpr int kMarkRadiusPx = 2;
  Rgba8Image picture(input.view.Width(), input.view.Height(), kNoColour);
  for (const DiffuseSample& sample : input.samples) {
    const glm::ivec2 at = sample.pixel;
    const bool is_lit = input.view.sun_visibility.At(at.x, at.y) > 0.5f &&
                        glm::dot(glm::dvec3(input.view.normal_world.At(at.x, at.y)),
                                 input.view.sun_direction_enu) > 0.0;
    DrawMark(at, kMarkRadiusPx, sample.is_rejected ? kOutlier : is_lit ? kLit : kShaded, picture);
  }
  return picture;
}

}  // namespace pleinair
