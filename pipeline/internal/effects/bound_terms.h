// Terms of several effects' bounds.
//
// Bounds are upper bounds, except for local-light's, which is an estimate with a margin. They do
// not cover four cases, each as small as the effect itself:
// - sun that reaches an object between its vertices and the middles of its faces (AnySeesSun);
// - shadows narrower than a pixel (SoftSun);
// - the noise of the rays at vertices, of which light at a single probe has less (local-light);
// - shadows under overhangs, where objects hide more than three quarters of the other light
//   (sun-shadow).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vector_relational.hpp>

#include "objects/object_reach.h"
#include "pipeline/internal/effects/frame_effect.h"
#include "scene/textured_material.h"

namespace pleinair {

class EffectStage;

inline constexpr float kInvPi = std::numbers::inv_pi_v<float>;
// Bounds this many times above the threshold are not refined.
inline constexpr double kFarAbove = 4.0;

// Step that visits some 256 of `count` elements first.
inline std::size_t StepOverFew(std::size_t count) { return (count + 255) / 256; }

inline bool IsDark(const glm::vec3& light) {
  return !glm::any(glm::greaterThan(light, glm::vec3(0.0f)));
}

inline glm::vec3 SunOf(const Lighting& lighting) { return glm::vec3(lighting.sun.irradiance_rgb); }

// The highest reflectances of a material at any place.
inline TexturedMaterial::Reflectances BrightestOf(const Material& material) {
  if (material.by_place) return material.by_place->Brightest();
  return {material.diffuse_albedo, material.specular_reflectance};
}

template <class Value>
float LargestOver(std::size_t count, const Value& value) {
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, count, 1024),
      0.0f,
      [&](const tbb::blocked_range<std::size_t>& range, float largest) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          largest = std::max(largest, value(i));
        }
        return largest;
      },
      [](float a, float b) { return std::max(a, b); });
}

// Upper bound, in code values, of the change of real pixels in reach, where their light falls to (1
// - hidden) of itself at least, and grows by `added` at most.
double ChangeOfReached(const EffectFrame& frame,
                       const InfluenceReach& reach,
                       const glm::vec3& hidden,
                       const glm::vec3& added);

// Bound of all light on objects except the sun's.
Bound LightOnObjects(EffectStage& stage, const EffectFrame& frame);
// Bound of the sun on objects, as if all of them were in the sun.
Bound SunOnObjects(EffectStage& stage, const EffectFrame& frame);

}  // namespace pleinair
