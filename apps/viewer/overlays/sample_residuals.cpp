#include "apps/viewer/overlay.h"

namespace pleinair {

Rgba8Image DrawSampleResiduals(const OverlayInput& input) {
  constexpr double kFullColour = 0.3;
  constexpr int kMarkRadiusPx = 2;
  Rgba8Image picture(input.view.Width(), input.view.Height(), kNoColour);
  const ResponseCorrection& response = input.result.estimate.response;
  const LensCircle circle = LensCircle::Of(picture.width, picture.height);
  for (DiffuseSample sample : input.samples) {
    const double share = circle.ShareOfCorner(glm::dvec2(sample.pixel) + 0.5);
    sample.radiance_rgb = LightOf(sample.radiance_rgb, response, share);
    const double residual = RelativeResidual(sample, input.result.raw_lighting);
    DrawMark(sample.pixel,
             kMarkRadiusPx,
             ColourOfDifference(static_cast<float>(residual / kFullColour)),
             picture);
  }
  return picture;
}

}  // namespace pleinair
