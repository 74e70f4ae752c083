#include "calib/reconstruction/plane_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>

#include <Eigen/Eigenvalues>

namespace pleinair {
namespace {

constexpr std::size_t kMostScored = 20000;
constexpr int kHypotheses = 600;
// A spread across a line below this share of the one along it is no plane's.
constexpr double kLeastFlatness = 1e-4;

Eigen::Vector3d AsEigen(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

// Not std::uniform_int_distribution, whose results differ between libraries.
std::size_t Draw(std::mt19937_64& random, std::size_t count) { return random() % count; }

// Indices of a few points that are near each other: the nearest of a handful to the first.
std::array<std::size_t, 3> DrawNeighbours(std::span<const glm::dvec3> points,
                                          std::mt19937_64& random) {
  constexpr std::size_t kDrawn = 24;
  constexpr std::size_t kKept = 6;
  const std::size_t first = Draw(random, points.size());
  std::array<std::pair<double, std::size_t>, kDrawn> others;
  for (auto& [distance, index] : others) {
    index = Draw(random, points.size());
    distance = glm::distance(points[first], points[index]);
  }
  std::partial_sort(others.begin(), others.begin() + kKept, others.end());
  return {first, others[Draw(random, kKept)].second, others[Draw(random, kKept)].second};
}

std::optional<Plane> PlaneThrough(std::span<const glm::dvec3> points,
                                  const std::array<std::size_t, 3>& at,
                                  const PlaneFitOptions& options) {
  const PlaneKind kind = options.kind;
  glm::dvec3 normal = options.normal;
  if (kind != PlaneKind::kKnownNormal) {
    const glm::dvec3 along = points[at[1]] - points[at[0]];
    normal = kind == PlaneKind::kVertical ? glm::dvec3(-along.y, along.x, 0.0)
                                          : glm::cross(along, points[at[2]] - points[at[0]]);
    const double length = glm::length(normal);
    const double scale = kind == PlaneKind::kVertical ? glm::length(along) : glm::dot(along, along);
    if (!(length > 1e-3 * scale)) return std::nullopt;
    normal /= length;
  }
  return Plane{normal, glm::dot(normal, points[at[0]])};
}

std::vector<std::uint32_t> MembersOf(std::span<const glm::dvec3> points,
                                     const Plane& plane,
                                     double tolerance) {
  std::vector<std::uint32_t> members;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::abs(plane.DistanceOf(points[i])) <= tolerance) {
      members.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return members;
}

std::vector<glm::dvec3> Chosen(std::span<const glm::dvec3> points,
                               const std::vector<std::uint32_t>& indices) {
  std::vector<glm::dvec3> chosen;
  chosen.reserve(indices.size());
  for (const std::uint32_t i : indices) chosen.push_back(points[i]);
  return chosen;
}

}  // namespace

std::optional<PlaneFit> FitPlaneToAll(std::span<const glm::dvec3> points,
                                      const PlaneFitOptions& options) {
  const PlaneKind kind = options.kind;
  if (points.size() < 3) return std::nullopt;
  const auto count = static_cast<double>(points.size());
  glm::dvec3 mean(0.0);
  for (const glm::dvec3& p : points) mean += p / count;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const glm::dvec3& p : points) {
    const Eigen::Vector3d d = AsEigen(p - mean);
    covariance += d * d.transpose() / count;
  }
  PlaneFit fit;
  double across = 0.0;
  if (kind == PlaneKind::kKnownNormal) {
    const Eigen::Vector3d normal = AsEigen(options.normal);
    fit.plane.normal = options.normal;
    fit.rms = std::sqrt(std::max(normal.dot(covariance * normal), 0.0));
    if (!(covariance.trace() > 2.0 * fit.rms * fit.rms)) return std::nullopt;
  } else if (kind == PlaneKind::kVertical) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(
        covariance.topLeftCorner<2, 2>().eval());
    const Eigen::Vector2d normal = solver.eigenvectors().col(0);
    fit.plane.normal = {normal.x(), normal.y(), 0.0};
    fit.rms = std::sqrt(std::max(solver.eigenvalues()(0), 0.0));
    across = std::sqrt(std::max(solver.eigenvalues()(1), 0.0));
    if (!(across > kLeastFlatness * std::sqrt(covariance.trace())) || !(across > fit.rms)) {
      return std::nullopt;
    }
  } else {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
    const Eigen::Vector3d normal = solver.eigenvectors().col(0);
    fit.plane.normal = {normal.x(), normal.y(), normal.z()};
    const Eigen::Vector3d spread = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
    fit.rms = spread(0);
    across = spread(1);
    if (!(across > kLeastFlatness * spread(2)) || !(across > fit.rms)) return std::nullopt;
  }
  fit.plane.offset = glm::dot(fit.plane.normal, mean);
  fit.members.resize(points.size());
  std::iota(fit.members.begin(), fit.members.end(), 0U);
  if (across > 0.0) fit.normal_sigma_rad = fit.rms / (across * std::sqrt(count));
  return fit;
}

std::optional<PlaneFit> FitPlane(std::span<const glm::dvec3> points,
                                 const PlaneFitOptions& options) {
  if (!(options.tolerance > 0.0)) {
    throw std::invalid_argument("PlaneFitOptions::tolerance: expected a positive number");
  }
  if (points.size() < std::max<std::size_t>(options.fewest, 3)) return std::nullopt;
  std::mt19937_64 random(options.seed);
  std::vector<glm::dvec3> thinned(points.begin(), points.end());
  if (thinned.size() > kMostScored) {
    for (std::size_t i = 0; i < kMostScored; ++i) {
      std::swap(thinned[i], thinned[i + Draw(random, thinned.size() - i)]);
    }
    thinned.resize(kMostScored);
  }
  std::optional<Plane> best;
  double best_score = 0.0;
  for (int h = 0; h < kHypotheses; ++h) {
    const auto plane = PlaneThrough(thinned, DrawNeighbours(thinned, random), options);
    if (!plane) continue;
    double score = 0.0;
    for (const glm::dvec3& p : thinned) {
      const double off = plane->DistanceOf(p) / options.tolerance;
      score += std::max(0.0, 1.0 - off * off);
    }
    if (score > best_score) {
      best_score = score;
      best = plane;
    }
  }
  if (!best) return std::nullopt;
  std::optional<PlaneFit> fit;
  constexpr int kRounds = 10;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<std::uint32_t> members = MembersOf(points, *best, options.tolerance);
    if (members.size() < options.fewest) return std::nullopt;
    auto next = FitPlaneToAll(Chosen(points, members), options);
    if (!next) return std::nullopt;
    next->members = members;
    const bool is_settled = fit && fit->members == members;
    best = next->plane;
    fit = std::move(next);
    if (is_settled) break;
  }
  return fit;
}

}  // namespace pleinair
