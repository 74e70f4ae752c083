#include "objects/near_sunlight.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "relight/transport/sun_disc.h"
#include "scene/low_discrepancy.h"
#include "scene/ray_caster.h"

namespace pleinair {
namespace {

// The places of one receiver share these points of the disc; together they see all of it.
constexpr int kNearDiscPoints = 16;

// Where a ray meets the plane of a side's triangle, to a position's own rounding.
glm::vec3 OnPlaneOf(const PatchScene& scene,
                    std::int32_t side,
                    const glm::vec3& origin_m,
                    const glm::vec3& direction) {
  const glm::uvec3& corners = scene.mesh.triangles[static_cast<std::size_t>(side) / 2];
  const glm::dvec3 a_m(scene.mesh.positions_m[corners.x]);
  const glm::dvec3 normal = glm::cross(glm::dvec3(scene.mesh.positions_m[corners.y]) - a_m,
                                       glm::dvec3(scene.mesh.positions_m[corners.z]) - a_m);
  const glm::dvec3 from_m(origin_m);
  const double distance_m =
      glm::dot(normal, a_m - from_m) / glm::dot(normal, glm::dvec3(direction));
  return glm::vec3(from_m + distance_m * glm::dvec3(direction));
}

}  // namespace

// Rays of a receiver, cast together, and the places that they meet.
struct NearSunlight::RaysFromOnePlace {
  std::vector<glm::vec3> origins_m;
  std::vector<glm::vec3> directions;
  std::vector<FaceHit> hits;  // Before a cast, how far each goes.
  std::vector<Place> places;

  void Clear() { Resize(0); }
  void Resize(std::size_t count) {
    origins_m.resize(count);
    directions.resize(count);
    hits.resize(count);
  }
  void Add(const glm::vec3& origin_m, const glm::vec3& direction, float farthest_m) {
    origins_m.push_back(origin_m);
    directions.push_back(direction);
    hits.push_back({.distance_m = farthest_m});
  }
  void CastNearer(const RayCaster& caster) {
    caster.IntersectNearer(origins_m.data(), directions.data(), hits.size(), hits.data());
  }
};

void NearSunlightOptions::Validate() const {
  if (rays_per_receiver < 1) {
    throw std::invalid_argument("NearSunlightOptions::rays_per_receiver is " +
                                std::to_string(rays_per_receiver) + ": expected at least 1");
  }
  if (!(reach >= 0.0) || !std::isfinite(reach)) {
    throw std::invalid_argument("NearSunlightOptions::reach is " + std::to_string(reach) +
                                ": expected 0 or more");
  }
}

NearSunlight::NearSunlight(const PatchScene& real,
                           const PatchScene& objects,
                           std::span<const Receiver> receivers,
                           const NearSunlightOptions& options) {
  options.Validate();
  first_place_.assign(receivers.size() + 1, 0);
  share_ = 1.0f / static_cast<float>(options.rays_per_receiver);
  if (objects.mesh.Empty()) return;
  const BoundingBox box = BoundingBoxOf(objects.mesh);
  const glm::vec3 centre_m = 0.5f * (box.lower_m + box.upper_m);
  const float radius_m = 0.5f * glm::distance(box.lower_m, box.upper_m);
  const float reach_m = static_cast<float>(1.0 + options.reach) * radius_m;
  std::vector<std::vector<Place>> of_receiver(receivers.size());
  const auto look_from = [&](std::size_t i, RaysFromOnePlace& rays) {
    const Receiver& receiver = receivers[i];
    const float length = glm::dot(receiver.normal, receiver.normal);
    if (!(std::abs(length - 1.0f) < 1e-3f)) return;
    const NormalFrame frame(receiver.normal);
    const glm::dvec2 rotation = RotationOf(options.seed, options.first_receiver + i);
    const glm::vec3 origin_m = OffsetFromSurface(receiver.position_m, receiver.normal);
    // No place within reach is farther; a thousandth for rounding.
    const float farthest_m = 1.001f * (reach_m + glm::distance(origin_m, centre_m));
    rays.Clear();
    for (int k = 0; k < options.rays_per_receiver; ++k) {
      const glm::dvec2 point = FibonacciPoint(k, options.rays_per_receiver, rotation);
      rays.Add(origin_m, frame.CosineDirection(point), farthest_m);
    }
    rays.CastNearer(real.caster);
    // What is in reach; then, of that, what no object hides.
    rays.places.clear();
    std::size_t kept = 0;
    for (std::size_t k = 0; k < rays.hits.size(); ++k) {
      const FaceHit hit = rays.hits[k];
      if (hit.triangle == FaceHit::kNone) continue;
      const std::int32_t side = PatchScene::SideOfHit(hit);
      const glm::vec3 position_m = OnPlaneOf(real, side, origin_m, rays.directions[k]);
      if (glm::distance(position_m, centre_m) > reach_m) continue;
      const glm::vec3 normal = real.SideNormal(static_cast<std::size_t>(side));
      rays.places.push_back({OffsetFromSurface(position_m, normal), real.FaceOfSide(side)});
      rays.directions[kept] = rays.directions[k];
      rays.hits[kept++] = hit;
    }
    rays.Resize(kept);
    rays.CastNearer(objects.caster);
    for (std::size_t k = 0; k < kept; ++k) {
      if (rays.hits[k].triangle == FaceHit::kNone) of_receiver[i].push_back(rays.places[k]);
    }
  };
  constexpr std::size_t kReceiversPerTask = 16;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, receivers.size(), kReceiversPerTask),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      RaysFromOnePlace rays;
                      for (std::size_t i = range.begin(); i < range.end(); ++i) look_from(i, rays);
                    });
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    places_.insert(places_.end(), of_receiver[i].begin(), of_receiver[i].end());
    first_place_[i + 1] = static_cast<std::uint32_t>(places_.size());
  }
}

void NearSunlight::Append(const NearSunlight& next) {
  if (first_place_.empty()) first_place_.push_back(0);
  const std::uint32_t before = first_place_.back();
  for (std::size_t i = 1; i < next.first_place_.size(); ++i) {
    first_place_.push_back(before + next.first_place_[i]);
  }
  places_.insert(places_.end(), next.places_.begin(), next.places_.end());
  share_ = next.share_;
}

std::vector<glm::vec3> NearSunlight::Change(const PatchScene& real,
                                            const PatchScene& objects,
                                            const DirectionalLight& sun,
                                            std::span<const glm::vec3> real_direct) const {
  if (real_direct.size() != real.FaceCount()) {
    throw std::invalid_argument(
        std::string("near sunlight: real_direct has ") + std::to_string(real_direct.size()) +
        " entries, expected one a face, " + std::to_string(real.FaceCount()));
  }
  std::vector<glm::vec3> change(ReceiverCount(), glm::vec3(0.0f));
  const SunDisc disc(sun.direction_enu, sun.angular_radius_rad, kNearDiscPoints);
  const std::vector<glm::vec3>& to_sun = disc.Samples();
  tbb::parallel_for(std::size_t{0}, change.size(), [&](std::size_t i) {
    glm::vec3 sum(0.0f);
    for (std::uint32_t p = first_place_[i]; p < first_place_[i + 1]; ++p) {
      const Place& place = places_[p];
      const auto face = static_cast<std::size_t>(place.face);
      const glm::vec3& direction = to_sun[(p - first_place_[i]) % to_sun.size()];
      const float cosine = glm::dot(real.FaceNormal(face), direction);
      const bool is_lit = cosine > 0.0f && direction.z > 0.0f &&
                          !objects.caster.Occluded(place.start_m, direction) &&
                          !real.caster.Occluded(place.start_m, direction);
      sum += real.face_albedo_rgb[face] * (glm::vec3(is_lit ? cosine : 0.0f) - real_direct[face]);
    }
    change[i] = share_ * sum;
  });
  return change;
}

}  // namespace pleinair
