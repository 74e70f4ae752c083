#include "relight/volume/environment_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "relight/survey/survey_look_up.h"
#include "relight/transport/sun_disc.h"

namespace pleinair {
namespace {

// Points of the sun's disc: in a map of 2048 pixels a hundred fall into each that it covers.
constexpr int kEnvironmentDiscPoints = 1024;

}  // namespace

EnvironmentView::EnvironmentView(const PatchScene& real,
                                 const Survey* survey,
                                 const glm::vec3& eye_m,
                                 LatLongSize size)
    : real_(&real), eye_m_(eye_m), size_(size) {
  if (size.width < 1 || size.height < 1) {
    throw std::invalid_argument("environment: " + std::to_string(size.width) + "x" +
                                std::to_string(size.height) + " pixels: expected at least 1x1");
  }
  std::optional<SurveyLookUp> look_up;
  if (survey != nullptr) look_up.emplace(*survey);
  places_.resize(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
  tbb::parallel_for(0, size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      const glm::vec3 direction(DirectionFromLatLong({x + 0.5, y + 0.5}, size));
      const auto hit = real.caster.Intersect(eye_m, direction);
      if (!hit) continue;
      Place& place = places_[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) +
                             static_cast<std::size_t>(x)];
      const std::int32_t side = PatchScene::SideOfHit(*hit, direction);
      place.face = real.FaceOfSide(side);
      place.start_m =
          OffsetFromSurface(hit->position_m, real.SideNormal(static_cast<std::size_t>(side)));
      if (look_up) place.tint = look_up->TintOf(real, side, hit->position_m);
    }
  });
}

RgbImage EnvironmentView::Radiance(const Lighting& lighting,
                                   std::span<const EnvironmentLight> basis) const {
  if (places_.empty()) return {};
  if (basis.size() != 1 + lighting.sky.size()) {
    throw std::invalid_argument(
        "environment: " + std::to_string(basis.size()) + " basis lights: expected the sun and " +
        std::to_string(lighting.sky.size()) + " shapes of the sky, as the lighting has them");
  }
  const glm::vec3 to_sun(lighting.sun.direction_enu);
  RgbImage radiance(size_.width, size_.height, glm::vec3(0.0f));
  tbb::parallel_for(0, size_.height, [&](int y) {
    for (int x = 0; x < size_.width; ++x) {
      const std::size_t pixel = radiance.Index(x, y);
      const Place& place = places_[pixel];
      const glm::vec3 direction(DirectionFromLatLong({x + 0.5, y + 0.5}, size_));
      for (std::size_t light = 0; light < basis.size(); ++light) {
        const glm::vec3 intensity(light == 0 ? lighting.sun.irradiance_rgb
                                             : lighting.sky[light - 1].irradiance_rgb);
        if (intensity == glm::vec3(0.0f)) continue;
        const EnvironmentLight& of_unit = basis[light];
        if (place.face == PatchScene::kSky) {
          if (of_unit.sky != nullptr) {
            radiance.pixels[pixel] += intensity * of_unit.sky->Radiance(direction);
          }
          continue;
        }
        const auto face = static_cast<std::size_t>(place.face);
        const glm::vec3& albedo = real_->face_albedo_rgb[face];
        glm::vec3 radiosity = of_unit.face_radiosity[face];
        if (!of_unit.direct_irradiance.empty()) {
          radiosity =
              glm::max(radiosity - albedo * of_unit.direct_irradiance[face], glm::vec3(0.0f));
          const float cosine = glm::dot(real_->FaceNormal(face), to_sun);
          if (cosine > 0.0f && to_sun.z > 0.0f && !real_->caster.Occluded(place.start_m, to_sun)) {
            radiosity += albedo * cosine;
          }
        }
        radiance.pixels[pixel] +=
            intensity * place.tint * radiosity * std::numbers::inv_pi_v<float>;
      }
    }
  });
  return radiance;
}

void EnvironmentView::AddSun(const DirectionalLight& sun, RgbImage& radiance) const {
  if (places_.empty() || sun.irradiance_rgb == glm::dvec3(0.0)) return;
  const SunDisc disc(sun.direction_enu, sun.angular_radius_rad, kEnvironmentDiscPoints);
  for (const glm::vec3& direction : disc.Samples()) {
    if (!(direction.z > 0.0f) || real_->caster.Occluded(eye_m_, direction)) continue;
    const glm::ivec2 pixel = LatLongPixelFromDirection(glm::dvec3(direction), size_);
    radiance.At(pixel.x, pixel.y) += glm::vec3(
        sun.irradiance_rgb / (kEnvironmentDiscPoints * LatLongPixelSolidAngleSr(pixel.y, size_)));
  }
}

}  // namespace pleinair
