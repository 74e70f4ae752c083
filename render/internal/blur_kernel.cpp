#include "render/internal/blur_kernel.h"

#include <cmath>

#include <glm/common.hpp>

namespace pleinair {

BlurKernel::BlurKernel(float sigma_px) {
  const double variance = double{sigma_px} * double{sigma_px};
  const int reach = static_cast<int>(std::ceil(3.0f * sigma_px));
  double sum = 0.0;
  for (int i = 0; i <= reach; ++i) {
    const double weight = std::exp(-variance) * std::cyl_bessel_i(static_cast<double>(i), variance);
    sum += (i == 0 ? 1.0 : 2.0) * weight;
    weights_.push_back(static_cast<float>(weight));
  }
  for (float& weight : weights_) weight = static_cast<float>(double{weight} / sum);
}

PixelRect BlurKernel::Spread(const PixelRect& rect, int width, int height) const {
  if (rect.Empty()) return rect;
  return {glm::max(rect.lower - ReachPx(), glm::ivec2(0)),
          glm::min(rect.upper + ReachPx(), glm::ivec2(width, height))};
}

}  // namespace pleinair
