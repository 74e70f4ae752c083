// The survey's albedo at points of a surface, wherever they are seen from.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/survey/survey.h"
#include "relight/transport/patch_scene.h"
#include "scene/lat_long.h"

namespace pleinair {

// What the survey's map says of one surface point.
struct SurveyedPoint {
  glm::vec3 albedo_rgb{0.0f};
  float edge_distance_px = 0.0f;  // In map pixels.
  bool may_be_sampled = false;
};

// Holds a copy of what it looks up.
class SurveyLookUp {
 public:
  explicit SurveyLookUp(const Survey& survey);

  // None where the map sees another surface in that direction. Bilinear over the texels that show
  // the point's own plane and whose albedo was measured.
  std::optional<SurveyedPoint> At(const glm::vec3& position_m,
                                  const glm::vec3& normal,
                                  std::int32_t region) const;

  // The albedo at a point of `real`'s face over that face's; 1 where the map does not show the
  // point.
  glm::vec3 TintOf(const PatchScene& real, std::size_t face, const glm::vec3& position_m) const;

  // Side of a texel's footprint on a surface over that of a view pixel's, seen from
  // `view_origin_m` with `focal_px`: square roots of the areas, so that slant counts.
  float TexelSidePx(const glm::vec3& position_m,
                    const glm::vec3& normal,
                    const glm::vec3& view_origin_m,
                    double focal_px) const;

 private:
  // One pixel of the map, in one place of the memory: looking up is waiting for it.
  struct Texel {
    glm::vec3 position_m;
    glm::vec3 normal;
    glm::vec3 albedo_rgb;
    float edge_distance_px;
    std::int32_t region;  // SurfaceView::kNoRegion where no albedo was measured.
    std::uint8_t may_be_sampled;
    // It, the next to its right and the two below them are measured, on one plane of one region.
    std::uint8_t is_one_plane;
  };

  const Texel& At(int x, int y) const;
  bool IsOnePlane(int left, int top) const;

  std::vector<Texel> texels_;
  glm::vec3 origin_m_;
  LatLongSize size_;
};

}  // namespace pleinair
