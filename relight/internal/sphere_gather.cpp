#include "relight/internal/sphere_gather.h"

#include <algorithm>
#include <array>
#include <numbers>

#include <tbb/parallel_for.h>

#include "scene/sphere_directions.h"

namespace pleinair::internal {
namespace {

using Weights = std::array<double, kProbeShCoefficients>;

}  // namespace

SphereGather::SphereGather(const PatchScene& scene,
                           std::span<const glm::vec3> points_m,
                           int rays,
                           std::uint64_t seed)
    : points_(points_m.size()), directions_(SphereDirections(rays + rays % 2, seed)) {
  const auto solid_angle =
      static_cast<float>(4.0 * std::numbers::pi / static_cast<double>(directions_.size()));
  for (const glm::vec3& direction : directions_) {
    auto weights = EvaluateShBasis9(direction);
    for (float& weight : weights) weight *= solid_angle;
    weights_.push_back(weights);
  }
  sources_.resize(points_ * directions_.size());
  tbb::parallel_for(std::size_t{0}, points_, [&](std::size_t i) {
    Source* const sources = sources_.data() + i * directions_.size();
    for (std::size_t k = 0; k < directions_.size(); ++k) {
      const glm::vec3& direction = directions_[k];
      const auto hit = scene.caster.Intersect(points_m[i], direction);
      const std::int32_t open = direction.z > 0.0f ? PatchScene::kSky : kDark;
      sources[k] = {hit ? scene.FaceOfHit(*hit, direction) : open, static_cast<std::uint32_t>(k)};
    }
    std::sort(sources, sources + directions_.size(), [](const Source& a, const Source& b) {
      return a.face != b.face ? a.face < b.face : a.direction < b.direction;
    });
  });
}

std::vector<ShRgb> SphereGather::FromFaces(std::span<const glm::vec3> face_radiosity,
                                           std::size_t lights) const {
  std::vector<ShRgb> coefficients(points_ * lights);
  tbb::parallel_for(std::size_t{0}, points_, [&](std::size_t i) {
    ShRgb* const of_point = coefficients.data() + i * lights;
    std::fill_n(of_point, lights, ShRgb{});
    const auto sources = std::span(sources_).subspan(i * directions_.size(), directions_.size());
    for (std::size_t first = 0; first < sources.size();) {
      const std::int32_t face = sources[first].face;
      Weights sum{};
      std::size_t last = first;
      for (; last < sources.size() && sources[last].face == face; ++last) {
        const auto& weights = weights_[sources[last].direction];
        for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += weights[k];
      }
      first = last;
      if (face < 0) continue;
      const glm::vec3* const radiosity =
          face_radiosity.data() + static_cast<std::size_t>(face) * lights;
      for (std::size_t light = 0; light < lights; ++light) {
        for (std::size_t k = 0; k < sum.size(); ++k) {
          of_point[light][k] += static_cast<float>(sum[k] / std::numbers::pi) * radiosity[light];
        }
      }
    }
  });
  return coefficients;
}

std::vector<ShRgb> SphereGather::FromSky(
    const std::function<SkyRay(const glm::vec3& direction)>& sky_ray, std::size_t lights) const {
  std::vector<SkyRay> rays;
  for (const glm::vec3& direction : directions_) {
    rays.push_back(direction.z > 0.0f ? sky_ray(direction) : SkyRay{});
  }
  std::vector<ShRgb> coefficients(points_ * lights);
  tbb::parallel_for(std::size_t{0}, points_, [&](std::size_t i) {
    // Thousands of terms: double, to keep single precision's digits.
    std::vector<std::array<glm::dvec3, kProbeShCoefficients>> sums(lights);
    for (auto& sum : sums) sum.fill(glm::dvec3(0.0));
    const auto sources = std::span(sources_).subspan(i * directions_.size(), directions_.size());
    for (const Source& source : sources) {
      if (source.face != PatchScene::kSky) continue;
      const SkyRay& ray = rays[source.direction];
      const auto& weights = weights_[source.direction];
      for (std::size_t k = 0; k < weights.size(); ++k) {
        sums[ray.light][k] += double{weights[k]} * glm::dvec3(ray.radiance);
      }
    }
    for (std::size_t light = 0; light < lights; ++light) {
      for (std::size_t k = 0; k < kProbeShCoefficients; ++k) {
        coefficients[i * lights + light][k] = glm::vec3(sums[light][k]);
      }
    }
  });
  return coefficients;
}

}  // namespace pleinair::internal
