#include "relight/daylight/windows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "relight/daylight/internal/wall_openings.h"
#include "scene/sphere_directions.h"

namespace pleinair {
namespace {

using internal::WallPlane;
using internal::WallRaster;

// Least share of the rays to the sky that counts: less is rounding of cells or gaps in meshes.
constexpr double kLeastSharePast = 0.02;
// See the header.
constexpr double kMeasuredByHandM = 0.05;
constexpr double kLeastFramedShare = 0.5;
// Less than this could be a gap between badly joined walls.
constexpr std::size_t kLeastRays = 3;
// The planes that most rays hit; a room has some ten, its furniture the rest.
constexpr std::size_t kMostPlanes = 64;
constexpr double kSamePlaneCosine = 0.99996;  // Half a degree.
constexpr double kOnePlaneM = 0.005;

void RequireFinite(std::span<const glm::dvec3> points_m) {
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      if (!std::isfinite(points_m[i][axis])) {
        throw std::invalid_argument(std::string("windows: point ") + std::to_string(i) + " is " +
                                    std::to_string(points_m[i][axis]) + " along axis " +
                                    std::to_string(axis) + ": expected a finite coordinate");
      }
    }
  }
}

// Twice the area, along the normal (Newell).
glm::dvec3 AreaVector(const std::vector<glm::dvec3>& polygon_m) {
  glm::dvec3 sum(0.0);
  for (std::size_t i = 0; i < polygon_m.size(); ++i) {
    sum += glm::cross(polygon_m[i] - polygon_m[0],
                      polygon_m[(i + 1) % polygon_m.size()] - polygon_m[0]);
  }
  return sum;
}

double SizeOf(const std::vector<glm::dvec3>& polygon_m) {
  double size_m = 0.0;
  for (const glm::dvec3& corner : polygon_m) {
    size_m = std::max(size_m, glm::distance(corner, polygon_m[0]));
  }
  return size_m;
}

struct FlatPolygon {
  WallPlane plane;
  std::vector<glm::dvec2> corners;
};

FlatPolygon Flatten(const Window& window) {
  FlatPolygon flat;
  flat.plane =
      WallPlane::Through(glm::normalize(AreaVector(window.polygon_m)), window.polygon_m[0]);
  for (const glm::dvec3& corner : window.polygon_m) {
    flat.corners.push_back(flat.plane.Project(corner));
  }
  return flat;
}

// Inside by the even-odd rule, or no farther outside than `margin_m`.
bool HoldsPoint(const std::vector<glm::dvec2>& polygon, const glm::dvec2& point, double margin_m) {
  bool inside = false;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec2& a = polygon[i];
    const glm::dvec2& b = polygon[(i + 1) % polygon.size()];
    if ((a.y > point.y) != (b.y > point.y) &&
        point.x < a.x + (b.x - a.x) * (point.y - a.y) / (b.y - a.y)) {
      inside = !inside;
    }
    const glm::dvec2 side = b - a;
    const double length2 = glm::dot(side, side);
    const double along =
        length2 > 0.0 ? glm::clamp(glm::dot(point - a, side) / length2, 0.0, 1.0) : 0.0;
    nearest_m = std::min(nearest_m, glm::distance(point, a + along * side));
  }
  return inside || nearest_m <= margin_m;
}

bool Passes(const FlatPolygon& window, const glm::dvec3& from_m, const glm::dvec3& direction) {
  const double slope = glm::dot(window.plane.normal, direction);
  if (slope == 0.0) return false;
  const double along = (window.plane.offset_m - glm::dot(window.plane.normal, from_m)) / slope;
  if (!(along > 0.0)) return false;
  return HoldsPoint(
      window.corners, window.plane.Project(from_m + along * direction), kMeasuredByHandM);
}

struct SkyRay {
  glm::dvec3 origin_m;
  glm::dvec3 direction;
};

struct PlaneHits {
  WallPlane plane;
  std::size_t count = 0;
  glm::dvec2 lower_m{std::numeric_limits<double>::infinity()};
  glm::dvec2 upper_m{-std::numeric_limits<double>::infinity()};
};

struct SeenFromInside {
  std::vector<SkyRay> sky_rays;
  std::vector<PlaneHits> planes;  // Those with most hits first.
};

SeenFromInside LookAround(const Mesh& mesh,
                          std::span<const glm::dvec3> inside_points_m,
                          int rays_per_point) {
  const RayCaster caster(mesh);
  SeenFromInside seen;
  // Per triangle and side of it the plane in `seen.planes`.
  constexpr std::uint32_t kNone = 0xffffffffu;
  std::vector<std::uint32_t> plane_of(2 * mesh.triangles.size(), kNone);
  const std::vector<glm::vec3> directions = internal::SphereDirections(rays_per_point, 1);
  for (const glm::dvec3& point_m : inside_points_m) {
    for (const glm::vec3& direction : directions) {
      const auto hit = caster.Intersect(glm::vec3(point_m), direction);
      if (!hit) {
        if (direction.z > 0.0f) seen.sky_rays.push_back({point_m, glm::dvec3(direction)});
        continue;
      }
      const bool back = glm::dot(hit->geometric_normal, direction) > 0.0f;
      std::uint32_t& index = plane_of[2 * std::size_t{hit->triangle} + (back ? 1 : 0)];
      if (index == kNone) {
        const glm::dvec3 normal = (back ? -1.0 : 1.0) * glm::dvec3(hit->geometric_normal);
        const glm::dvec3 position_m(hit->position_m);
        const auto known =
            std::find_if(seen.planes.begin(), seen.planes.end(), [&](const PlaneHits& candidate) {
              const WallPlane& plane = candidate.plane;
              return glm::dot(plane.normal, normal) > kSamePlaneCosine &&
                     std::abs(glm::dot(plane.normal, position_m) - plane.offset_m) < kOnePlaneM;
            });
        index = static_cast<std::uint32_t>(known - seen.planes.begin());
        if (known == seen.planes.end()) {
          seen.planes.push_back({WallPlane::Through(normal, position_m)});
        }
      }
      PlaneHits& plane = seen.planes[index];
      const glm::dvec2 at = plane.plane.Project(glm::dvec3(hit->position_m));
      ++plane.count;
      plane.lower_m = glm::min(plane.lower_m, at);
      plane.upper_m = glm::max(plane.upper_m, at);
    }
  }
  std::stable_sort(seen.planes.begin(), seen.planes.end(), [](const auto& a, const auto& b) {
    return a.count > b.count;
  });
  if (seen.planes.size() > kMostPlanes) seen.planes.resize(kMostPlanes);
  return seen;
}

struct Candidate {
  std::vector<glm::dvec3> outline_m;
  double area_m2 = 0.0;
  std::vector<std::size_t> rays;  // Into SeenFromInside::sky_rays.
};

// Openings of one plane that sky rays pass.
void AddCandidates(const Mesh& mesh,
                   const PlaneHits& hits,
                   const std::vector<SkyRay>& sky_rays,
                   double cell_m,
                   std::vector<Candidate>& candidates) {
  // What the rays hit, and as much again to each side, where there is any mesh: an opening may
  // reach beyond what is seen of its wall.
  const glm::dvec2 extent_m = hits.upper_m - hits.lower_m;
  glm::dvec2 mesh_lower_m(std::numeric_limits<double>::infinity());
  glm::dvec2 mesh_upper_m = -mesh_lower_m;
  for (const glm::vec3& position_m : mesh.positions_m) {
    const glm::dvec2 at_m = hits.plane.Project(glm::dvec3(position_m));
    mesh_lower_m = glm::min(mesh_lower_m, at_m);
    mesh_upper_m = glm::max(mesh_upper_m, at_m);
  }
  const glm::dvec2 lower_m = glm::max(hits.lower_m - extent_m, mesh_lower_m);
  const glm::dvec2 upper_m = glm::min(hits.upper_m + extent_m, mesh_upper_m);
  struct Crossing {
    std::size_t ray;
    glm::dvec2 at_m;
  };
  std::vector<Crossing> crossings;
  for (std::size_t i = 0; i < sky_rays.size(); ++i) {
    const double height_m = glm::dot(hits.plane.normal, sky_rays[i].origin_m) - hits.plane.offset_m;
    const double slope = glm::dot(hits.plane.normal, sky_rays[i].direction);
    if (!(height_m > kOnePlaneM) || !(slope < 0.0)) continue;
    const glm::dvec2 at_m =
        hits.plane.Project(sky_rays[i].origin_m - (height_m / slope) * sky_rays[i].direction);
    if (glm::all(glm::greaterThan(at_m, lower_m)) && glm::all(glm::lessThan(at_m, upper_m))) {
      crossings.push_back({i, at_m});
    }
  }
  if (crossings.size() < kLeastRays) return;
  WallRaster raster(mesh, hits.plane, lower_m, upper_m, cell_m);
  std::vector<std::vector<std::size_t>> rays_of;
  for (const Crossing& crossing : crossings) {
    const auto opening = raster.OpeningAt(crossing.at_m);
    if (!opening) continue;
    rays_of.resize(std::max(rays_of.size(), static_cast<std::size_t>(*opening) + 1));
    rays_of[static_cast<std::size_t>(*opening)].push_back(crossing.ray);
  }
  for (std::size_t opening = 0; opening < rays_of.size(); ++opening) {
    const int number = static_cast<int>(opening);
    if (rays_of[opening].size() < kLeastRays || raster.FramedShare(number) < kLeastFramedShare) {
      continue;
    }
    candidates.push_back(
        {raster.Outline(number), raster.AreaM2(number), std::move(rays_of[opening])});
  }
}

}  // namespace

void Window::Validate() const {
  const std::string what = std::string("window \"") + name + "\"";
  if (polygon_m.size() < 3) {
    throw std::invalid_argument(what + " has " + std::to_string(polygon_m.size()) +
                                " corners: expected 3 or more");
  }
  RequireFinite(polygon_m);
  const double size_m = SizeOf(polygon_m);
  const glm::dvec3 area = AreaVector(polygon_m);
  // Thinner than a millionth of its length: rounding.
  if (!(glm::length(area) > 1e-6 * size_m * size_m)) {
    throw std::invalid_argument(what + " has no area");
  }
  const glm::dvec3 normal = glm::normalize(area);
  for (std::size_t i = 0; i < polygon_m.size(); ++i) {
    const double off_m = std::abs(glm::dot(normal, polygon_m[i] - polygon_m[0]));
    if (off_m > 0.01 * size_m) {
      throw std::invalid_argument(what + ": corner " + std::to_string(i) + " lies " +
                                  std::to_string(off_m) +
                                  " m off the others' plane: expected a flat polygon");
    }
  }
}

void WindowSearchOptions::Validate() const {
  if (rays_per_point < 1 || rays_per_point > (1 << 22)) {
    throw std::invalid_argument("rays_per_point is " + std::to_string(rays_per_point) +
                                ": expected 1 to 4194304");
  }
  if (!(cell_m > 0.0) || !std::isfinite(cell_m)) {
    throw std::invalid_argument("cell_m is " + std::to_string(cell_m) + ": expected more than 0 m");
  }
}

bool FoundWindows::Open() const {
  return static_cast<double>(sky_rays_past_windows) >
         kLeastSharePast * static_cast<double>(sky_rays);
}

std::string FoundWindows::Summary() const {
  if (Closed()) return "no sky is seen from inside: no window";
  const auto percent = std::lround(100.0 * static_cast<double>(sky_rays_past_windows) /
                                   static_cast<double>(sky_rays));
  const std::string count =
      windows.size() == 1 ? "1 window" : std::to_string(windows.size()) + " windows";
  if (Open()) {
    return count + " found, and " + std::to_string(percent) +
           " % of the sky seen comes through none: open to the sky";
  }
  return count + " found";
}

FoundWindows FindWindows(const Mesh& mesh,
                         std::span<const glm::dvec3> inside_points_m,
                         const WindowSearchOptions& options) {
  options.Validate();
  RequireFinite(inside_points_m);
  const SeenFromInside seen = LookAround(mesh, inside_points_m, options.rays_per_point);
  FoundWindows found;
  found.sky_rays = seen.sky_rays.size();
  std::vector<Candidate> candidates;
  for (const PlaneHits& plane : seen.planes) {
    AddCandidates(mesh, plane, seen.sky_rays, options.cell_m, candidates);
  }
  std::vector<bool> explained(seen.sky_rays.size(), false);
  const auto unexplained = [&](const Candidate& candidate) {
    return static_cast<std::size_t>(
        std::count_if(candidate.rays.begin(), candidate.rays.end(), [&](std::size_t ray) {
          return !explained[ray];
        }));
  };
  while (true) {
    const Candidate* best = nullptr;
    double best_density = 0.0;
    for (const Candidate& candidate : candidates) {
      const std::size_t rays = unexplained(candidate);
      const double density = static_cast<double>(rays) / candidate.area_m2;
      if (rays >= kLeastRays && density > best_density) {
        best = &candidate;
        best_density = density;
      }
    }
    if (best == nullptr) break;
    for (const std::size_t ray : best->rays) explained[ray] = true;
    found.windows.push_back(
        {std::string("window ") + std::to_string(found.windows.size() + 1), best->outline_m});
  }
  found.sky_rays_past_windows =
      static_cast<std::size_t>(std::count(explained.begin(), explained.end(), false));
  return found;
}

bool SeesSkyPastWindows(const RayCaster& caster,
                        std::span<const Window> windows,
                        std::span<const glm::dvec3> points_m) {
  RequireFinite(points_m);
  std::vector<FlatPolygon> flat;
  for (const Window& window : windows) {
    window.Validate();
    flat.push_back(Flatten(window));
  }
  // Some tens reach the sky through a window of a twentieth of the hemisphere.
  const std::vector<glm::vec3> directions = internal::SphereDirections(1024, 1);
  std::size_t sky = 0;
  std::size_t past = 0;
  for (const glm::dvec3& point_m : points_m) {
    for (const glm::vec3& direction : directions) {
      if (!(direction.z > 0.0f) || caster.Occluded(glm::vec3(point_m), direction)) continue;
      ++sky;
      const bool passes = std::any_of(flat.begin(), flat.end(), [&](const FlatPolygon& window) {
        return Passes(window, point_m, glm::dvec3(direction));
      });
      if (!passes) ++past;
    }
  }
  return static_cast<double>(past) > kLeastSharePast * static_cast<double>(sky);
}

}  // namespace pleinair
