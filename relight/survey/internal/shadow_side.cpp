#include "relight/survey/internal/shadow_side.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "scene/low_discrepancy.h"

namespace pleinair {
namespace {

// Surfaces that the sun meets at less than this slant are moved no farther along themselves.
constexpr float kLeastCosine = 0.2f;

glm::vec3 TurnedAboutZ(const glm::vec3& v, double angle_rad) {
  const auto cosine = static_cast<float>(std::cos(angle_rad));
  const auto sine = static_cast<float>(std::sin(angle_rad));
  return {cosine * v.x - sine * v.y, sine * v.x + cosine * v.y, v.z};
}

class RowOfRays {
 public:
  void Add(const glm::vec3& origin_m, const glm::vec3& direction, int x) {
    origins_m_.push_back(origin_m);
    directions_.push_back(direction);
    columns_.push_back(x);
  }
  // Calls disagree(x) where a ray is free and the pixel is not lit, or the other way round.
  template <class IsLit, class Disagree>
  void Cast(const RayCaster& caster, const IsLit& is_lit, const Disagree& disagree) const {
    const auto occluded = std::make_unique<bool[]>(columns_.size());
    caster.Occluded(origins_m_.data(), directions_.data(), columns_.size(), occluded.get());
    for (std::size_t ray = 0; ray < columns_.size(); ++ray) {
      if (occluded[ray] == is_lit(columns_[ray])) disagree(columns_[ray]);
    }
  }

 private:
  std::vector<glm::vec3> origins_m_;
  std::vector<glm::vec3> directions_;
  std::vector<int> columns_;
};

}  // namespace

Image<ShadowSide> FindShadowSides(const RayCaster& caster,
                                  const SunDisc& disc,
                                  const ViewRays& rays,
                                  const Misplacement& misplacement,
                                  const SurfaceView& view) {
  Image<ShadowSide> sides(view.Width(), view.Height(), ShadowSide::kUnsure);
  const glm::vec3 sun = disc.Direction();
  const NormalFrame frame{sun};
  const auto moved_m = static_cast<float>(misplacement.moved_m);
  const auto turned = static_cast<float>(std::sin(misplacement.turned_rad));
  tbb::parallel_for(0, view.Height(), [&](int y) {
    RowOfRays row;
    for (int x = 0; x < view.Width(); ++x) {
      const std::size_t i = view.region.Index(x, y);
      if (view.region.pixels[i] == SurfaceView::kNoRegion) continue;
      const glm::vec3& normal = view.normal_world.pixels[i];
      const float cosine = glm::dot(normal, sun);
      const float seen = view.sun_visibility.pixels[i];
      if (cosine < -turned) sides.pixels[i] = ShadowSide::kShaded;
      if (cosine < turned || (seen > 0.0f && seen < 1.0f)) continue;
      sides.pixels[i] = seen > 0.0f ? ShadowSide::kLit : ShadowSide::kShaded;

      const glm::vec3 position_m = view.position_world_m.pixels[i];
      for (const float sign : {-1.0f, 1.0f}) {
        for (const glm::vec3& across : {frame.tangent, frame.bitangent}) {
          // Along the surface, by as much across the rays.
          const glm::vec3 way =
              across - sun * (glm::dot(across, normal) / std::max(cosine, kLeastCosine));
          row.Add(OffsetFromSurface(position_m + sign * moved_m * way, normal), sun, x);
        }
        const double angle_rad = sign * misplacement.turned_rad;
        const glm::vec3 towards = TurnedAboutZ(position_m - rays.origin_m, angle_rad);
        const float slant = glm::dot(towards, normal);
        // Where the turned ray meets the surface's plane.
        const float reach = glm::dot(position_m - rays.origin_m, normal) / slant;
        if (!(reach > 0.5f && reach < 2.0f)) {
          sides.pixels[i] = ShadowSide::kUnsure;
          continue;
        }
        row.Add(OffsetFromSurface(rays.origin_m + reach * towards, normal),
                TurnedAboutZ(sun, angle_rad),
                x);
      }
    }
    row.Cast(
        caster,
        [&](int x) { return view.sun_visibility.At(x, y) > 0.0f; },
        [&](int x) { sides.At(x, y) = ShadowSide::kUnsure; });
  });
  return sides;
}

}  // namespace pleinair
