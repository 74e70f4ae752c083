// Directions that a GGX surface mirrors.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "scene/low_discrepancy.h"

namespace pleinair {

struct MirroredDirection {
  glm::vec3 direction{0.0f};
  glm::vec3 weight{0.0f};  // Factor on the radiance from there.
};

// One of the visible normals' mirror directions for a point of the unit square. The mean of weight
// times radiance is the reflected radiance (Heitz 2018, "Sampling the GGX distribution of visible
// normals", listing 1). `to_viewer` and `normal` are unit, on one side of the surface; Fresnel's
// term as in the renderer. None where the direction leads into the surface.
inline std::optional<MirroredDirection> MirrorByGgx(const glm::vec3& normal,
                                                    const glm::vec3& to_viewer,
                                                    const glm::vec3& reflectance,
                                                    float alpha,
                                                    const glm::dvec2& point) {
  const NormalFrame frame(normal);
  const glm::vec3 v(glm::dot(to_viewer, frame.tangent),
                    glm::dot(to_viewer, frame.bitangent),
                    std::max(glm::dot(to_viewer, normal), 1e-4f));
  const glm::vec3 stretched = glm::normalize(glm::vec3(alpha * v.x, alpha * v.y, v.z));
  const float across = stretched.x * stretched.x + stretched.y * stretched.y;
  const glm::vec3 t1 = across > 0.0f
                           ? glm::vec3(-stretched.y, stretched.x, 0.0f) / std::sqrt(across)
                           : glm::vec3(1.0f, 0.0f, 0.0f);
  const glm::vec3 t2 = glm::cross(stretched, t1);
  const float r = static_cast<float>(std::sqrt(point.x));
  const float phi = static_cast<float>(2.0 * std::numbers::pi * point.y);
  const float p1 = r * std::cos(phi);
  const float half = 0.5f * (1.0f + stretched.z);
  const float p2 =
      (1.0f - half) * std::sqrt(std::max(0.0f, 1.0f - p1 * p1)) + half * r * std::sin(phi);
  const glm::vec3 on_half =
      p1 * t1 + p2 * t2 + std::sqrt(std::max(0.0f, 1.0f - p1 * p1 - p2 * p2)) * stretched;
  const glm::vec3 h =
      glm::normalize(glm::vec3(alpha * on_half.x, alpha * on_half.y, std::max(0.0f, on_half.z)));
  const float v_dot_h = glm::dot(v, h);
  const glm::vec3 l = 2.0f * v_dot_h * h - v;
  if (!(l.z > 0.0f)) return std::nullopt;
  // G2 / G1 of height-correlated Smith masking.
  const auto lambda = [&](const glm::vec3& w) {
    const float tangent2 = alpha * alpha * (w.x * w.x + w.y * w.y) / (w.z * w.z);
    return 0.5f * (std::sqrt(1.0f + tangent2) - 1.0f);
  };
  const float masking = (1.0f + lambda(v)) / (1.0f + lambda(v) + lambda(l));
  const float grazing = std::pow(1.0f - std::clamp(v_dot_h, 0.0f, 1.0f), 5.0f);
  const glm::vec3 at_grazing = glm::clamp(50.0f * reflectance, reflectance, glm::vec3(1.0f));
  return MirroredDirection{
      glm::normalize(l.x * frame.tangent + l.y * frame.bitangent + l.z * normal),
      masking * (reflectance + (at_grazing - reflectance) * grazing)};
}

}  // namespace pleinair
