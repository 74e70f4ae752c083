#include "objects/frame_basis.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/angle_between.h"

namespace pleinair {
namespace {

glm::vec3 LargestOf(std::span<const glm::vec3> values) {
  glm::vec3 largest(0.0f);
  for (const glm::vec3& value : values) largest = glm::max(largest, value);
  return largest;
}

// pi times the brightest radiance.
glm::vec3 LargestSkyIrradiance(const SkyShape& shape) {
  constexpr float kPi = std::numbers::pi_v<float>;
  if (const std::vector<glm::vec3>* table = shape.Table()) return kPi * LargestOf(*table);
  // A smooth shape is asked every 2 degrees or so. The steepest known, a clear sky beside the sun,
  // falls by 5 % in a degree.
  constexpr std::size_t kStep = 16;
  constexpr float kMargin = 1.1f;
  glm::vec3 largest(0.0f);
  for (std::size_t cell = 0; cell < SkyTable::kCells; cell += kStep + 1) {
    largest = glm::max(largest, shape.Radiance(glm::vec3(SkyTable::DirectionOfCell(cell))));
  }
  return kPi * kMargin * largest;
}

}  // namespace

void FrameBasis::Update(SurfaceViewBuilder& builder,
                        const DirectionalLight& sun,
                        const DirectionalLight& bounce_sun) {
  builder_ = &builder;
  const std::span<const std::shared_ptr<const SkyShape>> shapes = builder.SkyShapes();
  const std::size_t lights = 1 + shapes.size();
  const auto same_kind = [](const auto& a, const auto& b) {
    return a == b || a->Name() == b->Name();
  };
  if (!std::equal(shapes.begin(), shapes.end(), shapes_.begin(), shapes_.end(), same_kind)) {
    light_ids_.clear();
    shapes_.clear();
    order_id_ = StateId::Next();
  }
  const bool is_first = light_ids_.empty();
  light_ids_.resize(lights);
  largest_.resize(lights);
  const bool new_sun = is_first || sun_faces_id_ != builder.SunFacesId();
  sky_is_new_alone_ = false;
  for (std::size_t light = 0; light < lights; ++light) {
    const bool is_new =
        light == 0 ? new_sun
                   : is_first || light > shapes_.size() || shapes_[light - 1] != shapes[light - 1];
    if (!is_new) continue;
    sky_is_new_alone_ = sky_is_new_alone_ || !new_sun;
    light_ids_[light] = StateId::Next();
    const FaceLight& faces = light == 0 ? builder.SunFaces() : builder.SkyFaces(light - 1);
    largest_[light] = LargestOf(faces.radiosity);
    if (light > 0) {
      largest_[light] = glm::max(largest_[light], LargestSkyIrradiance(*shapes[light - 1]));
    }
  }
  sun_faces_id_ = builder.SunFacesId();
  shapes_.assign(shapes.begin(), shapes.end());
  sun_ = sun;
  bounce_sun_ = bounce_sun;
}

const std::vector<glm::vec3>& FrameBasis::FaceRadiosity(std::size_t light) const {
  return light == 0 ? builder_->SunFaces().radiosity : builder_->SkyFaces(light - 1).radiosity;
}

const std::vector<glm::vec3>& FrameBasis::DirectIrradiance() const {
  return builder_->SunFaces().direct_irradiance;
}

glm::vec3 IntensityOf(const Lighting& lighting, std::size_t light) {
  return glm::vec3(light == 0 ? lighting.sun.irradiance_rgb
                              : lighting.sky[light - 1].irradiance_rgb);
}

Lighting UnitOf(std::size_t light, std::size_t count) {
  Lighting unit;
  unit.sky.resize(count - 1);
  (light == 0 ? unit.sun.irradiance_rgb : unit.sky[light - 1].irradiance_rgb) = glm::dvec3(1.0);
  return unit;
}

std::vector<std::size_t> LightsDone::StaleIn(const FrameBasis& basis,
                                             const Lighting& lighting,
                                             Refresh refresh) const {
  std::vector<std::size_t> stale;
  for (std::size_t light = 0; light < basis.LightCount(); ++light) {
    if (IsCurrent(basis, light) || IntensityOf(lighting, light) == glm::vec3(0.0f)) continue;
    if (refresh == Refresh::kMissing && Ever(basis, light)) continue;
    stale.push_back(light);
  }
  return stale;
}

double LightsDone::SunMotionRad(const FrameBasis& basis, const Lighting& lighting) const {
  const glm::dvec3& now = basis.BounceSun().direction_enu;
  double largest = 0.0;
  for (const std::size_t light : StaleIn(basis, lighting)) {
    if (!Ever(basis, light)) continue;
    largest = std::max(largest, AngleBetweenRad(made_[light].sun_direction_enu, now));
  }
  return largest;
}

}  // namespace pleinair
