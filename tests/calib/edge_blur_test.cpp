#include "calib/edge_blur.h"

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>
#include <glm/vec2.hpp>

namespace pleinair::edge_blur_test {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;

// A straight edge through the middle of the picture, slanted by `slant_rad`: 4 to its left, 1 to
// its right, as a pixel's square and a Gaussian of sigma_px make it. The model has the edge
// `misplaced_px` farther right.
struct Edge {
  explicit Edge(double slant_rad,
                double sigma_px,
                double noise = 0.0,
                double misplaced_px = 0.0,
                bool is_upright = true) {
    view.region = Image<std::int32_t>(kWidth, kHeight, 0);
    view.normal_world = RgbImage(kWidth, kHeight, {0.0f, 0.0f, 1.0f});
    view.position_world_m = RgbImage(kWidth, kHeight);
    view.sun_visibility = GrayImage(kWidth, kHeight, 1.0f);
    picture = RgbImage(kWidth, kHeight);
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const double across = is_upright ? x - kWidth / 2.0 : y - kHeight / 2.0;
        const double along = is_upright ? y - kHeight / 2.0 : x - kWidth / 2.0;
        double step = 0.0;
        for (int i = 0; i < 8; ++i) {
          for (int j = 0; j < 8; ++j) {
            const double a = across + (i - 3.5) / 8.0;
            const double b = along + (j - 3.5) / 8.0;
            const double distance = a * std::cos(slant_rad) + b * std::sin(slant_rad);
            step += sigma_px > 0.0
                        ? 0.5 * std::erfc(distance / sigma_px / std::numbers::sqrt2) / 64.0
                        : (distance < 0.0 ? 1.0 / 64.0 : 0.0);
          }
        }
        const double light = (1.0 + 3.0 * step) * (1.0 + noise * normal(random));
        picture.At(x, y) = glm::vec3(static_cast<float>(light));
        const double model =
            (across - misplaced_px) * std::cos(slant_rad) + along * std::sin(slant_rad);
        view.region.At(x, y) = model < 0.0 ? 0 : 1;
      }
    }
  }
  SurfaceView view;
  RgbImage picture;
};

EdgeBlur BlurOf(const RgbImage& picture, const Gray8Image& clipped, const SurfaceView& view) {
  EdgeBlurMeter meter;
  meter.Add(picture, clipped, view);
  return meter.Blur();
}

TEST(EdgeBlur, IsTheLenss) {
  for (const double slant_rad : {0.0, 0.15, -0.5}) {
    for (const double sigma_px : {0.25, 0.35, 0.5, 1.0, 1.8}) {
      for (const bool is_upright : {true, false}) {
        const Edge edge(slant_rad, sigma_px, 0.01, 0.7, is_upright);
        const EdgeBlur blur = BlurOf(edge.picture, {}, edge.view);
        EXPECT_GE(blur.edges, 20);
        // Of the entire width, to which a narrow lens adds little: half for the grid of widths and
        // its parabola, half for noise.
        EXPECT_NEAR(blur.sigma_px, sigma_px, 0.1 * sigma_px)
            << "slant " << slant_rad << " upright " << is_upright;
      }
    }
  }
}

TEST(EdgeBlur, ASharpPictureHasNone) {
  for (const double slant_rad : {0.1, 0.5}) {
    const Edge edge(slant_rad, 0.0, 0.005);
    const EdgeBlur blur = BlurOf(edge.picture, {}, edge.view);
    EXPECT_EQ(blur.sigma_px, 0.0);
    EXPECT_TRUE(blur.is_measured);
  }
}

// As `value + amount (value - blurred)` of a camera: an unsharp mask of 1.2 px.
RgbImage Sharpened(const RgbImage& picture, float amount) {
  constexpr int kReach = 4;
  const auto blurred_along = [](const RgbImage& from, const glm::ivec2& step) {
    RgbImage to = from;
    for (int y = kReach; y < from.height - kReach; ++y) {
      for (int x = kReach; x < from.width - kReach; ++x) {
        glm::vec3 sum(0.0f);
        float weights = 0.0f;
        for (int i = -kReach; i <= kReach; ++i) {
          const float weight = std::exp(-0.5f * static_cast<float>(i * i) / (1.2f * 1.2f));
          sum += weight * from.At(x + i * step.x, y + i * step.y);
          weights += weight;
        }
        to.At(x, y) = sum / weights;
      }
    }
    return to;
  };
  const RgbImage blurred = blurred_along(blurred_along(picture, {1, 0}), {0, 1});
  RgbImage sharpened = picture;
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    sharpened.pixels[i] += amount * (picture.pixels[i] - blurred.pixels[i]);
  }
  return sharpened;
}

// However strongly: a few lines beside that look wider, a shadow's, do not decide.
TEST(EdgeBlur, ASharpenedPictureHasNone) {
  const Edge wide(0.2, 1.5, 0.01);
  for (const float amount : {0.4f, 1.0f, 1.5f, 2.0f}) {
    const Edge sharp(0.2, 0.3, 0.01);
    EdgeBlurMeter meter;
    meter.Add(Sharpened(sharp.picture, amount), {}, sharp.view);
    // Most of the wide edge is clipped.
    Gray8Image clipped(kWidth, kHeight, 0);
    for (int y = 30; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) clipped.At(x, y) = 1;
    }
    meter.Add(wide.picture, clipped, wide.view);
    const EdgeBlur blur = meter.Blur();
    EXPECT_TRUE(blur.is_measured) << amount;
    EXPECT_LT(blur.sigma_px, 0.35) << amount;
  }
}

// Half of the edges are round or stand before a penumbra, each in its own way.
TEST(EdgeBlur, IsWhatMostEdgesAgreeOn) {
  EdgeBlurMeter meter;
  const auto add = [&meter](double sigma_px) {
    const Edge edge(0.2, sigma_px, 0.01);
    meter.Add(edge.picture, {}, edge.view);
  };
  for (int i = 0; i < 3; ++i) add(0.3);
  for (const double other_px : {0.5, 0.9, 1.4}) add(other_px);
  EXPECT_NEAR(meter.Blur().sigma_px, 0.3, 0.03);
}

// Each of them alone has too few edges.
TEST(EdgeBlur, IsMeasuredFromAllPicturesTogether) {
  EdgeBlurMeter meter;
  Edge edge(0.1, 0.6, 0.01);
  for (int y = 0; y < kHeight; ++y) {
    if (y >= 40 && y < 48) continue;
    for (int x = 0; x < kWidth; ++x) edge.view.region.At(x, y) = 0;
  }
  meter.Add(edge.picture, {}, edge.view);
  EXPECT_GT(meter.Blur().edges, 0);
  EXPECT_FALSE(meter.Blur().is_measured);
  for (int i = 0; i < 4; ++i) meter.Add(edge.picture, {}, edge.view);
  EXPECT_TRUE(meter.Blur().is_measured);
  EXPECT_NEAR(meter.Blur().sigma_px, 0.6, 0.06);
}

TEST(EdgeBlur, IsEmptyWithoutEvidence) {
  Edge edge(0.1, 1.0);
  const RgbImage even(kWidth, kHeight, glm::vec3(1.0f));
  EXPECT_EQ(BlurOf(even, {}, edge.view).edges, 0) << "no contrast";
  EXPECT_EQ(BlurOf(Edge(0.1, 1.0, 0.0, 5.0).picture, {}, Edge(0.1, 1.0, 0.0, 5.0).view).sigma_px,
            0.0)
      << "the model is elsewhere";
  const Gray8Image clipped(kWidth, kHeight, 1);
  EXPECT_EQ(BlurOf(edge.picture, clipped, edge.view).edges, 0) << "clipped";
  const RgbImage broken(kWidth, kHeight, glm::vec3(NAN));
  EXPECT_EQ(BlurOf(broken, {}, edge.view).edges, 0) << "not finite";
  // Under a penumbra beside the edge.
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      edge.view.sun_visibility.At(x, y) = static_cast<float>(x % 5) / 5.0f;
    }
  }
  EXPECT_EQ(BlurOf(edge.picture, {}, edge.view).edges, 0) << "shadows";
  EXPECT_FALSE(BlurOf(RgbImage(), {}, SurfaceView()).is_measured) << "empty";
}

TEST(EdgeBlur, RefusesAPictureOfAnotherSize) {
  const Edge edge(0.1, 1.0);
  EXPECT_THROW(BlurOf(RgbImage(3, 3), {}, edge.view), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::edge_blur_test
