#include "pipeline/shadow_edge_marks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "calib/lens.h"
#include "sunmodel/north.h"

namespace pleinair {
namespace {

constexpr double kStep = kShadowEdgeStepRad;

// Directions of the mesh's outline as a mark sees it, near the sun.
std::vector<glm::dvec3> OutlineNearSun(const RayCaster& mesh, const ShadowEdgeMark& mark) {
  const auto in_camera = DirectionFromPixel(mark.camera.intrinsics, mark.pixel);
  if (!in_camera) return {};
  const glm::dmat4 world_from_camera = glm::inverse(mark.camera.camera_from_world);
  const glm::vec3 ray(glm::normalize(glm::dmat3(world_from_camera) * *in_camera));
  const auto hit = mesh.Intersect(glm::vec3(world_from_camera[3]), ray);
  if (!hit) return {};
  const glm::vec3 normal =
      glm::dot(hit->geometric_normal, ray) > 0.0f ? -hit->geometric_normal : hit->geometric_normal;
  const glm::vec3 origin = OffsetFromSurface(hit->position_m, normal);

  const glm::dvec3& sun = mark.sun_direction_enu;
  const glm::dvec3 right = glm::normalize(glm::cross(
      std::abs(sun.z) < 0.9 ? glm::dvec3(0.0, 0.0, 1.0) : glm::dvec3(1.0, 0.0, 0.0), sun));
  const glm::dvec3 up = glm::cross(sun, right);
  const int half = static_cast<int>(kShadowEdgeReachRad / kStep);
  const int side = 2 * half + 1;
  const auto direction = [&](double column, double row) {
    return glm::normalize(sun + std::tan((column - half) * kStep) * right +
                          std::tan((row - half) * kStep) * up);
  };
  std::vector<bool> covered(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  const auto at = [&](int column, int row) {
    return covered[static_cast<std::size_t>(row) * static_cast<std::size_t>(side) +
                   static_cast<std::size_t>(column)];
  };
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      at(column, row) = mesh.Occluded(origin, glm::vec3(direction(column, row)));
    }
  }
  std::vector<glm::dvec3> outline;
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      if (column + 1 < side && at(column, row) != at(column + 1, row)) {
        outline.push_back(direction(column + 0.5, row));
      }
      if (row + 1 < side && at(column, row) != at(column, row + 1)) {
        outline.push_back(direction(column, row + 0.5));
      }
    }
  }
  return outline;
}

double SmallestAngleRad(const std::vector<glm::dvec3>& outline, const glm::dvec3& sun) {
  double closest = std::numeric_limits<double>::infinity();
  for (const glm::dvec3& direction : outline)
    closest = std::min(closest, glm::distance(direction, sun));
  return 2.0 * std::asin(std::min(1.0, 0.5 * closest));
}

// Squared angles of each mark with an outline, for turns of -reach to reach in kStep.
class TurnTable {
 public:
  void Add(const std::vector<glm::dvec3>& outline, const glm::dvec3& sun) {
    std::vector<double>& squares = squares_.emplace_back();
    for (int k = -kTurns; k <= kTurns; ++k) {
      const double angle = SmallestAngleRad(outline, TurnedClockwise(sun, k * kStep));
      squares.push_back(angle * angle);
    }
  }
  std::size_t Size() const { return squares_.size(); }

  // The best turn's index over all marks but `left_out`.
  std::size_t Best(std::size_t left_out) const {
    std::vector<double> sums(2 * kTurns + 1, 0.0);
    for (std::size_t mark = 0; mark < squares_.size(); ++mark) {
      if (mark == left_out) continue;
      for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += squares_[mark][k];
    }
    return static_cast<std::size_t>(std::min_element(sums.begin(), sums.end()) - sums.begin());
  }
  double RmsRad(std::size_t turn) const {
    double sum = 0.0;
    for (const std::vector<double>& squares : squares_) sum += squares[turn];
    return std::sqrt(sum / static_cast<double>(squares_.size()));
  }
  static double TurnRad(std::size_t turn) { return (static_cast<double>(turn) - kTurns) * kStep; }

 private:
  // Half of what is seen around the sun, so that a turned sun still sees what is on both sides.
  static constexpr int kTurns = static_cast<int>(0.5 * kShadowEdgeReachRad / kStep);
  std::vector<std::vector<double>> squares_;
};

}  // namespace

ShadowEdgeFit FitShadowEdges(const RayCaster& mesh, std::span<const ShadowEdgeMark> marks) {
  ShadowEdgeFit fit;
  TurnTable turns;
  double sum = 0.0;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const glm::dvec3& sun = marks[i].sun_direction_enu;
    if (!(sun.z > 0.0)) {
      throw std::invalid_argument("shadow mark " + std::to_string(i) +
                                  ": the sun is not above the horizon: expected a sunlit picture");
    }
    const std::vector<glm::dvec3> outline = OutlineNearSun(mesh, marks[i]);
    fit.angle_rad.emplace_back();
    if (outline.empty()) continue;
    const double angle = SmallestAngleRad(outline, sun);
    fit.angle_rad.back() = angle;
    fit.largest_rad = std::max(fit.largest_rad, angle);
    sum += angle * angle;
    turns.Add(outline, sun);
  }
  fit.used = turns.Size();
  if (fit.used == 0) return fit;
  const auto count = static_cast<double>(fit.used);
  fit.rms_rad = std::sqrt(sum / count);
  if (fit.used < 3) return fit;

  const std::size_t best = turns.Best(fit.used);
  fit.azimuth_offset_rad = TurnTable::TurnRad(best);
  fit.rms_after_rad = turns.RmsRad(best);
  double squares = 0.0;
  for (std::size_t left_out = 0; left_out < fit.used; ++left_out) {
    const double change = TurnTable::TurnRad(turns.Best(left_out)) - *fit.azimuth_offset_rad;
    squares += change * change;
  }
  // The jackknife's, not below the raster's step.
  fit.azimuth_stddev_rad = std::max(kStep, std::sqrt(squares * (count - 1.0) / count));
  return fit;
}

}  // namespace pleinair
