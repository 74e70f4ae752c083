// The light around a place as a lat-long map: for other renderers, and to look at.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/survey/survey.h"
#include "relight/transport/patch_scene.h"
#include "scene/image.h"
#include "scene/lat_long.h"
#include "scene/lighting.h"
#include "scene/sky_shape.h"

namespace pleinair {

// The real scene under a unit of one basis light.
struct EnvironmentLight {
  const SkyShape* sky = nullptr;  // Null for the sun.
  std::span<const glm::vec3> face_radiosity;
  // For the sun: the irradiance of the faces by its disc, W/m2. Else empty.
  std::span<const glm::vec3> direct_irradiance;
};

// Each pixel is what the ray through its centre meets: the sky, or a real surface with the survey's
// albedo at the very place. The surface is in the sun where a ray from there reaches the disc's
// centre. Virtual objects are not in it.
//
// Threads  The result does not depend on their number.
class EnvironmentView {
 public:
  // Nothing; Radiance() gives an empty image.
  EnvironmentView() = default;
  // The view from `eye_m`. `survey` may be null: real surfaces then have their face's albedo. Keeps
  // a reference only to `real`. Throws std::invalid_argument for a size below 1.
  EnvironmentView(const PatchScene& real,
                  const Survey* survey,
                  const glm::vec3& eye_m,
                  LatLongSize size);

  // Without the sun's disc, W/(m2 sr). `basis`: the sun first, then the shapes of lighting.sky.
  // Throws std::invalid_argument where their numbers differ.
  RgbImage Radiance(const Lighting& lighting, std::span<const EnvironmentLight> basis) const;

  // Adds the disc where no real surface hides it. Each pixel gets the irradiance of its part of the
  // disc over its own solid angle. So the map holds the sun's irradiance whatever its size.
  void AddSun(const DirectionalLight& sun, RgbImage& radiance) const;

 private:
  struct Place {
    glm::vec3 start_m{0.0f};  // Off the surface.
    glm::vec3 tint{1.0f};     // Albedo there over the face's.
    std::int32_t face = PatchScene::kSky;
  };
  const PatchScene* real_ = nullptr;
  glm::vec3 eye_m_{0.0f};
  LatLongSize size_;
  std::vector<Place> places_;  // Per pixel.
};

}  // namespace pleinair
