#include <algorithm>
#include <cmath>

#include "apps/viewer/overlay.h"

namespace pleinair {

Rgba8Image DrawSampleKinds(const OverlayInput& input) {
  constexpr glm::u8vec4 kLit{255, 210, 40, 255};
  constexpr glm::u8vec4 kShaded{60, 110, 255, 255};
  constexpr glm::u8vec4 kOutlier{230, 30, 30, 255};
  constexpr int kMarkRadiusPx = 2;
  // In units of the fit's own residual: where its robust weight has nearly nothing left.
  constexpr double kOutlierResiduals = 3.0;
  constexpr double kLeastResidual = 0.05;
  const double limit =
      kOutlierResiduals * std::max(input.result.estimate.relative_residual, kLeastResidual);
  Rgba8Image picture(input.view.Width(), input.view.Height(), kNoColour);
  for (const DiffuseSample& sample : input.samples) {
    const glm::ivec2 at = sample.pixel;
    const bool is_lit = input.view.sun_visibility.Contains(at.x, at.y) &&
                        input.view.sun_visibility.At(at.x, at.y) > 0.5f &&
                        glm::dot(glm::dvec3(input.view.normal_world.At(at.x, at.y)),
                                 input.view.sun_direction_enu) > 0.0;
    const bool is_outlier =
        !(std::abs(RelativeResidual(sample, input.result.raw_lighting)) <= limit);
    DrawMark(at, kMarkRadiusPx, is_outlier ? kOutlier : is_lit ? kLit : kShaded, picture);
  }
  return picture;
}

}  // namespace pleinair
