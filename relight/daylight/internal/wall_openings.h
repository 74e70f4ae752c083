// Openings of one wall plane, on a raster.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "scene/image.h"
#include "scene/mesh.h"

namespace pleinair::internal {

// Points p of the plane have dot(normal, p) = offset_m; the room is where that is larger.
struct WallPlane {
  glm::dvec3 normal{0.0, 0.0, 1.0};
  double offset_m = 0.0;
  // In the plane: right, where it is not level horizontal, and up.
  glm::dvec3 right{1.0, 0.0, 0.0};
  glm::dvec3 up{0.0, 1.0, 0.0};

  static WallPlane Through(const glm::dvec3& normal, const glm::dvec3& point_m);
  glm::dvec2 Project(const glm::dvec3& point_m) const;
  glm::dvec3 Lift(const glm::dvec2& in_plane_m) const;
};

// A part of a plane, `lower_m` to `upper_m`, in square cells: covered by triangles in the plane,
// divided by those that cross it on the room's side, and what is left, in connected openings.
class WallRaster {
 public:
  WallRaster(const Mesh& mesh,
             const WallPlane& plane,
             const glm::dvec2& lower_m,
             const glm::dvec2& upper_m,
             double cell_m);

  // The opening that contains a point of the plane. The first call for an opening traces its rim.
  std::optional<int> OpeningAt(const glm::dvec2& in_plane_m);
  double AreaM2(int opening) const;
  // The share of the opening's rim that is wall in the plane.
  double FramedShare(int opening) const;
  // The opening's outline, grown by half a cell, without walls that it may enclose.
  std::vector<glm::dvec3> Outline(int opening) const;

 private:
  void Cover(const Mesh& mesh);
  void DrawSections(const Mesh& mesh);
  void Follow(const glm::ivec2& from);

  static constexpr std::int32_t kWall = -1;
  static constexpr std::int32_t kSection = -2;

  WallPlane plane_;
  glm::dvec2 lower_m_;
  double cell_m_;
  // 1 + an opening's number, one of the above, or 0 where not yet known.
  Image<std::int32_t> label_;
  struct Opening {
    std::size_t cells = 0;
    std::size_t rim = 0;
    std::size_t framed_rim = 0;
  };
  std::vector<Opening> openings_;
};

}  // namespace pleinair::internal
