// The Gaussian by which a lens blurs, on a grid of pixels.
#pragma once

#include <span>
#include <vector>

#include "render/internal/screen_extent.h"

namespace pleinair {

// The input has been averaged over pixels already, so that pixels alone do not allow the exact blur
// of a lens. An edge between two pixels has lost no contrast yet; one across a pixel's middle has
// lost all that the average takes. The kernel is a sampled Gaussian with the variance of least
// error over all places of an edge in its pixel. For a lens of a tenth of a pixel that is 1.8 times
// the Gaussian's own variance, at 0.3 px 1.5, at 0.6 px 1.1, and from 1.5 px on that variance. Cut
// off at three standard deviations of the lens.
class BlurKernel {
 public:
  static constexpr float kMostSigmaPx = 8.0f;
  static constexpr int kMostReachPx = 24;

  // 0: no blur.
  explicit BlurKernel(float sigma_px = 0.0f);
  // The remaining blur for a picture that is already blurred by `variance_px2`.
  static BlurKernel AfterBlur(float sigma_px, double variance_px2);

  bool IsNone() const { return weights_.size() == 1; }
  int ReachPx() const { return static_cast<int>(weights_.size()) - 1; }
  // Weights of pixels 0 to ReachPx() away along a row or column; over both sides they sum to 1.
  std::span<const float> Weights() const { return weights_; }

  // Along a row or column, in px^2.
  double Variance() const;

  // `rect` with the kernel's margin, inside a picture of that size.
  PixelRect Spread(const PixelRect& rect, int width, int height) const;

 private:
  std::vector<float> weights_;
};

}  // namespace pleinair
