// The Gaussian by which a lens blurs, on a grid of pixels.
#pragma once

#include <span>
#include <vector>

#include "render/internal/screen_extent.h"

namespace pleinair {

// Lindeberg 1990, "Scale-space for discrete signals": e^-v I_i(v), whose variance is v exactly,
// below a pixel too, where a sampled Gaussian is nothing but its middle. Cut off at three standard
// deviations.
class BlurKernel {
 public:
  static constexpr float kMostSigmaPx = 8.0f;
  static constexpr int kMostReachPx = 24;

  // 0 leaves all as it is.
  explicit BlurKernel(float sigma_px = 0.0f);

  bool IsNone() const { return weights_.size() == 1; }
  int ReachPx() const { return static_cast<int>(weights_.size()) - 1; }
  // Of pixels 0 to ReachPx() away along a row or column; over both sides they add up to 1.
  std::span<const float> Weights() const { return weights_; }

  // What `rect` grows to, inside a picture of that size.
  PixelRect Spread(const PixelRect& rect, int width, int height) const;

 private:
  std::vector<float> weights_;
};

}  // namespace pleinair
