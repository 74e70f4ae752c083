#include "relight/transport/internal/region_irradiance.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "scene/low_discrepancy.h"

namespace pleinair::internal {
namespace {

// Neighbours whose normals have at least this cosine share what they have found.
constexpr float kSameFacing = 0.99f;
// A window of a sixteenth of a region is seen by so many rays for sure.
constexpr std::size_t kFirstRaysPerRegion = 256;
// A face casts one of a cell's rays; whether it casts the others depends on what it and the other
// faces saw.
constexpr std::size_t kRaysPerCell = 16;
// Groups between two progress reports.
constexpr std::size_t kGroupsPerReport = 64;

enum class Ray : std::uint8_t { kHidden, kSeen, kBelowFace };

struct Seen {
  bool some_seen = false;
  bool some_hidden = false;

  void Add(Ray ray) {
    some_seen |= ray == Ray::kSeen;
    some_hidden |= ray == Ray::kHidden;
  }
  void Add(const Seen& other) {
    some_seen |= other.some_seen;
    some_hidden |= other.some_hidden;
  }
};

// The same directions for all faces, cell by cell: an upright grid over each region.
class Directions {
 public:
  Directions(const SkyRegions& regions, std::size_t per_region, std::uint64_t seed)
      : per_region_(per_region),
        side_(std::max(1,
                       static_cast<int>(std::sqrt(static_cast<double>(per_region) /
                                                  static_cast<double>(kRaysPerCell))))) {
    struct Point {
      std::size_t cell;
      std::size_t index;
      glm::dvec2 place;
    };
    std::vector<Point> points(per_region);
    for (std::size_t region = 0; region < regions.Count(); ++region) {
      const glm::dvec2 turn = RotationOf(seed, region);
      for (std::size_t i = 0; i < per_region; ++i) {
        const std::size_t index = region * per_region + i;
        const glm::dvec2 place(
            Fraction((static_cast<double>(i) + 0.5) / static_cast<double>(per_region) + turn.x),
            Fraction(static_cast<double>(index) * kLattice[0] + turn.y));
        points[i] = {CellOf(place), index, place};
      }
      std::stable_sort(points.begin(), points.end(), [](const Point& a, const Point& b) {
        return a.cell < b.cell;
      });
      for (std::size_t cell = 0; cell < CellCount(); ++cell) {
        const auto first = std::lower_bound(
            points.begin(), points.end(), cell, [](const Point& point, std::size_t value) {
              return point.cell < value;
            });
        cell_begin_.push_back(region * per_region +
                              static_cast<std::size_t>(first - points.begin()));
      }
      for (const Point& point : points) {
        direction_.emplace_back(regions.DirectionIn(region, point.place));
        index_.push_back(static_cast<std::uint32_t>(point.index));
      }
    }
    cell_begin_.push_back(direction_.size());
  }

  int Side() const { return side_; }
  std::size_t CellCount() const {
    return static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_);
  }
  std::size_t PerRegion() const { return per_region_; }
  // The rays [Begin(region, cell), Begin(region, cell + 1)), also across to the next region.
  std::size_t Begin(std::size_t region, std::size_t cell) const {
    return cell_begin_[region * CellCount() + cell];
  }
  const glm::vec3& operator[](std::size_t ray) const { return direction_[ray]; }
  // Index in the lattice, which the places of the rays' starts follow too.
  std::size_t IndexOf(std::size_t ray) const { return index_[ray]; }

 private:
  std::size_t CellOf(const glm::dvec2& place) const {
    const auto step = [this](double value) {
      return static_cast<std::size_t>(std::min(side_ - 1, static_cast<int>(value * side_)));
    };
    return step(place.y) * static_cast<std::size_t>(side_) + step(place.x);
  }

  std::size_t per_region_;
  int side_;
  std::vector<std::size_t> cell_begin_;
  std::vector<glm::vec3> direction_;
  std::vector<std::uint32_t> index_;
};

class Gather {
 public:
  Gather(const PatchScene& scene,
         const FacePoints& points,
         const SkyRegions& regions,
         const Directions& directions)
      : scene_(scene), points_(points), regions_(regions), directions_(directions) {}

  // Calls set(face, region, sum of cosines of the rays that see the sky) for the faces of a group
  // within [first, last). What a face gets depends on those of its group that face the same way.
  template <class Set>
  void Group(std::size_t group, std::size_t first, std::size_t last, const Set& set) const {
    for (const std::vector<std::size_t>& faces : SameFacing(group)) {
      const std::vector<Seen> seen = FirstRays(faces);
      for (std::size_t region = 0; region < regions_.Count(); ++region) {
        const Seen around = seen.empty() ? Seen{true, true} : SeenAround(region, seen);
        if (!around.some_seen) continue;
        std::vector<Seen> cells;
        if (around.some_hidden) cells = CellsSeen(faces, region);
        for (const std::size_t face : faces) {
          if (face < first || face >= last) continue;
          set(face,
              region,
              around.some_hidden ? InPart(face, region, cells) : InWhole(face, region));
        }
      }
    }
  }

 private:
  // The group's exposed faces, by facing: light that comes in through one window meets those of a
  // wall's inner side, and none of its outer side.
  std::vector<std::vector<std::size_t>> SameFacing(std::size_t group) const {
    std::vector<std::vector<std::size_t>> facings;
    const std::size_t end = std::min(scene_.FaceCount(), (group + 1) * kFacesPerGroup);
    for (std::size_t face = group * kFacesPerGroup; face < end; ++face) {
      const glm::vec3 normal = scene_.FaceNormal(face);
      if (points_.Of(face).empty() || normal == glm::vec3(0.0f)) continue;
      const auto same = std::find_if(facings.begin(), facings.end(), [&](const auto& faces) {
        return glm::dot(scene_.FaceNormal(faces.front()), normal) > kSameFacing;
      });
      if (same == facings.end()) {
        facings.push_back({face});
      } else {
        same->push_back(face);
      }
    }
    return facings;
  }

  // A ray's start: all over the face where all of it is exposed, else at its points. With the
  // direction it is a lattice in four dimensions, so that no part of a region is seen from one part
  // of the face alone.
  glm::vec3 Start(std::size_t face,
                  const glm::vec3& normal,
                  const glm::dvec2& turn,
                  std::size_t ray) const {
    const auto index = static_cast<double>(directions_.IndexOf(ray));
    const glm::dvec2 place(Fraction(index * kLattice[1] + turn.x),
                           Fraction(index * kLattice[2] + turn.y));
    const std::span<const glm::vec3> of_face = points_.Of(face);
    if (points_.whole[face] == 0) {
      return of_face[static_cast<std::size_t>(place.x * static_cast<double>(of_face.size()))];
    }
    const glm::uvec3& v = scene_.mesh.triangles[face / 2];
    return OffsetFromSurface(TrianglePoint(scene_.mesh.positions_m[v[0]],
                                           scene_.mesh.positions_m[v[1]],
                                           scene_.mesh.positions_m[v[2]],
                                           place),
                             normal);
  }

  Ray Cast(std::size_t face,
           const glm::vec3& normal,
           const glm::dvec2& turn,
           std::size_t ray) const {
    if (!(glm::dot(normal, directions_[ray]) > 0.0f)) return Ray::kBelowFace;
    return scene_.caster.Occluded(Start(face, normal, turn, ray), directions_[ray]) ? Ray::kHidden
                                                                                    : Ray::kSeen;
  }

  // A few of the faces' rays to each region; nothing where all regions are looked at anyway.
  std::vector<Seen> FirstRays(const std::vector<std::size_t>& faces) const {
    if (regions_.Count() < kLeastRegionsToSkip) return {};
    std::vector<Seen> seen(regions_.Count());
    const std::size_t per_region = directions_.PerRegion();
    const std::size_t stride =
        std::max(std::size_t{1}, per_region * faces.size() / kFirstRaysPerRegion);
    for (std::size_t i = 0; i < faces.size(); ++i) {
      const glm::vec3 normal = scene_.FaceNormal(faces[i]);
      const glm::dvec2 turn = RotationOf(0, faces[i]);
      // Faces begin at different places of the region, evenly.
      const std::size_t begin = i * stride / faces.size();
      for (std::size_t region = 0; region < regions_.Count(); ++region) {
        for (std::size_t ray = begin; ray < per_region; ray += stride) {
          seen[region].Add(Cast(faces[i], normal, turn, region * per_region + ray));
        }
      }
    }
    return seen;
  }

  // What is seen of a region and those that touch it.
  Seen SeenAround(std::size_t region, const std::vector<Seen>& seen) const {
    Seen around;
    regions_.ForNeighbours(region, [&](std::size_t neighbour) { around.Add(seen[neighbour]); });
    return around;
  }

  double InWhole(std::size_t face, std::size_t region) const {
    const glm::vec3 normal = scene_.FaceNormal(face);
    const std::size_t first = region * directions_.PerRegion();
    double sum = 0.0;
    for (std::size_t ray = first; ray < first + directions_.PerRegion(); ++ray) {
      sum += std::max(0.0f, glm::dot(normal, directions_[ray]));
    }
    return sum;
  }

  // What the faces see of each cell of the region and of those around it, each by one ray a cell.
  std::vector<Seen> CellsSeen(const std::vector<std::size_t>& faces, std::size_t region) const {
    std::vector<Seen> seen(directions_.CellCount());
    for (std::size_t i = 0; i < faces.size(); ++i) {
      const glm::vec3 normal = scene_.FaceNormal(faces[i]);
      const glm::dvec2 turn = RotationOf(0, faces[i]);
      for (std::size_t cell = 0; cell < seen.size(); ++cell) {
        const std::size_t begin = directions_.Begin(region, cell);
        const std::size_t count = directions_.Begin(region, cell + 1) - begin;
        if (count == 0) continue;
        for (std::size_t ray = i % count; ray < count; ray += faces.size()) {
          seen[cell].Add(Cast(faces[i], normal, turn, begin + ray));
        }
      }
    }
    const int side = directions_.Side();
    std::vector<Seen> around(seen.size());
    for (int row = 0; row < side; ++row) {
      for (int column = 0; column < side; ++column) {
        Seen& sum = around[static_cast<std::size_t>(row * side + column)];
        for (int r = std::max(0, row - 1); r <= std::min(side - 1, row + 1); ++r) {
          for (int c = std::max(0, column - 1); c <= std::min(side - 1, column + 1); ++c) {
            sum.Add(seen[static_cast<std::size_t>(r * side + c)]);
          }
        }
      }
    }
    return around;
  }

  double InPart(std::size_t face, std::size_t region, const std::vector<Seen>& around) const {
    const glm::vec3 normal = scene_.FaceNormal(face);
    const glm::dvec2 turn = RotationOf(0, face);
    double sum = 0.0;
    for (std::size_t cell = 0; cell < around.size(); ++cell) {
      if (!around[cell].some_seen) continue;
      for (std::size_t ray = directions_.Begin(region, cell);
           ray < directions_.Begin(region, cell + 1);
           ++ray) {
        const float cosine = glm::dot(normal, directions_[ray]);
        if (!(cosine > 0.0f)) continue;
        if (!around[cell].some_hidden || Cast(face, normal, turn, ray) == Ray::kSeen) sum += cosine;
      }
    }
    return sum;
  }

  const PatchScene& scene_;
  const FacePoints& points_;
  const SkyRegions& regions_;
  const Directions& directions_;
};

}  // namespace

std::vector<float> RegionIrradiance(const PatchScene& scene,
                                    const FacePoints& points,
                                    const RegionRays& rays,
                                    const FaceRange& faces,
                                    const Progress& progress) {
  const SkyRegions& regions = rays.regions;
  const auto [first, last] = faces;
  if (points.FaceCount() != scene.FaceCount() || first > last || last > scene.FaceCount()) {
    throw std::invalid_argument("region irradiance: faces " + std::to_string(first) + " to " +
                                std::to_string(last) + " and points of " +
                                std::to_string(points.FaceCount()) + ": the scene has " +
                                std::to_string(scene.FaceCount()) + " faces");
  }
  if (rays.per_face < 1) {
    throw std::invalid_argument("region irradiance: " + std::to_string(rays.per_face) +
                                " rays a face: expected 1 at least");
  }
  std::vector<float> irradiance((last - first) * regions.Count(), 0.0f);
  if (first == last) return irradiance;
  const std::size_t per_region =
      std::max(std::size_t{1}, static_cast<std::size_t>(rays.per_face) / regions.Count());
  const Directions directions(regions, per_region, rays.seed);
  const Gather gather(scene, points, regions, directions);
  const double ray_sr = regions.SolidAngleSr() / static_cast<double>(per_region);
  const std::size_t first_group = first / kFacesPerGroup;
  const std::size_t groups = (last - 1) / kFacesPerGroup + 1;
  for (std::size_t done = first_group; done < groups; done += kGroupsPerReport) {
    if (progress) {
      progress("sky over patches",
               static_cast<double>(done - first_group) / static_cast<double>(groups - first_group));
    }
    tbb::parallel_for(done, std::min(groups, done + kGroupsPerReport), [&](std::size_t group) {
      const auto put = [&](std::size_t face, std::size_t region, double sum) {
        irradiance[(face - faces.first) * regions.Count() + region] =
            static_cast<float>(ray_sr * sum);
      };
      gather.Group(group, faces.first, faces.last, put);
    });
  }
  if (progress) progress("sky over patches", 1.0);
  return irradiance;
}

}  // namespace pleinair::internal
