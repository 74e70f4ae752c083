#include "calib/edge_blur.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace pleinair {
namespace {

constexpr int kReachPx = 7;  // To each side of an edge.
constexpr int kCount = 2 * kReachPx;
constexpr int kPlateauPx = 3;
constexpr std::size_t kMostEdges = 600;
constexpr int kLeastEdges = 20;
constexpr double kMisplacedPx = 2.0;
constexpr double kSteepest = 0.7;  // Of an edge against the line across it, in pixels a line.
// A pixel's own square.
constexpr double kPixelVariance = 1.0 / 12.0;
// Softer is more than a lens in focus does, and less is not worth drawing.
constexpr double kMostPx = 2.5;
constexpr double kLeastPx = 0.25;

using Profile = std::array<double, kCount>;

struct Line {
  glm::ivec2 pixel;   // Before the edge.
  glm::ivec2 across;  // One step.
};

double Light(const RgbImage& radiance, const glm::ivec2& at) {
  const glm::vec3& rgb = radiance.At(at.x, at.y);
  return (double{rgb.r} + double{rgb.g} + double{rgb.b}) / 3.0;
}

bool IsModelEdge(const SurfaceView& view, const glm::ivec2& a, const glm::ivec2& b) {
  const std::size_t i = view.region.Index(a.x, a.y);
  const std::size_t j = view.region.Index(b.x, b.y);
  if (view.region.pixels[i] != view.region.pixels[j]) return true;
  if (view.region.pixels[i] == SurfaceView::kNoRegion) return false;
  constexpr float kSameFacing = 0.94f;  // 20 deg.
  const glm::vec3& normal = view.normal_world.pixels[i];
  if (glm::dot(normal, view.normal_world.pixels[j]) < kSameFacing) return true;
  const glm::vec3 step = view.position_world_m.pixels[j] - view.position_world_m.pixels[i];
  constexpr float kBehind = 0.35f;  // Of the step, off the plane: beyond a bend of 20 deg.
  return std::abs(glm::dot(normal, step)) > kBehind * glm::length(step);
}

bool ShadowChanges(const SurfaceView& view, const glm::ivec2& a, const glm::ivec2& b) {
  constexpr float kSameShare = 0.02f;
  return std::abs(view.sun_visibility.At(a.x, a.y) - view.sun_visibility.At(b.x, b.y)) > kSameShare;
}

// Whether the model has one edge there, in the middle, and no other, of shadow neither.
bool IsAlone(const SurfaceView& view, const Line& line) {
  for (int i = -kReachPx + 1; i < kReachPx; ++i) {
    if (i == 0) continue;
    const glm::ivec2 a = line.pixel + i * line.across;
    if (IsModelEdge(view, a, a + line.across) || ShadowChanges(view, a, a + line.across)) {
      return false;
    }
  }
  return true;
}

std::vector<Line> LinesAcrossEdges(const Gray8Image& clipped, const SurfaceView& view) {
  std::vector<Line> lines;
  for (int y = kReachPx; y < view.Height() - kReachPx - 1; ++y) {
    for (int x = kReachPx; x < view.Width() - kReachPx - 1; ++x) {
      for (const glm::ivec2& across : {glm::ivec2(1, 0), glm::ivec2(0, 1)}) {
        const Line line{{x, y}, across};
        if (!IsModelEdge(view, line.pixel, line.pixel + across) || !IsAlone(view, line)) continue;
        bool is_read = true;
        for (int i = -kReachPx + 1; i <= kReachPx && !clipped.Empty(); ++i) {
          const glm::ivec2 at = line.pixel + i * across;
          is_read = is_read && clipped.At(at.x, at.y) == 0;
        }
        if (is_read) lines.push_back(line);
      }
    }
  }
  return lines;
}

double StepAt(double x) { return 0.5 * std::erfc(-x * std::numbers::sqrt2 / 2.0); }

// Squared error of the best step at x0, as wide as sigma.
double ErrorOf(const Profile& profile, double x0, double sigma) {
  double s = 0.0, ss = 0.0, p = 0.0, sp = 0.0, pp = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const double step = StepAt((i - x0) / sigma);
    const double value = profile[static_cast<std::size_t>(i)];
    s += step;
    ss += step * step;
    p += value;
    sp += step * value;
    pp += value * value;
  }
  const double variance = ss - s * s / kCount;
  const double covariance = sp - s * p / kCount;
  return pp - p * p / kCount - covariance * covariance / variance;
}

// Width of the step along the line; none where it shows something else.
std::optional<double> WidthOf(Profile profile) {
  double low = 0.0;
  double high = 0.0;
  for (std::size_t i = 0; i < kPlateauPx; ++i) {
    low += profile[i] / kPlateauPx;
    high += profile[kCount - 1 - i] / kPlateauPx;
  }
  const double contrast = high - low;
  constexpr double kLeastContrast = 0.1;  // Of both sides' sum.
  if (!(std::abs(contrast) > kLeastContrast * (low + high))) return std::nullopt;
  for (double& value : profile) value = (value - low) / contrast;  // From 0 to 1.
  constexpr double kEven = 0.06;
  for (std::size_t i = 0; i < kPlateauPx; ++i) {
    if (std::abs(profile[i]) > kEven || std::abs(profile[kCount - 1 - i] - 1.0) > kEven) {
      return std::nullopt;
    }
  }
  // Where half of the step is behind: by its area, which noise moves little.
  double area = 0.0;
  for (const double value : profile) area += 1.0 - value;
  const double middle = area - 0.5;
  if (!(std::abs(middle - (kReachPx - 0.5)) <= kMisplacedPx)) return std::nullopt;

  constexpr int kWidths = 24;
  constexpr double kNarrowest = 0.2;
  const double ratio = std::pow(1.2 * kMostPx / kNarrowest, 1.0 / (kWidths - 1));
  std::array<double, kWidths> errors{};
  for (int k = 0; k < kWidths; ++k) {
    const double sigma = kNarrowest * std::pow(ratio, k);
    double least = ErrorOf(profile, middle, sigma);
    for (const double off : {-0.3, -0.2, -0.1, 0.1, 0.2, 0.3}) {
      least = std::min(least, ErrorOf(profile, middle + off, sigma));
    }
    errors[static_cast<std::size_t>(k)] = least;
  }
  const auto best =
      static_cast<int>(std::min_element(errors.begin(), errors.end()) - errors.begin());
  constexpr double kGoodFit = 0.04;  // Root mean square, of the step.
  const double error = errors[static_cast<std::size_t>(best)];
  if (!(error <= kGoodFit * kGoodFit * kCount) || best == kWidths - 1) return std::nullopt;
  double place = best;
  if (best > 0) {
    const double before = errors[static_cast<std::size_t>(best) - 1];
    const double after = errors[static_cast<std::size_t>(best) + 1];
    const double bend = before - 2.0 * error + after;
    if (bend > 0.0) place += std::clamp(0.5 * (before - after) / bend, -0.5, 0.5);
  }
  return kNarrowest * std::pow(ratio, place);
}

// How far the edge goes sideways from line to line.
double SlantOf(const RgbImage& radiance, const Line& line) {
  const glm::ivec2 along(line.across.y, line.across.x);
  double difference = 0.0;
  for (int i = -kReachPx + 1; i <= kReachPx; ++i) {
    const glm::ivec2 at = line.pixel + i * line.across;
    difference += 0.5 * (Light(radiance, at + along) - Light(radiance, at - along));
  }
  const double step = Light(radiance, line.pixel + kReachPx * line.across) -
                      Light(radiance, line.pixel - (kReachPx - 1) * line.across);
  return std::abs(difference / step);
}

}  // namespace

EdgeBlur MeasureEdgeBlur(const RgbImage& radiance,
                         const Gray8Image& clipped,
                         const SurfaceView& view) {
  const bool fits =
      radiance.width == view.Width() && radiance.height == view.Height() &&
      (clipped.Empty() || (clipped.width == view.Width() && clipped.height == view.Height()));
  if (!fits) {
    throw std::invalid_argument("edge blur: a picture of " + std::to_string(radiance.width) + "x" +
                                std::to_string(radiance.height) + ", expected the view's " +
                                std::to_string(view.Width()) + "x" + std::to_string(view.Height()));
  }
  const std::vector<Line> lines = LinesAcrossEdges(clipped, view);
  const std::size_t stride = (lines.size() + kMostEdges - 1) / kMostEdges;
  std::vector<double> widths_px;
  for (std::size_t k = 0; k < lines.size(); k += stride) {
    const Line& line = lines[k];
    Profile profile{};
    for (int i = 0; i < kCount; ++i) {
      profile[static_cast<std::size_t>(i)] =
          Light(radiance, line.pixel + (i - kReachPx + 1) * line.across);
    }
    // NaN and infinities fail every test of WidthOf.
    const std::optional<double> width_px = WidthOf(profile);
    if (!width_px) continue;
    const double slant = SlantOf(radiance, line);
    if (!(slant <= kSteepest)) continue;
    widths_px.push_back(*width_px / std::sqrt(1.0 + slant * slant));
  }
  EdgeBlur blur;
  blur.edges = static_cast<int>(widths_px.size());
  blur.is_measured = blur.edges >= kLeastEdges;
  if (!blur.is_measured) return blur;
  const auto quarter = widths_px.begin() + static_cast<std::ptrdiff_t>(widths_px.size() / 4);
  std::nth_element(widths_px.begin(), quarter, widths_px.end());
  const double variance = *quarter * *quarter - kPixelVariance;
  const double sigma_px = variance > 0.0 ? std::sqrt(variance) : 0.0;
  if (sigma_px >= kLeastPx && sigma_px <= kMostPx) blur.sigma_px = sigma_px;
  return blur;
}

}  // namespace pleinair
