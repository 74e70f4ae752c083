#include "calib/internal/marker_corners.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Eigenvalues>
#include <glm/geometric.hpp>

namespace pleinair {
namespace {

// Bilinear; beyond the picture its edge is repeated.
double Sample(const Gray8Image& picture, const glm::dvec2& at) {
  const double x = std::clamp(at.x, 0.0, picture.width - 1.0);
  const double y = std::clamp(at.y, 0.0, picture.height - 1.0);
  const int x0 = std::min(static_cast<int>(x), picture.width - 2);
  const int y0 = std::min(static_cast<int>(y), picture.height - 2);
  const double u = x - x0;
  const double v = y - y0;
  return (1.0 - v) * ((1.0 - u) * picture.At(x0, y0) + u * picture.At(x0 + 1, y0)) +
         v * ((1.0 - u) * picture.At(x0, y0 + 1) + u * picture.At(x0 + 1, y0 + 1));
}

struct Line {
  glm::dvec2 point;
  glm::dvec2 direction;
};

std::optional<glm::dvec2> Crossing(const Line& a, const Line& b) {
  const double cross = a.direction.x * b.direction.y - a.direction.y * b.direction.x;
  if (!(std::abs(cross) > 0.05)) return std::nullopt;
  const glm::dvec2 apart = b.point - a.point;
  return a.point + a.direction * ((apart.x * b.direction.y - apart.y * b.direction.x) / cross);
}

// The steepest rise along `outwards` within `reach`: the centre of the rises about it.
std::optional<double> EdgeOffset(const Gray8Image& picture,
                                 const glm::dvec2& at,
                                 const glm::dvec2& outwards,
                                 double reach) {
  constexpr double kStep = 0.25;
  constexpr double kLeastRise = 8.0;  // Code values a pixel: below, it is noise.
  const int count = static_cast<int>(std::lround(2.0 * reach / kStep));
  std::vector<double> rise;
  double before = Sample(picture, at - outwards * (reach + 0.5 * kStep));
  for (int i = 0; i <= count; ++i) {
    const double here = Sample(picture, at + outwards * ((i + 0.5) * kStep - reach));
    rise.push_back((here - before) / kStep);
    before = here;
  }
  const auto steepest = std::max_element(rise.begin(), rise.end());
  if (!(*steepest > kLeastRise)) return std::nullopt;
  // As far as it rises at a quarter of that on both sides, and no farther on one than on the other.
  const int peak = static_cast<int>(steepest - rise.begin());
  int half = 0;
  while (peak - half - 1 >= 0 && peak + half + 1 <= count &&
         std::max(rise[static_cast<std::size_t>(peak - half - 1)],
                  rise[static_cast<std::size_t>(peak + half + 1)]) > 0.25 * *steepest) {
    ++half;
  }
  double sum = 0.0;
  double moment = 0.0;
  for (int i = peak - half; i <= peak + half; ++i) {
    const double weight = std::max(0.0, rise[static_cast<std::size_t>(i)]);
    sum += weight;
    moment += weight * (i * kStep - reach);
  }
  return moment / sum;
}

std::optional<Line> FitLine(const std::vector<glm::dvec2>& points) {
  if (points.size() < 4) return std::nullopt;
  glm::dvec2 mean(0.0);
  for (const glm::dvec2& point : points) mean += point / static_cast<double>(points.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const glm::dvec2& point : points) {
    const Eigen::Vector2d off(point.x - mean.x, point.y - mean.y);
    spread += off * off.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(spread);
  const Eigen::Vector2d direction = solver.eigenvectors().col(1);
  return Line{mean, {direction.x(), direction.y()}};
}

double DistanceTo(const Line& line, const glm::dvec2& point) {
  const glm::dvec2 off = point - line.point;
  return std::abs(off.x * line.direction.y - off.y * line.direction.x);
}

// The side from `corner` to `other`, near `corner`. `outwards` is its normal.
std::optional<Line> SideLine(const Gray8Image& picture,
                             const glm::dvec2& corner,
                             const glm::dvec2& other,
                             const glm::dvec2& outwards,
                             double reach) {
  // Near the corner the other side's edge is in the way.
  constexpr double kCornerPx = 2.0;
  constexpr double kLongestPx = 30.0;
  const double length = glm::distance(corner, other);
  const double end = std::min(length - kCornerPx, std::max(kLongestPx, 0.5 * length));
  const glm::dvec2 along = (other - corner) / length;
  std::vector<glm::dvec2> points;
  const int count = std::clamp(static_cast<int>(end - kCornerPx), 6, 64);
  for (int i = 0; i < count; ++i) {
    const glm::dvec2 at = corner + along * (kCornerPx + (end - kCornerPx) * (i + 0.5) / count);
    const auto offset = EdgeOffset(picture, at, outwards, reach);
    if (offset) points.push_back(at + outwards * *offset);
  }
  auto line = FitLine(points);
  if (!line) return std::nullopt;
  // Once more without what lies off it: dirt, a finger.
  std::vector<double> distances;
  distances.reserve(points.size());
  for (const glm::dvec2& point : points) distances.push_back(DistanceTo(*line, point));
  std::vector<double> sorted = distances;
  std::nth_element(sorted.begin(),
                   sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                   sorted.end());
  const double limit = std::max(0.2, 3.0 * sorted[sorted.size() / 2]);
  std::vector<glm::dvec2> kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (distances[i] <= limit) kept.push_back(points[i]);
  }
  return FitLine(kept);
}

}  // namespace

std::array<glm::dvec2, 4> RefinedMarkerCorners(const Gray8Image& picture,
                                               const std::array<glm::dvec2, 4>& corners_px,
                                               int cells) {
  constexpr double kShortestPx = 10.0;
  constexpr double kFarthestPx = 3.0;  // Largest error of the finder.
  std::array<glm::dvec2, 4> refined = corners_px;
  const glm::dvec2 centre = 0.25 * (corners_px[0] + corners_px[1] + corners_px[2] + corners_px[3]);
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::dvec2& corner = corners_px[i];
    std::array<std::optional<Line>, 2> lines;
    for (std::size_t k = 0; k < 2; ++k) {
      const glm::dvec2& other = corners_px[(i + (k == 0 ? 1 : 3)) % 4];
      const double length = glm::distance(corner, other);
      if (!(length >= kShortestPx)) return corners_px;
      const glm::dvec2 along = (other - corner) / length;
      glm::dvec2 outwards(-along.y, along.x);
      if (glm::dot(outwards, corner - centre) < 0.0) outwards = -outwards;
      const double reach = std::clamp(0.9 * length / cells, 1.5, kFarthestPx + 1.0);
      lines[k] = SideLine(picture, corner, other, outwards, reach);
      if (!lines[k]) return corners_px;
    }
    const auto crossing = Crossing(*lines[0], *lines[1]);
    if (!crossing || glm::distance(*crossing, corner) > kFarthestPx) return corners_px;
    refined[i] = *crossing;
  }
  return refined;
}

}  // namespace pleinair
