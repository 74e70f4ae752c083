// Compares a picture with the mesh's surfaces in it, without knowledge of light and albedo.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/camera.h"
#include "scene/image.h"
#include "scene/mesh.h"
#include "scene/ray_caster.h"

namespace pleinair {

// Segments of a picture by the mesh: 0 for the sky, else one number for all faces of one group,
// material and facing.
struct Segments {
  Image<std::uint32_t> label;
  std::uint32_t count = 1;  // Labels are less.
};

// A picture of any projection, seen from one point.
struct PixelRays {
  glm::dvec3 centre_world_m{0.0};
  int width = 0;
  int height = 0;
  // Direction of the pixel's middle (x, y), unit, in the world; zero where there is none.
  std::function<glm::dvec3(int, int)> direction;
};

Segments SegmentsOf(const Mesh& mesh, const RayCaster& caster, const PixelRays& picture);

// Log radiance, whose differences do not depend on the intensity of the light. Black pixels and
// those that are not finite count as 1e-4 of the picture's mean.
RgbImage LogRadiance(const RgbImage& radiance);

// Returns the share of the picture's variance that segments explain: 1 where each has one colour, 0
// where their borders are unrelated to the picture. Borders in the right place explain most, for
// any light and materials.
//
// `source(x, y)` is the picture's value at the segments' pixel, null to leave it out; `weight(y)`
// is the weight of a row's pixels.
template <typename Source, typename Weight>
double ExplainedShare(const Segments& segments, const Source& source, const Weight& weight) {
  struct Sums {
    double weight = 0.0;
    glm::dvec3 value{0.0};
  };
  std::vector<Sums> sums(segments.count);
  Sums all;
  double squares = 0.0;
  for (int y = 0; y < segments.label.height; ++y) {
    const double w = weight(y);
    for (int x = 0; x < segments.label.width; ++x) {
      const glm::vec3* const value = source(x, y);
      if (value == nullptr) continue;
      const glm::dvec3 v(*value);
      Sums& sum = sums[segments.label.At(x, y)];
      sum.weight += w;
      sum.value += w * v;
      squares += w * (v.x * v.x + v.y * v.y + v.z * v.z);
    }
  }
  const auto between = [](const Sums& sum) {
    const glm::dvec3& v = sum.value;
    return sum.weight > 0.0 ? (v.x * v.x + v.y * v.y + v.z * v.z) / sum.weight : 0.0;
  };
  double explained = 0.0;
  for (const Sums& sum : sums) {
    explained += between(sum);
    all.weight += sum.weight;
    all.value += sum.value;
  }
  const double variance = squares - between(all);
  return variance > 0.0 ? (explained - between(all)) / variance : 0.0;
}

}  // namespace pleinair
