#include "render/internal/blur_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include <glm/common.hpp>

namespace pleinair {
namespace {

// Weights from 0 to `reach` pixels away; over both sides they add up to 1.
std::vector<double> SampledGaussian(double variance, int reach) {
  std::vector<double> weights{1.0};
  double sum = 1.0;
  for (int i = 1; i <= reach; ++i) {
    weights.push_back(variance > 0.0 ? std::exp(-0.5 * i * i / variance) : 0.0);
    sum += 2.0 * weights.back();
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

int ReachOf(double sigma_px) { return static_cast<int>(std::ceil(3.0 * sigma_px)); }

// Share of the far side that a pixel shows whose middle lies that far past a straight edge, through
// a lens that blurs by sigma_px. It is a mean over the pixel of the Gaussian's integral.
double PastEdge(double middle_px, double sigma_px) {
  const auto integral = [sigma_px](double x) {
    if (sigma_px == 0.0) return std::max(x, 0.0);
    const double z = x / sigma_px;
    return x * 0.5 * std::erfc(-z / std::numbers::sqrt2) +
           sigma_px * std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi);
  };
  return integral(middle_px + 0.5) - integral(middle_px - 0.5);
}

// Over edges everywhere in a pixel, of sharp pixels blurred by such a kernel against the lens.
double SquaredError(double variance, double sigma_px) {
  constexpr int kPlaces = 8;  // In half a pixel: the other half is the same.
  const int reach = ReachOf(sigma_px);
  const std::vector<double> weights = SampledGaussian(variance, reach);
  double sum = 0.0;
  for (int place = 0; place < kPlaces; ++place) {
    const double edge_px = 0.5 * (place + 0.5) / kPlaces;
    for (int pixel = -reach - 1; pixel <= reach + 1; ++pixel) {
      double blurred = 0.0;
      for (int i = -reach; i <= reach; ++i) {
        blurred +=
            weights[static_cast<std::size_t>(std::abs(i))] * PastEdge(pixel + i - edge_px, 0.0);
      }
      const double error = blurred - PastEdge(pixel - edge_px, sigma_px);
      sum += error * error;
    }
  }
  return sum;
}

// Search by golden sections: the error has one minimum.
double BestVariance(double sigma_px) {
  double lower = 0.0;
  double upper = sigma_px * sigma_px + 0.25;
  constexpr double kGolden = std::numbers::phi - 1.0;
  while (upper - lower > 1e-3) {
    const double a = upper - kGolden * (upper - lower);
    const double b = lower + kGolden * (upper - lower);
    if (SquaredError(a, sigma_px) < SquaredError(b, sigma_px)) {
      upper = b;
    } else {
      lower = a;
    }
  }
  return 0.5 * (lower + upper);
}

// Looked up in a table that is made once, as frames repeat their requests.
double VarianceFor(double sigma_px) {
  constexpr int kStepsPerPx = 32;
  constexpr double kAsItIsPx = 1.5;  // From here on no correction is needed.
  if (sigma_px >= kAsItIsPx) return sigma_px * sigma_px;
  static const auto table = [] {
    std::array<double, static_cast<std::size_t>(kStepsPerPx * kAsItIsPx) + 1> best{};
    for (std::size_t i = 1; i < best.size(); ++i) {
      best[i] = BestVariance(static_cast<double>(i) / kStepsPerPx);
    }
    return best;
  }();
  const double place = sigma_px * kStepsPerPx;
  const auto lower = static_cast<std::size_t>(place);
  const double weight = place - static_cast<double>(lower);
  return (1.0 - weight) * table[lower] + weight * table[lower + 1];
}

}  // namespace

BlurKernel::BlurKernel(float sigma_px) {
  const double sigma = sigma_px;
  for (const double weight : SampledGaussian(VarianceFor(sigma), ReachOf(sigma))) {
    weights_.push_back(static_cast<float>(weight));
  }
}

BlurKernel BlurKernel::AfterBlur(float sigma_px, double variance_px2) {
  const double wanted = BlurKernel(sigma_px).Variance() - variance_px2;
  if (!(wanted > 0.0)) return BlurKernel();
  // A kernel's variance rises with its sigma.
  float lower = 0.0f;
  float upper = sigma_px;
  for (int step = 0; step < 16; ++step) {
    const float middle = 0.5f * (lower + upper);
    (BlurKernel(middle).Variance() < wanted ? lower : upper) = middle;
  }
  return BlurKernel(0.5f * (lower + upper));
}

double BlurKernel::Variance() const {
  double variance = 0.0;
  for (int i = 1; i <= ReachPx(); ++i) {
    variance += 2.0 * i * i * double{weights_[static_cast<std::size_t>(i)]};
  }
  return variance;
}

PixelRect BlurKernel::Spread(const PixelRect& rect, int width, int height) const {
  if (rect.Empty()) return rect;
  return {glm::max(rect.lower - ReachPx(), glm::ivec2(0)),
          glm::min(rect.upper + ReachPx(), glm::ivec2(width, height))};
}

}  // namespace pleinair
