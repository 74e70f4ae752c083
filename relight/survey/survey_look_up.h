// The survey's albedo at points of a surface, wherever they are seen from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "relight/survey/survey.h"
#include "relight/transport/patch_scene.h"
#include "scene/lat_long.h"

namespace pleinair {

// The survey map's data for one surface point.
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
                                  std::int32_t region) const {
    return At(PlaceOf(position_m), position_m, normal, region);
  }
  // For a point whose place in the map is known.
  std::optional<SurveyedPoint> At(const glm::vec2& place,
                                  const glm::vec3& position_m,
                                  const glm::vec3& normal,
                                  std::int32_t region) const;

  // Mean albedo over a square of about that many pixels of the map around a place, at least 2; none
  // where any of them shows something else than the point's plane.
  std::optional<glm::vec3> MeanAlbedo(const glm::vec2& place,
                                      float side_px,
                                      const glm::vec3& position_m,
                                      const glm::vec3& normal,
                                      std::int32_t region) const;

  // Where the map shows a point, in its pixels, whole numbers at their middles.
  glm::vec2 PlaceOf(const glm::vec3& position_m) const;
  // Between places this near to one another, PlaceOf is linear along a plane to 0.02 pixels.
  float LinearWithinPx() const { return 0.005f * static_cast<float>(size_.width); }

  // The albedo at a point of a side of `real`'s triangles over its face's; 1 where the map does not
  // show the point.
  glm::vec3 TintOf(const PatchScene& real, std::int32_t side, const glm::vec3& position_m) const;

  // Side of a texel's footprint on a surface over that of a view pixel's, seen from
  // `view_origin_m` with `focal_px`: square roots of the areas, so that slant counts.
  float TexelSidePx(const glm::vec3& position_m,
                    const glm::vec3& normal,
                    const glm::vec3& view_origin_m,
                    double focal_px) const;

 private:
  // One pixel of the map and the cell that it makes with the next to its right and the two below
  // them, contiguous in memory: look-ups are bound by memory access.
  struct Texel {
    glm::vec3 position_m;
    glm::vec3 normal;
    float edge_distance_px;
    float cell_edge_distance_px;  // The least of its four.
    std::int32_t region;          // SurfaceView::kNoRegion where no albedo was measured.
    std::uint8_t may_be_sampled;
    std::uint8_t cell_may_be_sampled;     // All four.
    std::uint8_t cell_is_one_plane;       // All four are measured, on one plane of one region.
    std::uint8_t is_in_unmodelled_shade;  // See Survey.
  };

  // The map at half the resolution of the level before, means over two pixels a side. Texels are
  // known by the first of the map's pixels that they are of.
  struct Level {
    LatLongSize size;
    std::vector<glm::vec3> albedo_rgb;
    std::vector<std::uint8_t> is_one_plane;  // All of the map's pixels that a texel is of.
  };

  std::size_t Index(int x, int y) const { return Index(size_, x, y); }
  static std::size_t Index(const LatLongSize& size, int x, int y);
  const Texel& NearestTexel(const glm::vec2& place) const;
  void AddLevel();
  static bool Shows(const Texel& texel,
                    const glm::vec3& position_m,
                    const glm::vec3& normal,
                    std::int32_t region,
                    float range_m);
  void DescribeCell(int left, int top);

  std::vector<Texel> texels_;
  std::vector<glm::vec3> albedo_rgb_;  // Per texel.
  std::vector<Level> levels_;          // From half resolution on.
  glm::vec3 origin_m_;
  LatLongSize size_;
};

}  // namespace pleinair
