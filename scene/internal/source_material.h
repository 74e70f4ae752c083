// A material as a file has it.
#pragma once

#include <cmath>
#include <string>

#include <glm/vec2.hpp>

#include "scene/textured_material.h"

namespace pleinair {

struct SourceMaterial : TexturedMaterial {
  unsigned texture_set = 0;        // Which of a vertex' texture coordinates.
  std::string unreadable_texture;  // One that is wanted, and cannot be read; else empty.
  float opacity_left_out = 1.0f;   // Below 1: of a thing that is treated as opaque.
  // The transform of coordinates before the look-up, v down (KHR_texture_transform): scaled, turned
  // counter-clockwise around the origin, and moved.
  glm::dvec2 uv_scale{1.0};
  double uv_rotation_rad = 0.0;
  glm::dvec2 uv_offset{0.0};

  glm::dvec2 PlaceOf(const glm::dvec2& uv) const {
    const glm::dvec2 scaled = uv_scale * uv;
    const double c = std::cos(uv_rotation_rad);
    const double s = std::sin(uv_rotation_rad);
    return uv_offset + glm::dvec2(c * scaled.x + s * scaled.y, c * scaled.y - s * scaled.x);
  }
};

}  // namespace pleinair
