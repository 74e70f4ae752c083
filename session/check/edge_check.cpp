#include "session/check/edge_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "calib/lens.h"
#include "session/check/segment_fit.h"

namespace pleinair {
namespace {

// Pictures are reduced to this width.
constexpr int kEdgeWidth = 240;
constexpr int kEdgeReach = 14;
constexpr int kEdgeSide = 2 * kEdgeReach + 1;
// Largest step of log radiance: one strong edge must not outweigh all others.
constexpr double kMostContrast = 0.4;
// Halves are the two colours of a chessboard with such fields.
constexpr int kEdgeFieldPx = 40;
constexpr int kLeastEdgePixels = 100;

RgbImage ReducedTo(const RgbImage& picture, int width, int height) {
  RgbImage small(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int x0 = x * picture.width / width;
      const int x1 = std::max(x0 + 1, (x + 1) * picture.width / width);
      const int y0 = y * picture.height / height;
      const int y1 = std::max(y0 + 1, (y + 1) * picture.height / height);
      glm::dvec3 sum(0.0);
      for (int v = y0; v < y1; ++v) {
        for (int u = x0; u < x1; ++u) sum += glm::dvec3(picture.At(u, v));
      }
      small.At(x, y) = glm::vec3(sum / double((x1 - x0) * (y1 - y0)));
    }
  }
  return small;
}

// Two pixels with an edge of the mesh between them.
struct EdgePair {
  glm::ivec2 a;
  glm::ivec2 b;
};

// A pixel apart from the edge, so that an edge that is half a pixel off is still between them.
std::vector<EdgePair> EdgePairsOf(const Segments& segments) {
  std::vector<EdgePair> pairs;
  const auto& label = segments.label;
  constexpr int kMargin = kEdgeReach + 2;
  for (int y = kMargin; y < label.height - kMargin - 1; ++y) {
    for (int x = kMargin; x < label.width - kMargin - 1; ++x) {
      if (label.At(x, y) != label.At(x + 1, y)) pairs.push_back({{x - 1, y}, {x + 2, y}});
      if (label.At(x, y) != label.At(x, y + 1)) pairs.push_back({{x, y - 1}, {x, y + 2}});
    }
  }
  return pairs;
}

struct Peak {
  glm::ivec2 shift_px{0};
  double sharpness = 0.0;
  double sharpness_as_stated = 0.0;
};

Peak PeakOf(const std::vector<double>& contrast) {
  Peak peak;
  double sum = 0.0;
  double squares = 0.0;
  for (const double value : contrast) {
    sum += value;
    squares += value * value;
  }
  const auto count = static_cast<double>(contrast.size());
  const double mean = sum / count;
  const double stddev = std::sqrt(std::max(0.0, squares / count - mean * mean));
  if (!(stddev > 0.0)) return peak;
  const auto best = std::max_element(contrast.begin(), contrast.end());
  const int index = static_cast<int>(best - contrast.begin());
  peak.shift_px = {index % kEdgeSide - kEdgeReach, index / kEdgeSide - kEdgeReach};
  peak.sharpness = (*best - mean) / stddev;
  peak.sharpness_as_stated = (contrast[contrast.size() / 2] - mean) / stddev;
  return peak;
}

}  // namespace

bool EdgeFit::IsShifted() const {
  constexpr double kTolerance = 0.018;
  constexpr double kLeastSharpness = 2.4;
  return is_agreed && sharpness >= kLeastSharpness && glm::length(shift) > kTolerance;
}

bool EdgeFit::IsLost() const {
  constexpr double kLeastAsStated = 1.0;
  return sharpness > 0.0 && sharpness_as_stated < kLeastAsStated && !IsShifted();
}

void EdgeChecker::Add(const RgbImage& radiance, const Camera& camera) {
  const int width = std::min(kEdgeWidth, radiance.width);
  const int height =
      std::max(1, static_cast<int>(std::lround(double(width) * radiance.height / radiance.width)));
  const double scale = double(radiance.width) / width;
  const Lens lens(camera.intrinsics);
  const glm::dmat3 world_from_camera = glm::transpose(glm::dmat3(camera.camera_from_world));
  const auto direction = [&](int x, int y) {
    const auto along = lens.DirectionFromPixel({(x + 0.5) * scale - 0.5, (y + 0.5) * scale - 0.5});
    return along ? glm::normalize(world_from_camera * *along) : glm::dvec3(0.0);
  };
  const Segments segments =
      SegmentsOf(mesh_, caster_, {camera.CentreWorldM(), width, height, direction});
  const std::vector<EdgePair> pairs = EdgePairsOf(segments);
  if (pairs.size() < kLeastEdgePixels) return;
  const RgbImage picture = LogRadiance(ReducedTo(radiance, width, height));
  const double share = 1.0 / static_cast<double>(pairs.size());
  for (std::vector<double>& half : contrast_) half.resize(kEdgeSide * kEdgeSide);
  for (const EdgePair& pair : pairs) {
    const int field = pair.a.x / kEdgeFieldPx + pair.a.y / kEdgeFieldPx;
    std::vector<double>& half = contrast_[field % 2];
    std::size_t index = 0;
    for (int dy = -kEdgeReach; dy <= kEdgeReach; ++dy) {
      for (int dx = -kEdgeReach; dx <= kEdgeReach; ++dx) {
        const glm::vec3 step =
            picture.At(pair.a.x + dx, pair.a.y + dy) - picture.At(pair.b.x + dx, pair.b.y + dy);
        const double mean = (double(std::abs(step.x)) + std::abs(step.y) + std::abs(step.z)) / 3.0;
        half[index++] += share * std::min(kMostContrast, mean);
      }
    }
  }
}

EdgeFit EdgeChecker::Result() const {
  EdgeFit fit;
  if (contrast_[0].empty()) return fit;
  std::vector<double> all = contrast_[0];
  for (std::size_t i = 0; i < all.size(); ++i) all[i] += contrast_[1][i];
  const Peak peak = PeakOf(all);
  fit.shift = glm::dvec2(peak.shift_px) / double(kEdgeWidth);
  fit.sharpness = peak.sharpness;
  fit.sharpness_as_stated = peak.sharpness_as_stated;
  constexpr int kAgreedPx = 3;
  fit.is_agreed = true;
  for (const std::vector<double>& half : contrast_) {
    const glm::ivec2 apart = PeakOf(half).shift_px - peak.shift_px;
    if (std::max(std::abs(apart.x), std::abs(apart.y)) > kAgreedPx) fit.is_agreed = false;
  }
  return fit;
}

}  // namespace pleinair
