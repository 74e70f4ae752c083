#include "relight/transport/sky_visibility.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "relight/transport/internal/region_irradiance.h"
#include "scene/low_discrepancy.h"

namespace pleinair {
namespace {

using internal::kFacesPerGroup;
using internal::kLattice;
using internal::kLeastRegionsToSkip;

constexpr std::size_t kWordBits = 64;
// A window of a sixteenth of a region is seen by the group's 16 x 16 rays for sure.
constexpr std::size_t kFirstRaysPerRegion = 16;

struct RegionSeen {
  bool some_seen = false;
  bool some_hidden = false;
};

// What is seen of a region and those that touch it.
RegionSeen SeenAround(const SkyRegions& regions,
                      std::size_t region,
                      const std::vector<RegionSeen>& seen) {
  RegionSeen around;
  regions.ForNeighbours(region, [&](std::size_t neighbour) {
    around.some_seen |= seen[neighbour].some_seen;
    around.some_hidden |= seen[neighbour].some_hidden;
  });
  return around;
}

// Calls visit(direction index) for each bit that is set, in order.
template <class Visit>
void ForEachSeen(std::span<const std::uint64_t> words, const Visit& visit) {
  for (std::size_t w = 0; w < words.size(); ++w) {
    for (std::uint64_t rest = words[w]; rest != 0; rest &= rest - 1) {
      visit(w * kWordBits + static_cast<std::size_t>(std::countr_zero(rest)));
    }
  }
}

}  // namespace

SkyDirections::SkyDirections(const SkyRegions& regions, int per_region, std::uint64_t seed)
    : regions_(regions), per_region_(static_cast<std::size_t>(per_region)) {
  if (per_region < 1 || static_cast<std::size_t>(per_region) > kMostDirections / regions.Count()) {
    throw std::invalid_argument("sky directions: " + std::to_string(per_region) +
                                " a region; expected at least 1, and at most " +
                                std::to_string(kMostDirections) + " in all");
  }
  directions_.reserve(regions.Count() * per_region_);
  for (std::size_t region = 0; region < regions.Count(); ++region) {
    const glm::dvec2 rotation = RotationOf(seed, region);
    for (int i = 0; i < per_region; ++i) {
      const auto k = static_cast<double>(directions_.size());
      const glm::dvec2 point(Fraction((i + 0.5) / per_region + rotation.x),
                             Fraction(k * kLattice[0] + rotation.y));
      directions_.emplace_back(regions.DirectionIn(region, point));
    }
  }
}

double SkyDirections::SolidAngleSr() const {
  return regions_.SolidAngleSr() / static_cast<double>(per_region_);
}

void SkyVisibility::Reserve() {
  words_per_receiver_ = (directions_->Directions().size() + kWordBits - 1) / kWordBits;
  seen_.assign(normals_.size() * words_per_receiver_, 0);
}

template <class RayOrigin>
void SkyVisibility::Cast(const PatchScene& scene,
                         std::size_t receiver,
                         std::size_t direction,
                         const RayOrigin& ray_origin) {
  const glm::vec3& towards = directions_->Directions()[direction];
  if (!(glm::dot(normals_[receiver], towards) > 0.0f)) return;
  if (scene.caster.Occluded(ray_origin(receiver, direction), towards)) return;
  MarkSeen(receiver, direction);
}

SkyVisibility::SkyVisibility(const PatchScene& scene,
                             std::span<const Receiver> receivers,
                             std::shared_ptr<const SkyDirections> directions)
    : directions_(std::move(directions)) {
  std::vector<glm::vec3> origins_m;
  for (const Receiver& receiver : receivers) {
    const bool unit = std::abs(glm::dot(receiver.normal, receiver.normal) - 1.0f) < 1e-3f;
    normals_.push_back(unit ? receiver.normal : glm::vec3(0.0f));
    origins_m.push_back(OffsetFromSurface(receiver.position_m, receiver.normal));
  }
  Reserve();
  tbb::parallel_for(std::size_t{0}, normals_.size(), [&](std::size_t i) {
    if (normals_[i] == glm::vec3(0.0f)) return;
    for (std::size_t k = 0; k < directions_->Directions().size(); ++k) {
      Cast(scene, i, k, [&](std::size_t receiver, std::size_t) { return origins_m[receiver]; });
    }
  });
}

// First a few rays to each region. Where all faces of the group see all of a region, or nothing,
// and the like of its neighbours, more rays would add nothing.
template <class RayOrigin>
void SkyVisibility::CastGroup(const PatchScene& scene,
                              std::size_t group,
                              const RayOrigin& ray_origin) {
  const SkyRegions& regions = directions_->Regions();
  const std::size_t per_region = directions_->PerRegion();
  const std::size_t stride = regions.Count() < kLeastRegionsToSkip
                                 ? 1
                                 : std::max(std::size_t{1}, per_region / kFirstRaysPerRegion);
  const std::size_t first = group * kFacesPerGroup;
  const std::size_t last = std::min(normals_.size(), first + kFacesPerGroup);
  const auto is_first_ray = [stride](std::size_t face, std::size_t k) {
    return (k + face) % stride == 0;
  };
  const auto for_each_face = [&](const auto& visit) {
    for (std::size_t face = first; face < last; ++face) {
      if (normals_[face] != glm::vec3(0.0f)) visit(face);
    }
  };

  std::vector<RegionSeen> seen(regions.Count());
  for_each_face([&](std::size_t face) {
    for (std::size_t region = 0; region < regions.Count(); ++region) {
      for (std::size_t k = region * per_region; k < (region + 1) * per_region; ++k) {
        if (!is_first_ray(face, k)) continue;
        if (!(glm::dot(normals_[face], directions_->Directions()[k]) > 0.0f)) continue;
        Cast(scene, face, k, ray_origin);
        (IsSeen(face, k) ? seen[region].some_seen : seen[region].some_hidden) = true;
      }
    }
  });
  if (stride == 1) return;
  for (std::size_t region = 0; region < regions.Count(); ++region) {
    const RegionSeen around = SeenAround(regions, region, seen);
    if (!around.some_seen) continue;
    for_each_face([&](std::size_t face) {
      for (std::size_t k = region * per_region; k < (region + 1) * per_region; ++k) {
        if (is_first_ray(face, k)) continue;
        if (around.some_hidden) {
          Cast(scene, face, k, ray_origin);
        } else if (glm::dot(normals_[face], directions_->Directions()[k]) > 0.0f) {
          MarkSeen(face, k);
        }
      }
    });
  }
}

SkyVisibility SkyVisibility::OfFaces(const PatchScene& scene,
                                     const FacePoints& points,
                                     std::shared_ptr<const SkyDirections> directions) {
  if (points.FaceCount() != scene.FaceCount()) {
    throw std::invalid_argument("sky visibility: points of " + std::to_string(points.FaceCount()) +
                                " faces, expected " + std::to_string(scene.FaceCount()));
  }
  SkyVisibility visibility;
  visibility.directions_ = std::move(directions);
  visibility.normals_.resize(scene.FaceCount(), glm::vec3(0.0f));
  for (std::size_t face = 0; face < scene.FaceCount(); ++face) {
    if (!points.Of(face).empty()) visibility.normals_[face] = scene.FaceNormal(face);
  }
  const auto ray_origin = [&](std::size_t face, std::size_t direction) {
    // The third and fourth dimension of the directions' lattice, so that no part of a region is
    // seen from one part of the face alone.
    const glm::dvec2 turn = RotationOf(0, face);
    const auto k = static_cast<double>(direction);
    const glm::dvec2 unit(Fraction(k * kLattice[1] + turn.x), Fraction(k * kLattice[2] + turn.y));
    const std::span<const glm::vec3> of_face = points.Of(face);
    if (points.whole[face] == 0) {
      return of_face[static_cast<std::size_t>(unit.x * static_cast<double>(of_face.size()))];
    }
    const glm::uvec3& v = scene.mesh.triangles[face / 2];
    return OffsetFromSurface(TrianglePoint(scene.mesh.positions_m[v[0]],
                                           scene.mesh.positions_m[v[1]],
                                           scene.mesh.positions_m[v[2]],
                                           unit),
                             visibility.normals_[face]);
  };
  visibility.Reserve();
  const std::size_t groups = (scene.FaceCount() + kFacesPerGroup - 1) / kFacesPerGroup;
  tbb::parallel_for(std::size_t{0}, groups, [&](std::size_t group) {
    visibility.CastGroup(scene, group, ray_origin);
  });
  return visibility;
}

std::vector<float> SkyVisibility::FromRegions() const {
  const std::size_t regions = directions_ ? directions_->Regions().Count() : 0;
  std::vector<float> irradiance(normals_.size() * regions, 0.0f);
  tbb::parallel_for(std::size_t{0}, normals_.size(), [&](std::size_t i) {
    std::vector<double> sum(regions, 0.0);
    ForEachSeen(
        std::span(seen_).subspan(i * words_per_receiver_, words_per_receiver_), [&](std::size_t k) {
          sum[k / directions_->PerRegion()] += glm::dot(normals_[i], directions_->Directions()[k]);
        });
    for (std::size_t region = 0; region < regions; ++region) {
      irradiance[i * regions + region] =
          static_cast<float>(sum[region] * directions_->SolidAngleSr());
    }
  });
  return irradiance;
}

std::vector<glm::vec3> SkyVisibility::FromRadiance(
    std::span<const glm::vec3> radiance_of_directions) const {
  const std::size_t count = directions_ ? directions_->Directions().size() : 0;
  if (radiance_of_directions.size() != count) {
    throw std::invalid_argument("sky visibility: radiance of " +
                                std::to_string(radiance_of_directions.size()) +
                                " directions, expected " + std::to_string(count));
  }
  std::vector<glm::vec3> irradiance(normals_.size(), glm::vec3(0.0f));
  tbb::parallel_for(std::size_t{0}, normals_.size(), [&](std::size_t i) {
    glm::dvec3 sum(0.0);
    ForEachSeen(std::span(seen_).subspan(i * words_per_receiver_, words_per_receiver_),
                [&](std::size_t k) {
                  const double cosine = glm::dot(normals_[i], directions_->Directions()[k]);
                  sum += cosine * glm::dvec3(radiance_of_directions[k]);
                });
    irradiance[i] = glm::vec3(sum * directions_->SolidAngleSr());
  });
  return irradiance;
}

}  // namespace pleinair
