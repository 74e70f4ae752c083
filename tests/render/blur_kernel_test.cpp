// Kernels against what a lens that blurs by a Gaussian makes of an edge.
#include "render/internal/blur_kernel.h"

#include <cmath>
#include <cstdlib>
#include <span>
#include <vector>

#include <gtest/gtest.h>

namespace pleinair::test::blur_kernel_test {
namespace {

// The value of a pixel with its middle at `x` in the picture of an edge at 0, by so many points of
// the pixel, through a Gaussian of that width.
double Lens(double x, double sigma_px) {
  constexpr int kPoints = 200;
  double sum = 0.0;
  for (int i = 0; i < kPoints; ++i) {
    const double at = x - 0.5 + (i + 0.5) / kPoints;
    sum += sigma_px > 0.0 ? 0.5 * std::erfc(-at / (sigma_px * std::sqrt(2.0)))
                          : static_cast<double>(at > 0.0);
  }
  return sum / kPoints;
}

// Root mean square over edges everywhere in a pixel, of the sum over the pixels beside it.
double ErrorOf(std::span<const float> weights, double sigma_px) {
  const int reach = static_cast<int>(weights.size()) - 1;
  constexpr int kPlaces = 20;
  double sum = 0.0;
  for (int place = 0; place < kPlaces; ++place) {
    const double edge = (place + 0.5) / kPlaces - 0.5;
    for (int x = -reach - 1; x <= reach + 1; ++x) {
      double blurred = 0.0;
      for (int i = -reach; i <= reach; ++i) {
        blurred += double{weights[static_cast<std::size_t>(std::abs(i))]} * Lens(x + i - edge, 0.0);
      }
      const double error = blurred - Lens(x - edge, sigma_px);
      sum += error * error;
    }
  }
  return std::sqrt(sum / kPlaces);
}

double SumOf(std::span<const float> weights) {
  double sum = double{weights.front()};
  for (std::size_t i = 1; i < weights.size(); ++i) sum += 2.0 * double{weights[i]};
  return sum;
}

TEST(BlurKernel, TakesNoLightAway) {
  for (const float sigma_px : {0.0f, 0.01f, 0.3f, 0.7f, 1.5f, 8.0f}) {
    const BlurKernel kernel(sigma_px);
    EXPECT_NEAR(SumOf(kernel.Weights()), 1.0, 1e-6) << sigma_px;
    EXPECT_LE(kernel.ReachPx(), BlurKernel::kMostReachPx);
  }
  EXPECT_TRUE(BlurKernel(0.0f).IsNone());
}

// No other width of a sampled Gaussian does better; to 1 % of its weights, what the table is good
// for.
TEST(BlurKernel, IsTheNearestToTheLens) {
  for (const float sigma_px : {0.15f, 0.29f, 0.45f, 0.8f, 1.2f}) {
    const BlurKernel kernel(sigma_px);
    const double own = ErrorOf(kernel.Weights(), double{sigma_px});
    EXPECT_LT(own, 0.045) << sigma_px;
    EXPECT_LT(own, 0.9 * ErrorOf(BlurKernel(0.0f).Weights(), double{sigma_px})) << sigma_px;
    for (const double factor : {0.9, 0.95, 1.05, 1.1}) {
      std::vector<float> other(kernel.Weights().begin(), kernel.Weights().end());
      const double ratio = double{other[1]} / double{other[0]};
      for (std::size_t i = 1; i < other.size(); ++i) {
        // exp(-i^2 / 2 v) of another v.
        other[i] = static_cast<float>(std::pow(ratio, static_cast<double>(i * i) / factor));
      }
      other[0] = 1.0f;
      const double sum = SumOf(other);
      for (float& weight : other) weight = static_cast<float>(double{weight} / sum);
      EXPECT_LT(own, 1.0001 * ErrorOf(other, double{sigma_px})) << sigma_px << " by " << factor;
    }
  }
}

TEST(BlurKernel, OfManyPixelsHasTheLensesVariance) {
  for (const float sigma_px : {1.5f, 3.0f, 8.0f}) {
    // Cut off at three deviations.
    EXPECT_NEAR(BlurKernel(sigma_px).Variance() / (double{sigma_px} * double{sigma_px}), 1.0, 0.03);
  }
}

TEST(BlurKernel, LeavesToOthersWhatTheyHaveDone) {
  for (const float sigma_px : {0.45f, 0.7f, 2.0f}) {
    EXPECT_NEAR(BlurKernel::AfterBlur(sigma_px, 1.0 / 6.0).Variance() + 1.0 / 6.0,
                BlurKernel(sigma_px).Variance(),
                1e-3);
  }
  EXPECT_TRUE(BlurKernel::AfterBlur(0.2f, 1.0 / 6.0).IsNone());
}

}  // namespace
}  // namespace pleinair::test::blur_kernel_test
