#include "objects/internal/shadow_rays.h"

#include <memory>

namespace pleinair {

void ShadowRays::Clear() {
  origins_m_.clear();
  directions_.clear();
  tags_.clear();
}

void ShadowRays::Add(const glm::vec3& origin_m, const glm::vec3& direction, std::uint32_t tag) {
  origins_m_.push_back(origin_m);
  directions_.push_back(direction);
  tags_.push_back(tag);
}

void ShadowRays::PassBy(const RayCaster& caster) {
  const auto occluded = std::make_unique<bool[]>(Count());
  caster.Occluded(origins_m_.data(), directions_.data(), Count(), occluded.get());
  std::size_t kept = 0;
  for (std::size_t ray = 0; ray < tags_.size(); ++ray) {
    if (occluded[ray]) continue;
    origins_m_[kept] = origins_m_[ray];
    directions_[kept] = directions_[ray];
    tags_[kept] = tags_[ray];
    ++kept;
  }
  origins_m_.resize(kept);
  directions_.resize(kept);
  tags_.resize(kept);
}

Verdict VerdictOf(std::size_t seen, std::size_t asked) {
  if (asked == 0) return Verdict::kNothing;
  if (seen == 0) return Verdict::kAllHidden;
  return seen == asked ? Verdict::kAllSeen : Verdict::kMixed;
}

bool IsNearEdge(const Image<Verdict>& verdicts, int x, int y) {
  const Verdict own = verdicts.At(x, y);
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (!verdicts.Contains(x + dx, y + dy)) continue;
      const Verdict other = verdicts.At(x + dx, y + dy);
      if (other == Verdict::kMixed) return true;
      if (other != Verdict::kNothing && other != own) return true;
    }
  }
  return false;
}

}  // namespace pleinair
