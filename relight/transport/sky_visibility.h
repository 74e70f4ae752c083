// Which directions of the sky receivers see, kept as one bit a direction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/transport/face_points.h"
#include "relight/transport/patch_scene.h"
#include "relight/transport/transport.h"
#include "scene/sky_regions.h"
#include "scene/sky_shape.h"

namespace pleinair {

// The same number of directions in each region, spread evenly over it (a rank-1 lattice), so that
// all stand for the same solid angle. Immutable.
class SkyDirections {
 public:
  static constexpr int kMostDirections = 1 << 22;

  // Throws std::invalid_argument for per_region < 1 or more than kMostDirections in all.
  SkyDirections(const SkyRegions& regions, int per_region, std::uint64_t seed = 1);

  const SkyRegions& Regions() const { return regions_; }
  std::size_t PerRegion() const { return per_region_; }
  // Region r's are [r PerRegion(), (r + 1) PerRegion()).
  const std::vector<glm::vec3>& Directions() const { return directions_; }
  // Solid angle that each direction represents.
  double SolidAngleSr() const;

 private:
  SkyRegions regions_;
  std::size_t per_region_;
  std::vector<glm::vec3> directions_;
};

// Unlike the sky's part of GatheredRays these directions don't follow the receiver's cosine: each
// region gets as many, also those low ones that a floor sees through a window. Any sky can be
// integrated over them, again and again.
//
// Accuracy  a region of which 256 directions are cast, half hidden behind straight edges: 1 %.
// Memory    one bit a receiver and direction.
// Threads   immutable once made; the result does not depend on the number of threads.
class SkyVisibility {
 public:
  SkyVisibility() = default;
  // A receiver without a unit normal sees nothing.
  SkyVisibility(const PatchScene& scene,
                std::span<const Receiver> receivers,
                std::shared_ptr<const SkyDirections> directions);
  // One receiver a face, seen from all over it where all of it is exposed, else from its points.
  // With many regions most rays go where a few first ones say that a region, or one beside it, is
  // seen in part.
  static SkyVisibility OfFaces(const PatchScene& scene,
                               const FacePoints& points,
                               std::shared_ptr<const SkyDirections> directions);

  // Irradiance from unit radiance of each region: [receiver * regions + region].
  std::vector<float> FromRegions() const;
  // Irradiance from a sky of given radiance in each direction. Throws std::invalid_argument for a
  // span of another length.
  std::vector<glm::vec3> FromRadiance(std::span<const glm::vec3> radiance_of_directions) const;

 private:
  void Reserve();
  bool IsSeen(std::size_t receiver, std::size_t direction) const {
    return (seen_[receiver * words_per_receiver_ + direction / 64] >> (direction % 64)) & 1u;
  }
  void MarkSeen(std::size_t receiver, std::size_t direction) {
    seen_[receiver * words_per_receiver_ + direction / 64] |= std::uint64_t{1} << (direction % 64);
  }
  template <class RayOrigin>
  void Cast(const PatchScene& scene,
            std::size_t receiver,
            std::size_t direction,
            const RayOrigin& ray_origin);
  template <class RayOrigin>
  void CastGroup(const PatchScene& scene, std::size_t group, const RayOrigin& ray_origin);

  std::shared_ptr<const SkyDirections> directions_;
  std::vector<glm::vec3> normals_;
  std::size_t words_per_receiver_ = 0;
  std::vector<std::uint64_t> seen_;
};

}  // namespace pleinair
