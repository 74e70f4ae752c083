// Planes through points with outliers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace pleinair {

// dot(normal, p) = offset.
struct Plane {
  glm::dvec3 normal{0.0, 0.0, 1.0};  // Unit.
  double offset = 0.0;

  double DistanceOf(const glm::dvec3& p) const { return glm::dot(normal, p) - offset; }
};

// What is known of the plane.
enum class PlaneKind {
  kFree,
  kVertical,     // Its normal is horizontal: a wall.
  kKnownNormal,  // Only its offset is found.
};

// A plane and its members, in the points' unit.
struct PlaneFit {
  Plane plane;
  std::vector<std::uint32_t> members;  // Points within the tolerance of it, ascending.
  double rms = 0.0;                    // Rms of their distances.
  double normal_sigma_rad = 0.0;       // From the members' spread; the worst axis.
};

// Set-up of the search.
struct PlaneFitOptions {
  PlaneKind kind = PlaneKind::kFree;
  glm::dvec3 normal{0.0, 0.0, 1.0};  // For kKnownNormal; unit.
  double tolerance = 0.1;  // Points farther away are outliers; above 0, in the points' unit.
  std::size_t fewest = 8;  // Least number of members.
  std::uint64_t seed = 1;
};

// Returns the plane with most members, by least squares over these; none where no plane has enough
// members, or they lie on a line.
//
// Source   MSAC: Torr and Zisserman, CVIU 78(1), 2000, with hypotheses from neighbouring points.
// Cost     up to 20000 of the points are tried against 600 hypotheses.
// Throws   std::invalid_argument for a tolerance that is not positive.
std::optional<PlaneFit> FitPlane(std::span<const glm::dvec3> points,
                                 const PlaneFitOptions& options);

// Least squares over all the points, of the options' kind; none where they do not span a plane.
std::optional<PlaneFit> FitPlaneToAll(std::span<const glm::dvec3> points,
                                      const PlaneFitOptions& options);

}  // namespace pleinair
