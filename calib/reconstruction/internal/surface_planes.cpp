#include "calib/reconstruction/internal/surface_planes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <utility>

#include "sunmodel/angles.h"

namespace pleinair {
namespace {

constexpr std::size_t kFewestPoints = 8;
// Walls of a building that are nearly along or across each other are so.
constexpr double kNearWallRad = RadFromDeg(3.0);

std::vector<glm::dvec3> PositionsOf(const Reconstruction& world,
                                    std::span<const std::uint32_t> indices) {
  std::vector<glm::dvec3> positions;
  positions.reserve(indices.size());
  for (const std::uint32_t i : indices) positions.push_back(world.points[i].position);
  return positions;
}

// FitPlane among some of the points.
std::optional<PlaneFit> FitAmong(const Reconstruction& world,
                                 const std::vector<std::uint32_t>& candidates,
                                 const PlaneFitOptions& options) {
  auto fit = FitPlane(PositionsOf(world, candidates), options);
  if (fit) {
    for (std::uint32_t& member : fit->members) member = candidates[member];
  }
  return fit;
}

void Remove(const std::vector<std::uint32_t>& taken, std::vector<std::uint32_t>& from) {
  std::vector<std::uint32_t> left;
  std::set_difference(
      from.begin(), from.end(), taken.begin(), taken.end(), std::back_inserter(left));
  from = std::move(left);
}

double LowestCamera(const Reconstruction& world) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const ReconstructedPicture& picture : world.pictures) {
    lowest = std::min(lowest, picture.Centre().z);
  }
  return lowest;
}

glm::dvec3 AlongWall(const glm::dvec3& normal) { return {-normal.y, normal.x, 0.0}; }

// Parts of a wall that are separated by gaps, with the indices ascending.
std::vector<std::vector<std::uint32_t>> PiecesOf(const Reconstruction& world,
                                                 const PlaneFit& fit,
                                                 double tolerance_m) {
  constexpr double kGapOfWidth = 0.25;
  const glm::dvec3 along = AlongWall(fit.plane.normal);
  std::vector<std::pair<double, std::uint32_t>> sorted;
  for (const std::uint32_t member : fit.members) {
    sorted.emplace_back(glm::dot(along, world.points[member].position), member);
  }
  std::sort(sorted.begin(), sorted.end());
  const double gap =
      std::max(20.0 * tolerance_m, kGapOfWidth * (sorted.back().first - sorted.front().first));
  std::vector<std::vector<std::uint32_t>> pieces(1);
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    if (i > 0 && sorted[i].first - sorted[i - 1].first > gap) pieces.emplace_back();
    pieces.back().push_back(sorted[i].second);
  }
  for (auto& piece : pieces) std::sort(piece.begin(), piece.end());
  return pieces;
}

// Walls have as many points at every height; a floor has far more than what is above it.
bool IsFloor(const Reconstruction& world, const PlaneFit& level, double tolerance_m) {
  constexpr double kLeastContrast = 3.0;
  constexpr int kSlabsAbove = 3;
  const double above_m = level.plane.offset + 2.0 * tolerance_m;
  const auto above =
      std::count_if(world.points.begin(), world.points.end(), [&](const ReconstructedPoint& point) {
        const double up_m = point.position.z - above_m;
        return up_m > 0.0 && up_m <= kSlabsAbove * 2.0 * tolerance_m;
      });
  return static_cast<double>(level.members.size()) * kSlabsAbove >
         kLeastContrast * static_cast<double>(above);
}

bool IsInside(const std::vector<glm::dvec2>& polygon, const glm::dvec2& p) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const glm::dvec2& a = polygon[i];
    const glm::dvec2& b = polygon[j];
    if ((a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x) {
      inside = !inside;
    }
  }
  return inside;
}

// Points that pictures show inside the marks, ascending.
std::vector<std::uint32_t> PointsInside(const Reconstruction& world, const MarkedSurface& marked) {
  constexpr double kNearMark = 0.02;  // Share of the picture's width.
  std::set<std::uint32_t> inside;
  for (std::size_t picture = 0; picture < world.pictures.size(); ++picture) {
    std::vector<glm::dvec2> corners;
    for (const SurfaceMark& mark : marked.marks) {
      if (mark.picture == picture) corners.push_back(mark.pixel);
    }
    if (corners.empty()) continue;
    const double near_px =
        kNearMark * world.cameras[world.pictures[picture].camera].intrinsics.width_px;
    for (const PointObservation& seen : VisiblePoints(world, picture)) {
      const bool is_in = corners.size() >= 3
                             ? IsInside(corners, seen.pixel)
                             : std::any_of(corners.begin(), corners.end(), [&](const auto& mark) {
                                 return glm::distance(mark, seen.pixel) <= near_px;
                               });
      if (is_in) inside.insert(seen.point);
    }
  }
  return {inside.begin(), inside.end()};
}

// Gives the plane that direction, or the one across it, where it is near and keeps its points.
void TakeDirection(const Reconstruction& world,
                   double tolerance_m,
                   const glm::dvec3& direction,
                   double near_rad,
                   PlaneFit& wall) {
  constexpr double kKept = 0.85;
  for (const glm::dvec3& normal : {direction, AlongWall(direction)}) {
    const double cosine = glm::dot(normal, wall.plane.normal);
    if (std::abs(cosine) < std::cos(near_rad)) continue;
    PlaneFitOptions options;
    options.kind = PlaneKind::kKnownNormal;
    options.normal = cosine < 0.0 ? -normal : normal;
    options.tolerance = tolerance_m;
    auto turned = FitAmong(world, wall.members, options);
    if (!turned || static_cast<double>(turned->members.size()) <
                       kKept * static_cast<double>(wall.members.size())) {
      continue;
    }
    wall = std::move(*turned);
    return;
  }
}

// The strongest wall's own direction, or that of the pictures' edges where possible. Edges across a
// facade give its direction better than its points, whose small parallax gives large errors of
// depth. A wall that is turned by a degree still fits its pictures within a pixel.
glm::dvec3 FirstDirection(const Reconstruction& world,
                          const SurfaceOptions& options,
                          PlaneFit& wall) {
  constexpr double kNearRad = RadFromDeg(4.0);
  if (options.wall_direction) {
    TakeDirection(world, 2.0 * options.tolerance_m, *options.wall_direction, kNearRad, wall);
  }
  return wall.plane.normal;
}

// The strongest upright plane, preferably along or across `direction`: buildings are built so, and
// what else has a few more points is often mouldings and chance.
std::optional<PlaneFit> StrongestWall(const Reconstruction& world,
                                      const std::vector<std::uint32_t>& candidates,
                                      const std::optional<glm::dvec3>& direction,
                                      PlaneFitOptions options) {
  constexpr double kPreference = 1.5;
  options.kind = PlaneKind::kVertical;
  auto best = FitAmong(world, candidates, options);
  if (!direction) return best;
  double most = best ? static_cast<double>(best->members.size()) / kPreference : 0.0;
  options.kind = PlaneKind::kKnownNormal;
  for (const glm::dvec3& normal : {*direction, AlongWall(*direction)}) {
    options.normal = normal;
    auto fit = FitAmong(world, candidates, options);
    if (!fit || static_cast<double>(fit->members.size()) <= most) continue;
    most = static_cast<double>(fit->members.size());
    best = std::move(fit);
  }
  if (best) TakeDirection(world, 2.0 * options.tolerance, *direction, kNearWallRad, *best);
  return best;
}

// A piece of a wall: means over its points.
struct PieceMean {
  double count = 0.0;
  double along = 0.0;
  double offset = 0.0;  // Along the wall's normal.
};

// The offset that pieces of one wall share; none where their points contradict it.
//
// Points by a camera that walks towards a wall have errors of depth that grow along it: a tilt,
// which moves pieces at its two ends apart. So each piece has its own offset, all have one slope,
// and offsets may differ by what noise and the slope's uncertainty explain.
std::optional<double> SharedOffset(const Reconstruction& world,
                                   const glm::dvec3& normal,
                                   std::span<const std::vector<std::uint32_t>> pieces) {
  constexpr double kMostSigmas = 3.0;
  const glm::dvec3 along = AlongWall(normal);
  std::vector<PieceMean> means;
  PieceMean all;
  double along_squared = 0.0;
  double along_offset = 0.0;
  double offset_squared = 0.0;
  for (const std::vector<std::uint32_t>& piece : pieces) {
    PieceMean mean{static_cast<double>(piece.size())};
    for (const std::uint32_t member : piece) {
      mean.along += glm::dot(along, world.points[member].position) / mean.count;
      mean.offset += glm::dot(normal, world.points[member].position) / mean.count;
    }
    for (const std::uint32_t member : piece) {
      const double x = glm::dot(along, world.points[member].position) - mean.along;
      const double y = glm::dot(normal, world.points[member].position) - mean.offset;
      along_squared += x * x;
      along_offset += x * y;
      offset_squared += y * y;
    }
    all.count += mean.count;
    all.along += mean.count * mean.along;
    all.offset += mean.count * mean.offset;
    means.push_back(mean);
  }
  all.along /= all.count;
  all.offset /= all.count;
  const double freedom = all.count - static_cast<double>(means.size()) - 1.0;
  if (!(freedom > 0.0 && along_squared > 0.0)) return std::nullopt;
  const double slope = along_offset / along_squared;
  const double variance = std::max(offset_squared - slope * along_offset, 0.0) / freedom;
  for (const PieceMean& mean : means) {
    const double lever = mean.along - all.along;
    const double off = mean.offset - all.offset - slope * lever;
    const double off_variance =
        variance * (1.0 / mean.count - 1.0 / all.count + lever * lever / along_squared);
    if (off * off > kMostSigmas * kMostSigmas * off_variance) return std::nullopt;
  }
  return all.offset;
}

std::pair<double, double> RangeAlong(const Reconstruction& world,
                                     const glm::dvec3& along,
                                     const std::vector<std::uint32_t>& members) {
  std::pair<double, double> range(std::numeric_limits<double>::infinity(),
                                  -std::numeric_limits<double>::infinity());
  for (const std::uint32_t member : members) {
    const double at = glm::dot(along, world.points[member].position);
    range = {std::min(range.first, at), std::max(range.second, at)};
  }
  return range;
}

// Columns, frames and cornices before a wall, and doors in it.
bool IsReliefOf(const Reconstruction& world,
                const PlaneFit& wall,
                const PlaneFit& candidate,
                double tolerance_m) {
  constexpr double kDeepest = 6.0;  // In units of the tolerance.
  constexpr double kParallel = 0.995;
  const double cosine = glm::dot(wall.plane.normal, candidate.plane.normal);
  if (std::abs(cosine) < kParallel) return false;
  const glm::dvec3 along = AlongWall(wall.plane.normal);
  const auto own = RangeAlong(world, along, wall.members);
  const auto other = RangeAlong(world, along, candidate.members);
  const double shared = std::min(own.second, other.second) - std::max(own.first, other.first);
  if (shared < 0.5 * (other.second - other.first)) return false;
  double depth = 0.0;
  for (const std::uint32_t member : candidate.members) {
    depth += wall.plane.DistanceOf(world.points[member].position) /
             static_cast<double>(candidate.members.size());
  }
  return std::abs(depth) < kDeepest * tolerance_m;
}

}  // namespace

std::optional<PlaneFit> FindGround(const Reconstruction& world, double tolerance_m) {
  const double below_m = LowestCamera(world);
  std::vector<std::uint32_t> candidates;
  for (std::uint32_t i = 0; i < world.points.size(); ++i) {
    if (world.points[i].position.z < below_m) candidates.push_back(i);
  }
  PlaneFitOptions options;
  options.kind = PlaneKind::kKnownNormal;
  options.tolerance = tolerance_m;
  options.fewest = std::max<std::size_t>(20, world.points.size() / 50);
  std::optional<PlaneFit> ground;
  std::size_t most = 0;
  // Steps and terraces are above the ground.
  constexpr int kLevels = 6;
  for (int level = 0; level < kLevels; ++level) {
    const auto fit = FitAmong(world, candidates, options);
    if (!fit) break;
    most = std::max(most, fit->members.size());
    const bool is_strong = 4 * fit->members.size() >= most && IsFloor(world, *fit, tolerance_m);
    if (is_strong && (!ground || fit->plane.offset < ground->plane.offset)) ground = fit;
    Remove(fit->members, candidates);
  }
  return ground;
}

std::vector<SurfacePlane> FindWalls(const Reconstruction& world,
                                    double ground_m,
                                    const SurfaceOptions& options) {
  std::vector<std::uint32_t> candidates;
  for (std::uint32_t i = 0; i < world.points.size(); ++i) {
    if (world.points[i].position.z > ground_m + 2.0 * options.tolerance_m) candidates.push_back(i);
  }
  PlaneFitOptions fit_options;
  fit_options.tolerance = options.tolerance_m;
  fit_options.fewest = std::max<std::size_t>(20, candidates.size() / 30);
  std::vector<SurfacePlane> walls;
  std::optional<glm::dvec3> direction;
  while (walls.size() < options.most_walls) {
    auto fit = StrongestWall(world, candidates, direction, fit_options);
    if (!fit) break;
    if (!direction) direction = FirstDirection(world, options, *fit);
    std::vector<std::vector<std::uint32_t>> pieces = PiecesOf(world, *fit, options.tolerance_m);
    std::erase_if(pieces, [&](const auto& piece) { return piece.size() < fit_options.fewest; });
    std::optional<double> shared_offset;
    if (pieces.size() > 1) shared_offset = SharedOffset(world, fit->plane.normal, pieces);
    for (const std::vector<std::uint32_t>& piece : pieces) {
      if (walls.size() == options.most_walls) break;
      PlaneFitOptions as_found;
      as_found.kind = PlaneKind::kKnownNormal;
      as_found.normal = fit->plane.normal;
      auto wall = FitPlaneToAll(PositionsOf(world, piece), as_found);
      if (!wall) continue;
      wall->members = piece;
      if (shared_offset) {
        wall->rms = std::hypot(wall->rms, wall->plane.offset - *shared_offset);
        wall->plane.offset = *shared_offset;
      }
      const bool is_relief =
          std::any_of(walls.begin(), walls.end(), [&](const SurfacePlane& known) {
            return IsReliefOf(world, known.fit, *wall, options.tolerance_m);
          });
      if (is_relief) continue;
      walls.push_back({"", std::move(*wall)});
    }
    Remove(fit->members, candidates);
  }
  std::stable_sort(walls.begin(), walls.end(), [](const SurfacePlane& a, const SurfacePlane& b) {
    return a.fit.members.size() > b.fit.members.size();
  });
  return walls;
}

SurfacePlane FitMarked(const Reconstruction& world,
                       const MarkedSurface& marked,
                       double tolerance_m) {
  const std::vector<std::uint32_t> candidates = PointsInside(world, marked);
  PlaneFitOptions options;
  options.tolerance = tolerance_m;
  options.fewest = kFewestPoints;
  std::optional<PlaneFit> best;
  if (marked.name == "ground") {
    options.kind = PlaneKind::kKnownNormal;
    best = FitAmong(world, candidates, options);
  } else {
    best = FitAmong(world, candidates, options);
    // A plane of one more unknown always has a few more members.
    constexpr double kKept = 0.85;
    double most = best ? kKept * static_cast<double>(best->members.size()) : 0.0;
    for (const PlaneKind kind : {PlaneKind::kVertical, PlaneKind::kKnownNormal}) {
      options.kind = kind;
      const auto constrained = FitAmong(world, candidates, options);
      if (constrained && static_cast<double>(constrained->members.size()) > most) {
        most = static_cast<double>(constrained->members.size());
        best = constrained;
      }
    }
  }
  if (!best) {
    throw std::runtime_error("surface " + marked.name + ": expected " +
                             std::to_string(kFewestPoints) +
                             " points of a plane inside its marks, found " +
                             std::to_string(candidates.size()) + " points there");
  }
  return {marked.name, std::move(*best)};
}

void AlignDirections(const Reconstruction& world,
                     const SurfaceOptions& options,
                     std::span<SurfacePlane> walls) {
  std::optional<glm::dvec3> first;
  for (SurfacePlane& wall : walls) {
    if (wall.fit.plane.normal.z != 0.0) continue;
    if (first) {
      TakeDirection(world, 2.0 * options.tolerance_m, *first, kNearWallRad, wall.fit);
    } else {
      first = FirstDirection(world, options, wall.fit);
    }
  }
}

}  // namespace pleinair
