#include "calib/internal/pose_search.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <opencv2/calib3d.hpp>

#include "calib/internal/opencv_types.h"
#include "calib/internal/point_spread.h"

namespace pleinair {
namespace {

cv::Point3d ToOpenCv(const glm::dvec3& point) { return {point.x, point.y, point.z}; }

bool IsFinite(const glm::dmat4& pose) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      if (!std::isfinite(pose[column][row])) return false;
    }
  }
  return true;
}

// Where a pixel's ray meets the plane at distance 1.
std::optional<glm::dvec2> RayOf(const Lens& lens, const glm::dvec2& pixel) {
  const auto direction = lens.DirectionFromPixel(pixel);
  if (!direction || !(direction->z > 0.0)) return std::nullopt;
  return glm::dvec2(direction->x / direction->z, direction->y / direction->z);
}

}  // namespace

std::vector<glm::dmat4> FlatPoses(const std::vector<glm::dvec3>& points_m,
                                  const std::vector<glm::dvec2>& rays) {
  if (points_m.size() < kFewestMatches) return {};
  const PointSpread spread = SpreadOf(points_m);
  if (spread.IsALine()) return {};
  std::vector<cv::Point3d> flat;
  for (const glm::dvec3& point : points_m) {
    const glm::dvec3 at = spread.axes_from_world * (point - spread.centre);
    flat.emplace_back(at.x, at.y, 0.0);
  }
  std::vector<cv::Point2d> seen;
  seen.reserve(rays.size());
  for (const glm::dvec2& ray : rays) seen.emplace_back(ray.x, ray.y);
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  try {
    cv::solvePnPGeneric(flat,
                        seen,
                        cv::Matx33d::eye(),
                        cv::noArray(),
                        rotations,
                        translations,
                        false,
                        cv::SOLVEPNP_IPPE);
  } catch (const cv::Exception&) {
    return {};  // No homography fits: wrong matches among them.
  }
  glm::dmat4 to_plane(spread.axes_from_world);
  to_plane[3] = glm::dvec4(-spread.axes_from_world * spread.centre, 1.0);
  std::vector<glm::dmat4> poses;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    const glm::dmat4 pose = PoseFrom(rotations[i], translations[i]) * to_plane;
    if (IsFinite(pose)) poses.push_back(pose);
  }
  return poses;
}

PoseSearch::PoseSearch(const Lens& lens,
                       std::span<const PointMatch> matches,
                       const CameraPoseOptions& options)
    : lens_(lens), matches_(matches), options_(options) {
  for (const PointMatch& match : matches) {
    const auto ray = RayOf(lens, match.pixel);
    // A pixel that the lens cannot see is a wrong match.
    if (!ray) continue;
    visible_.push_back(match);
    rays_.push_back(*ray);
  }
}

std::optional<glm::dvec2> PoseSearch::Project(const glm::dmat4& pose,
                                              const PointMatch& match) const {
  return lens_.ProjectToPixel(glm::dvec3(pose * glm::dvec4(match.point_world_m, 1.0)));
}

double PoseSearch::ResidualPx(const glm::dmat4& pose, const PointMatch& match) const {
  const auto pixel = Project(pose, match);
  return pixel ? glm::distance(*pixel, match.pixel) : std::numeric_limits<double>::infinity();
}

ScoredPose PoseSearch::Score(const glm::dmat4& pose) const {
  ScoredPose scored{pose, 0.0, 0};
  const double limit = options_.inlier_px * options_.inlier_px;
  for (const PointMatch& match : matches_) {
    const double residual = ResidualPx(pose, match);
    if (residual <= options_.inlier_px) ++scored.inliers;
    scored.cost += std::min(limit, residual * residual);
  }
  return scored;
}

std::vector<PointMatch> PoseSearch::InliersOf(const glm::dmat4& pose) const {
  std::vector<PointMatch> inliers;
  for (const PointMatch& match : matches_) {
    if (ResidualPx(pose, match) <= options_.inlier_px) inliers.push_back(match);
  }
  return inliers;
}

void PoseSearch::AddFromTriple(const std::array<std::size_t, 3>& triple,
                               std::vector<glm::dmat4>& poses) const {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> rays;
  for (const std::size_t i : triple) {
    points.push_back(ToOpenCv(visible_[i].point_world_m));
    rays.emplace_back(rays_[i].x, rays_[i].y);
  }
  const cv::Point3d along = points[1] - points[0];
  const cv::Point3d across = points[2] - points[0];
  if (!(cv::norm(along.cross(across)) > kOnALine * cv::norm(along) * cv::norm(across))) return;
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  cv::solveP3P(
      points, rays, cv::Matx33d::eye(), cv::noArray(), rotations, translations, cv::SOLVEPNP_AP3P);
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    const glm::dmat4 pose = PoseFrom(rotations[i], translations[i]);
    if (IsFinite(pose)) poses.push_back(pose);
  }
}

std::vector<ScoredPose> PoseSearch::Hypotheses() const {
  constexpr std::size_t kAllTriplesUpTo = 150;  // Ten matches or fewer.
  constexpr std::size_t kMostTriples = 1000;
  constexpr std::size_t kFewestTriples = 60;
  constexpr double kMissed = 1e-5;
  std::vector<ScoredPose> found;
  std::size_t best = 0;
  const auto add = [&](const std::array<std::size_t, 3>& triple) {
    std::vector<glm::dmat4> poses;
    AddFromTriple(triple, poses);
    for (const glm::dmat4& pose : poses) {
      found.push_back(Score(pose));
      best = std::max(best, found.back().inliers);
    }
  };
  const std::size_t n = visible_.size();
  if (n * (n - 1) * (n - 2) / 6 <= kAllTriplesUpTo) {
    for (std::size_t a = 0; a < n; ++a) {
      for (std::size_t b = a + 1; b < n; ++b) {
        for (std::size_t c = b + 1; c < n; ++c) add({a, b, c});
      }
    }
  } else {
    std::mt19937_64 random(options_.seed);
    // The standard's distributions differ between libraries.
    const auto draw = [&] { return static_cast<std::size_t>(random() % n); };
    for (std::size_t tried = 0; tried < kMostTriples; ++tried) {
      const double share = static_cast<double>(best) / static_cast<double>(matches_.size());
      const double missed = std::pow(1.0 - share * share * share, static_cast<double>(tried));
      if (tried >= kFewestTriples && missed < kMissed) break;
      const std::array<std::size_t, 3> triple{draw(), draw(), draw()};
      if (triple[0] != triple[1] && triple[1] != triple[2] && triple[0] != triple[2]) add(triple);
    }
  }
  for (const glm::dmat4& pose : FlatPosesOf(visible_)) found.push_back(Score(pose));
  std::stable_sort(found.begin(), found.end(), [](const ScoredPose& a, const ScoredPose& b) {
    return a.cost < b.cost;
  });
  return found;
}

std::vector<glm::dmat4> PoseSearch::FlatPosesOf(std::span<const PointMatch> matches) const {
  std::vector<glm::dvec3> points_m;
  std::vector<glm::dvec2> rays;
  for (const PointMatch& match : matches) {
    const auto ray = RayOf(lens_, match.pixel);
    if (!ray) continue;
    points_m.push_back(match.point_world_m);
    rays.push_back(*ray);
  }
  return FlatPoses(points_m, rays);
}

}  // namespace pleinair
