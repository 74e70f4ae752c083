#include "objects/internal/influence_rays.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "objects/internal/object_cone.h"
#include "scene/ray_caster.h"

namespace pleinair {
namespace {

// A small share of a surface's view may have a larger relative error: half the rays for half the
// share.
constexpr float kShareOfAllRays = 1.0f / 16.0f;

// Rays of one receiver that are cast together: a few packets.
class RayBatch {
 public:
  RayBatch(const PatchScene& real, const PatchScene& objects) : real_(real), objects_(objects) {}

  void Add(const glm::vec3& start_m,
           std::uint32_t group,
           const glm::vec3& direction,
           float share,
           std::vector<InfluenceRays::Hit>& hits) {
    directions_[count_] = direction;
    shares_[count_] = share;
    if (++count_ == kRays) Cast(start_m, group, hits);
  }

  // Those that meet the object `group` before all else.
  void Cast(const glm::vec3& start_m, std::uint32_t group, std::vector<InfluenceRays::Hit>& hits) {
    objects_.caster.IntersectFrom(
        start_m, RayCaster::Origin::kOffMesh, directions_.data(), count_, on_objects_.data());
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const FaceHit& hit = on_objects_[i];
      // Cones may overlap: each object's own cone counts it.
      if (hit.triangle == FaceHit::kNone || objects_.mesh.triangle_group[hit.triangle] != group) {
        continue;
      }
      on_objects_[kept] = hit;
      directions_[kept] = directions_[i];
      shares_[kept] = shares_[i];
      ++kept;
    }
    real_.caster.IntersectFrom(
        start_m, RayCaster::Origin::kMayBeOnMesh, directions_.data(), kept, behind_.data());
    for (std::size_t i = 0; i < kept; ++i) {
      const FaceHit& behind = behind_[i];
      if (behind.distance_m < on_objects_[i].distance_m) continue;
      hits.push_back(
          {shares_[i],
           objects_.FaceOfHit(on_objects_[i]),
           behind.triangle == FaceHit::kNone ? PatchScene::kSky : real_.FaceOfHit(behind),
           directions_[i]});
    }
    count_ = 0;
  }

 private:
  static constexpr std::size_t kRays = 64;

  const PatchScene& real_;
  const PatchScene& objects_;
  std::size_t count_ = 0;
  std::array<glm::vec3, kRays> directions_;
  std::array<float, kRays> shares_{};
  std::array<FaceHit, kRays> on_objects_;
  std::array<FaceHit, kRays> behind_;
};

}  // namespace

InfluenceRays::InfluenceRays(const PatchScene& objects,
                             std::span<const Receiver> receivers,
                             int rays_per_receiver)
    : bounds_(BoundsOfObjects(objects.mesh)), runs_((receivers.size() + kRun - 1) / kRun) {
  for (int part = 1; part <= 8; part *= 2) {
    direction_sets_.emplace_back((rays_per_receiver + part - 1) / part);
  }
}

bool InfluenceRays::Cast(const PatchScene& real,
                         const PatchScene& objects,
                         std::span<const Receiver> receivers,
                         std::size_t count) {
  const std::size_t end =
      count == 0 ? runs_.size() : std::min(runs_.size(), cast_ + (count + kRun - 1) / kRun);
  tbb::enumerable_thread_specific<std::vector<Hit>> hits_of_run;
  tbb::parallel_for(cast_, end, [&](std::size_t r) {
    CastRun(real, objects, receivers, r, hits_of_run.local());
  });
  cast_ = end;
  return IsComplete();
}

void InfluenceRays::CastRun(const PatchScene& real,
                            const PatchScene& objects,
                            std::span<const Receiver> receivers,
                            std::size_t r,
                            std::vector<Hit>& hits) {
  Run& run = runs_[r];
  run.begin.clear();
  hits.clear();
  RayBatch batch(real, objects);
  const std::size_t first = r * kRun;
  for (std::size_t i = first; i < std::min(first + kRun, receivers.size()); ++i) {
    run.begin.push_back(static_cast<std::uint32_t>(hits.size()));
    const auto& [position_m, normal] = receivers[i];
    const glm::vec3 start_m = OffsetFromSurface(position_m, normal);
    for (std::uint32_t group = 0; group < bounds_.size(); ++group) {
      if (!bounds_[group]) continue;
      const BoundingBox& box = bounds_[group]->box;
      const ObjectCone cone(*bounds_[group], position_m);
      const float share_of_rays = cone.LargestShare(normal) / kShareOfAllRays;
      std::size_t set = 0;
      while (set + 1 < direction_sets_.size() &&
             share_of_rays < 1.0f / static_cast<float>(1u << set)) {
        ++set;
      }
      direction_sets_[set].ForEach(cone, normal, [&](const glm::vec3& direction, float share) {
        if (MayMeet(box, start_m, direction)) batch.Add(start_m, group, direction, share, hits);
      });
      batch.Cast(start_m, group, hits);
    }
  }
  run.begin.push_back(static_cast<std::uint32_t>(hits.size()));
  run.hits = hits;
}

}  // namespace pleinair
