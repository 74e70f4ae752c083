#include "relight/sky_visibility.h"

#include <bit>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "relight/internal/low_discrepancy.h"

namespace pleinair {
namespace {

constexpr std::size_t kWordBits = 64;

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
    for (int k = 0; k < per_region; ++k) {
      const glm::dvec2 point = FibonacciPoint(k, per_region, rotation);
      directions_.emplace_back(regions.DirectionIn(region, point));
    }
  }
}

double SkyDirections::SolidAngleSr() const {
  return regions_.SolidAngleSr() / static_cast<double>(per_region_);
}

std::vector<glm::vec3> SkyDirections::RadianceOf(const SkyShape& shape) const {
  std::vector<glm::vec3> radiance;
  radiance.reserve(directions_.size());
  for (const glm::vec3& direction : directions_) radiance.push_back(shape.Radiance(direction));
  return radiance;
}

template <class RayOrigin>
void SkyVisibility::Cast(const PatchScene& scene, const RayOrigin& ray_origin) {
  const std::vector<glm::vec3>& directions = directions_->Directions();
  words_per_receiver_ = (directions.size() + kWordBits - 1) / kWordBits;
  seen_.assign(normals_.size() * words_per_receiver_, 0);
  tbb::parallel_for(std::size_t{0}, normals_.size(), [&](std::size_t i) {
    const glm::vec3& normal = normals_[i];
    if (normal == glm::vec3(0.0f)) return;
    std::uint64_t* const words = seen_.data() + i * words_per_receiver_;
    for (std::size_t k = 0; k < directions.size(); ++k) {
      if (!(glm::dot(normal, directions[k]) > 0.0f)) continue;
      if (scene.caster.Occluded(ray_origin(i, k), directions[k])) continue;
      words[k / kWordBits] |= std::uint64_t{1} << (k % kWordBits);
    }
  });
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
  Cast(scene, [&](std::size_t i, std::size_t) { return origins_m[i]; });
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
  visibility.Cast(scene, [&](std::size_t face, std::size_t direction) {
    const std::span<const glm::vec3> of_face = points.Of(face);
    return of_face[(direction + face) % of_face.size()];
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
