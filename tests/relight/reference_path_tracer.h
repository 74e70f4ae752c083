// A path tracer that shares nothing with relight's transport but the ray queries: no patches, no
// radiosity, no lattices. For tests to compare with; its noise is measured by two halves.
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "scene/mesh.h"
#include "scene/ray_caster.h"

namespace pleinair {

struct ReferencePoint {
  glm::dvec3 position_m;
  glm::dvec3 normal;
};

struct ReferenceOptions {
  int paths = 100000;
  int bounces = 64;     // Reflections; 64 leave out 1e-9 where the albedo is 0.72.
  int sky_samples = 4;  // At each surface point.
  std::uint64_t seed = 1;
};

// A basis light: one of `Count()` bins of the sky, or one beam.
struct ReferenceLight {
  std::size_t bins = 1;
  // The bin of a direction above the horizon.
  std::size_t (*bin_of)(const glm::dvec3& direction) = nullptr;
  // Unit, to a beam of unit irradiance; zero where the light is the sky.
  glm::dvec3 beam{0.0};
};

namespace reference {

inline glm::dvec3 CosineDirection(const glm::dvec3& normal, std::mt19937_64& random) {
  // A point on the unit sphere around the normal's tip: cosine-distributed (Lambert's law).
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double z = 1.0 - 2.0 * unit(random);
  const double angle = 2.0 * std::numbers::pi * unit(random);
  const double radius = std::sqrt(std::max(0.0, 1.0 - z * z));
  const glm::dvec3 sum = normal + glm::dvec3(radius * std::cos(angle), radius * std::sin(angle), z);
  const double length = glm::length(sum);
  return length > 1e-9 ? sum / length : normal;
}

}  // namespace reference

// Irradiance from surfaces alone: [point * bins + bin].
inline std::vector<glm::dvec3> ReferenceIndirect(const Mesh& mesh,
                                                 std::span<const ReferencePoint> points,
                                                 const ReferenceLight& light,
                                                 const ReferenceOptions& options) {
  const RayCaster caster(mesh);
  std::vector<glm::dvec3> irradiance(points.size() * light.bins, glm::dvec3(0.0));
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    std::seed_seq seeds{options.seed, static_cast<std::uint64_t>(i)};
    std::mt19937_64 random(seeds);
    const auto add = [&](std::size_t bin, const glm::dvec3& value) {
      irradiance[i * light.bins + bin] += value / static_cast<double>(options.paths);
    };
    for (int path = 0; path < options.paths; ++path) {
      glm::dvec3 normal = points[i].normal;
      glm::vec3 origin(points[i].position_m);
      glm::dvec3 weight(1.0);  // Irradiance that a unit of radiosity at the next point brings.
      for (int bounce = 0; bounce < options.bounces; ++bounce) {
        const glm::dvec3 direction = reference::CosineDirection(normal, random);
        const auto hit =
            caster.Intersect(OffsetFromSurface(origin, glm::vec3(normal)), glm::vec3(direction));
        if (!hit) break;
        normal = glm::dvec3(hit->geometric_normal);
        if (glm::dot(normal, direction) > 0.0) normal = -normal;
        origin = hit->position_m;
        weight *= glm::dvec3(mesh.materials[mesh.triangle_material[hit->triangle]].diffuse_albedo);
        const glm::vec3 start = OffsetFromSurface(origin, glm::vec3(normal));
        if (light.beam != glm::dvec3(0.0)) {
          const double cosine = glm::dot(normal, light.beam);
          if (cosine > 0.0 && !caster.Occluded(start, glm::vec3(light.beam))) {
            add(0, weight * cosine);
          }
        } else {
          for (int k = 0; k < options.sky_samples; ++k) {
            const glm::dvec3 to_sky = reference::CosineDirection(normal, random);
            if (to_sky.z > 0.0 && !caster.Occluded(start, glm::vec3(to_sky))) {
              add(light.bin_of(to_sky), weight * (std::numbers::pi / options.sky_samples));
            }
          }
        }
        // Paths of little weight end by chance, the rest make up for them.
        const double keep = std::min(1.0, 2.0 * std::max({weight.x, weight.y, weight.z}));
        if (std::uniform_real_distribution<double>(0.0, 1.0)(random) >= keep) break;
        weight /= keep;
      }
    }
  });
  return irradiance;
}

// Irradiance straight from the sky's bins, the beam left out: [point * bins + bin].
inline std::vector<double> ReferenceDirect(const Mesh& mesh,
                                           std::span<const ReferencePoint> points,
                                           const ReferenceLight& light,
                                           const ReferenceOptions& options) {
  const RayCaster caster(mesh);
  std::vector<double> irradiance(points.size() * light.bins, 0.0);
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    std::seed_seq seeds{options.seed, static_cast<std::uint64_t>(i)};
    std::mt19937_64 random(seeds);
    const glm::vec3 start =
        OffsetFromSurface(glm::vec3(points[i].position_m), glm::vec3(points[i].normal));
    for (int path = 0; path < options.paths; ++path) {
      const glm::dvec3 direction = reference::CosineDirection(points[i].normal, random);
      if (direction.z > 0.0 && !caster.Occluded(start, glm::vec3(direction))) {
        irradiance[i * light.bins + light.bin_of(direction)] += std::numbers::pi / options.paths;
      }
    }
  });
  return irradiance;
}

}  // namespace pleinair
