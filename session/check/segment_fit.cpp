#include "session/check/segment_fit.h"

#include <algorithm>
#include <array>
#include <map>

#include <glm/geometric.hpp>

namespace pleinair {

Segments SegmentsOf(const Mesh& mesh, const RayCaster& caster, const PixelRays& picture) {
  Segments segments;
  segments.label = Image<std::uint32_t>(picture.width, picture.height);
  const glm::vec3 centre_m(picture.centre_world_m);
  // Facings in steps of some 30 deg: one for each face of a box, few for a column.
  constexpr float kFacingSteps = 2.0f;
  std::map<std::array<std::int64_t, 5>, std::uint32_t> labels;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const glm::dvec3 along = picture.direction(x, y);
      if (!(glm::length(along) > 0.0)) continue;
      const auto hit = caster.Intersect(centre_m, glm::vec3(along));
      if (!hit) continue;
      glm::vec3 normal = hit->geometric_normal;
      if (glm::dot(normal, glm::vec3(along)) > 0.0f) normal = -normal;
      const glm::vec3 facing = kFacingSteps * normal;
      const auto [found, is_new] = labels.try_emplace({mesh.triangle_group[hit->triangle],
                                                       mesh.triangle_material[hit->triangle],
                                                       std::lround(facing.x),
                                                       std::lround(facing.y),
                                                       std::lround(facing.z)},
                                                      segments.count);
      if (is_new) ++segments.count;
      segments.label.At(x, y) = found->second;
    }
  }
  return segments;
}

RgbImage LogRadiance(const RgbImage& radiance) {
  double sum = 0.0;
  for (const glm::vec3& rgb : radiance.pixels) {
    const double mean = (double(rgb.x) + rgb.y + rgb.z) / 3.0;
    if (std::isfinite(mean) && mean > 0.0) sum += mean;
  }
  const auto floor = static_cast<float>(std::max(
      1e-4 * sum / static_cast<double>(std::max<std::size_t>(1, radiance.pixels.size())), 1e-30));
  RgbImage logarithm(radiance.width, radiance.height);
  for (std::size_t i = 0; i < radiance.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const float value = radiance.pixels[i][c];
      logarithm.pixels[i][c] = std::log(std::isfinite(value) ? std::max(value, floor) : floor);
    }
  }
  return logarithm;
}

}  // namespace pleinair
