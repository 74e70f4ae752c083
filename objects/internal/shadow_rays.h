// Many rays towards the sun's disc, and a pixel's verdict from few of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/image.h"
#include "scene/ray_caster.h"

namespace pleinair {

// Rays towards the sun, past one caster and then another.
class ShadowRays {
 public:
  void Clear();
  // `tag`: any number by which the caller identifies the ray.
  void Add(const glm::vec3& origin_m, const glm::vec3& direction, std::uint32_t tag);
  std::size_t Count() const { return tags_.size(); }
  std::uint32_t Tag(std::size_t ray) const { return tags_[ray]; }
  // Leaves those that `caster` does not stop, in their order.
  void PassBy(const RayCaster& caster);

 private:
  std::vector<glm::vec3> origins_m_;
  std::vector<glm::vec3> directions_;
  std::vector<std::uint32_t> tags_;
};

// Verdict on a pixel from the few points of the disc that are tested for all pixels.
enum class Verdict : std::uint8_t { kNothing, kAllSeen, kAllHidden, kMixed };

// The verdict from `seen` points out of `asked`; kNothing where none was asked for.
Verdict VerdictOf(std::size_t seen, std::size_t asked);

// Whether shadow may have an edge in the pixel: where it or a neighbour is mixed, or disagrees.
bool IsNearEdge(const Image<Verdict>& verdicts, int x, int y);

}  // namespace pleinair
