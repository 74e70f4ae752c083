// Rays from receivers into the cones in which they see objects: where they meet an object, and what
// they would meet without it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "objects/internal/object_cone.h"
#include "relight/transport/patch_scene.h"
#include "relight/transport/transport.h"

namespace pleinair {

class InfluenceRays {
 public:
  struct Hit {
    float share = 0.0f;  // Share of the receiver's cosine-weighted hemisphere.
    std::int32_t object_face = 0;
    std::int32_t behind = PatchScene::kSky;  // Real face.
    glm::vec3 direction{0.0f};
  };

  InfluenceRays() = default;
  // The objects are the groups of `objects`. The number of rays is as for
  // ObjectInfluenceOptions::rays_per_receiver; none are cast yet. Keeps no reference.
  InfluenceRays(const PatchScene& objects,
                std::span<const Receiver> receivers,
                int rays_per_receiver);

  // Casts the rays of up to `count` more receivers (0: of all that lack them), rounded up to runs.
  // All arguments are those of construction. Returns IsComplete().
  // Threads  the result does not depend on their number.
  bool Cast(const PatchScene& real,
            const PatchScene& objects,
            std::span<const Receiver> receivers,
            std::size_t count);
  bool IsComplete() const { return cast_ == runs_.size(); }

  std::span<const Hit> HitsOf(std::size_t receiver) const {
    const Run& run = runs_[receiver / kRun];
    const std::size_t i = receiver % kRun;
    return std::span(run.hits).subspan(run.begin[i], run.begin[i + 1] - run.begin[i]);
  }

 private:
  // Receivers that share their memory: few enough to spread over threads.
  static constexpr std::size_t kRun = 64;
  struct Run {
    std::vector<std::uint32_t> begin;  // Per receiver, hits [begin, next begin).
    std::vector<Hit> hits;
  };
  void CastRun(const PatchScene& real,
               const PatchScene& objects,
               std::span<const Receiver> receivers,
               std::size_t r,
               std::vector<Hit>& hits);

  std::vector<std::optional<ObjectBounds>> bounds_;
  std::vector<ConeDirections> direction_sets_;
  std::vector<Run> runs_;
  std::size_t cast_ = 0;  // Runs.
};

}  // namespace pleinair
