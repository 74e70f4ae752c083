// The angle between real shadows and the computed sun, from places that a person has marked on the
// edges of shadows. For pictures whose surfaces are too patchy to separate sun and shade
// automatically.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "scene/camera.h"
#include "scene/ray_caster.h"

namespace pleinair {

// A pixel where the edge of a shadow that the mesh casts lies on a surface of the mesh.
struct ShadowEdgeMark {
  Camera camera;
  glm::dvec2 pixel;                   // Integers are centres.
  glm::dvec3 sun_direction_enu{0.0};  // The computed one, unit.
};

// The angles of all marks, and the turn of the sun that they determine.
struct ShadowEdgeFit {
  // Between the computed sun and the nearest direction in which the mesh's outline is visible from
  // the mark: the error of the mark's own shadow. Empty where the mark is on no surface, or no
  // outline is within kShadowEdgeReachRad.
  std::vector<std::optional<double>> angle_rad;  // Per mark.
  std::size_t used = 0;                          // Marks that have one.
  double rms_rad = 0.0;                          // Over those marks.
  double largest_rad = 0.0;

  // The turn of the sun about the vertical, clockwise, that minimises the sum of the squared
  // angles: as ShadowDirection's azimuth_offset_rad. Its deviation is from leaving out each mark in
  // turn. Both need at least three marks.
  std::optional<double> azimuth_offset_rad;
  double azimuth_stddev_rad = 0.0;
  double rms_after_rad = 0.0;  // With the sun turned so.
};

// Angles are found in steps of kShadowEdgeStepRad, up to kShadowEdgeReachRad away from the
// sun.
inline constexpr double kShadowEdgeStepRad = 0.000873;  // 0.05 deg.
inline constexpr double kShadowEdgeReachRad = 0.1745;   // 10 deg.

// Method  For each mark the directions around the sun that the mesh covers are found on a raster.
//         The outline is where neighbours differ.
// Throws  std::invalid_argument for a sun that is not above the horizon, naming the mark.
ShadowEdgeFit FitShadowEdges(const RayCaster& mesh, std::span<const ShadowEdgeMark> marks);

}  // namespace pleinair
