#include "relight/survey/survey_look_up.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <glm/geometric.hpp>

#include "relight/transport/same_plane.h"

namespace pleinair {

SurveyLookUp::SurveyLookUp(const Survey& survey)
    : view_(survey.view),
      origin_m_(survey.position_m),
      size_{survey.view.Width(), survey.view.Height()} {}

std::optional<SurveyedPoint> SurveyLookUp::At(const glm::vec3& position_m,
                                              const glm::vec3& normal,
                                              std::int32_t region) const {
  const glm::dvec3 towards = glm::dvec3(position_m) - origin_m_;
  const float range_m = static_cast<float>(glm::length(towards));
  if (!(range_m > 0.0f)) return std::nullopt;
  const glm::dvec2 uv_px = LatLongFromDirection(towards, size_);
  const int left = static_cast<int>(std::floor(uv_px.x - 0.5));
  const int top = static_cast<int>(std::floor(uv_px.y - 0.5));
  const double fx = uv_px.x - 0.5 - left;
  const double fy = uv_px.y - 0.5 - top;
  SurveyedPoint point;
  point.edge_distance_px = std::numeric_limits<float>::infinity();
  point.may_be_sampled = true;
  glm::dvec3 sum(0.0);
  double weights = 0.0;
  for (int dy = 0; dy < 2; ++dy) {
    for (int dx = 0; dx < 2; ++dx) {
      const double weight = (dx == 0 ? 1.0 - fx : fx) * (dy == 0 ? 1.0 - fy : fy);
      if (!(weight > 0.0)) continue;
      const int x = (left + dx + size_.width) % size_.width;
      const int y = std::clamp(top + dy, 0, size_.height - 1);
      const std::size_t texel = view_.region.Index(x, y);
      if (view_.region.pixels[texel] != region || view_.albedo_measured.pixels[texel] == 0 ||
          !SamePlane(position_m,
                     normal,
                     view_.position_world_m.pixels[texel],
                     view_.normal_world.pixels[texel],
                     range_m)) {
        point.may_be_sampled = false;
        continue;
      }
      sum += weight * glm::dvec3(view_.albedo_rgb.pixels[texel]);
      weights += weight;
      point.may_be_sampled = point.may_be_sampled && view_.may_be_sampled.pixels[texel] != 0;
      point.edge_distance_px =
          std::min(point.edge_distance_px, view_.edge_distance_px.pixels[texel]);
    }
  }
  if (!(weights > 0.0)) return std::nullopt;
  point.albedo_rgb = glm::vec3(sum / weights);
  return point;
}

glm::vec3 SurveyLookUp::TintOf(const PatchScene& real,
                               std::size_t face,
                               const glm::vec3& position_m) const {
  // Below this an albedo's ratio to another says nothing.
  constexpr float kLeastAlbedo = 1e-3f;
  const auto region = static_cast<std::int32_t>(real.mesh.triangle_group[face / 2]);
  const auto surveyed = At(position_m, real.FaceNormal(face), region);
  if (!surveyed) return glm::vec3(1.0f);
  return surveyed->albedo_rgb / glm::max(real.face_albedo_rgb[face], glm::vec3(kLeastAlbedo));
}

float SurveyLookUp::TexelSidePx(const glm::vec3& position_m,
                                const glm::vec3& normal,
                                const glm::vec3& view_origin_m,
                                double focal_px) const {
  const double texel_rad = std::numbers::pi / size_.height;
  const auto side = [&](const glm::dvec3& origin_m, double pixel_rad) {
    const glm::dvec3 towards = glm::dvec3(position_m) - origin_m;
    const double range_m = glm::length(towards);
    // Seen at less than 0.6 deg of slant a surface is edge-on: there the bound keeps this finite.
    const double cosine = std::max(std::abs(glm::dot(towards, glm::dvec3(normal))) / range_m, 1e-2);
    return range_m * pixel_rad / std::sqrt(cosine);
  };
  return static_cast<float>(side(origin_m_, texel_rad) /
                            side(glm::dvec3(view_origin_m), 1.0 / focal_px));
}

}  // namespace pleinair
