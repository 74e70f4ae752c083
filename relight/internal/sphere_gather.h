// What points in the open see all around, folded with spherical harmonics.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/transport/patch_scene.h"
#include "scene/spherical_harmonics.h"

namespace pleinair::internal {

// All points share one set of directions, spread evenly over the sphere.
class SphereGather {
 public:
  SphereGather(const PatchScene& scene,
               std::span<const glm::vec3> points_m,
               int rays,
               std::uint64_t seed);

  // Coefficients [point * lights + light] of the light of faces, [face * lights + light].
  std::vector<ShRgb> FromFaces(std::span<const glm::vec3> face_radiosity, std::size_t lights) const;
  // Coefficients of the open sky. `light_of` names the light that a direction belongs to, among
  // `lights`, and its radiance.
  struct SkyRay {
    std::size_t light = 0;
    glm::vec3 radiance{0.0f};
  };
  std::vector<ShRgb> FromSky(const std::function<SkyRay(const glm::vec3& direction)>& sky_ray,
                             std::size_t lights) const;

 private:
  static constexpr std::int32_t kDark = -2;
  struct Source {
    std::int32_t face;  // Or kSky, or kDark.
    std::uint32_t direction;
  };

  std::size_t points_;
  std::vector<glm::vec3> directions_;
  std::vector<std::array<float, kProbeShCoefficients>> weights_;  // Y times the solid angle.
  std::vector<Source> sources_;                                   // Per point, by face.
};

}  // namespace pleinair::internal
