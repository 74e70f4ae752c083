#include "relight/survey/survey_look_up.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <glm/geometric.hpp>

#include "relight/transport/same_plane.h"

namespace pleinair {

SurveyLookUp::SurveyLookUp(const Survey& survey)
    : origin_m_(survey.position_m), size_{survey.view.Width(), survey.view.Height()} {
  const SurfaceView& view = survey.view;
  texels_.reserve(view.region.pixels.size());
  for (std::size_t i = 0; i < view.region.pixels.size(); ++i) {
    texels_.push_back(
        {view.position_world_m.pixels[i],
         view.normal_world.pixels[i],
         view.albedo_rgb.pixels[i],
         view.edge_distance_px.pixels[i],
         view.albedo_measured.pixels[i] != 0 ? view.region.pixels[i] : SurfaceView::kNoRegion,
         view.may_be_sampled.pixels[i],
         0});
  }
  for (int y = 0; y < size_.height; ++y) {
    for (int x = 0; x < size_.width; ++x) {
      texels_[view.region.Index(x, y)].is_one_plane = IsOnePlane(x, y) ? 1 : 0;
    }
  }
}

const SurveyLookUp::Texel& SurveyLookUp::At(int x, int y) const {
  const int row = std::clamp(y, 0, size_.height - 1);
  const int column = x < 0 ? x + size_.width : x < size_.width ? x : x - size_.width;
  return texels_[static_cast<std::size_t>(row) * static_cast<std::size_t>(size_.width) +
                 static_cast<std::size_t>(column)];
}

bool SurveyLookUp::IsOnePlane(int left, int top) const {
  const Texel& first = At(left, top);
  const float range_m = glm::distance(first.position_m, origin_m_);
  const auto goes_on = [&](const Texel& other) {
    return other.region == first.region &&
           SamePlane(
               first.position_m, first.normal, other.position_m, other.normal, 0.5f * range_m);
  };
  return first.region != SurfaceView::kNoRegion && goes_on(At(left + 1, top)) &&
         goes_on(At(left, top + 1)) && goes_on(At(left + 1, top + 1));
}

std::optional<SurveyedPoint> SurveyLookUp::At(const glm::vec3& position_m,
                                              const glm::vec3& normal,
                                              std::int32_t region) const {
  const glm::vec3 towards = position_m - origin_m_;
  const float range_m = glm::length(towards);
  if (!(range_m > 0.0f) || region == SurfaceView::kNoRegion) return std::nullopt;
  // As LatLongFromDirection, from the middle of the first texel, in single precision: a ten
  // thousandth of a texel.
  const float horizontal_m = std::sqrt(towards.x * towards.x + towards.y * towards.y);
  const float turns = std::atan2(towards.x, towards.y) * (0.5f * std::numbers::inv_pi_v<float>);
  const float rise = std::atan2(towards.z, horizontal_m) * std::numbers::inv_pi_v<float>;
  const float u = (turns + 0.5f) * static_cast<float>(size_.width) - 0.5f;
  const float v = (0.5f - rise) * static_cast<float>(size_.height) - 0.5f;
  const float left = std::floor(u);
  const float top = std::floor(v);
  const glm::vec2 share(u - left, v - top);
  const int x = static_cast<int>(left);
  const int y = static_cast<int>(top);
  const Texel& first = At(x, y);
  const auto shows_it = [&](const Texel& texel) {
    return texel.region == region &&
           SamePlane(position_m, normal, texel.position_m, texel.normal, range_m);
  };
  // Then one texel speaks for all.
  const bool all_show_it = first.is_one_plane != 0 && shows_it(first);
  SurveyedPoint point;
  point.edge_distance_px = std::numeric_limits<float>::infinity();
  point.may_be_sampled = true;
  glm::vec3 sum(0.0f);
  float weights = 0.0f;
  for (int dy = 0; dy < 2; ++dy) {
    for (int dx = 0; dx < 2; ++dx) {
      const float weight =
          (dx == 0 ? 1.0f - share.x : share.x) * (dy == 0 ? 1.0f - share.y : share.y);
      if (!(weight > 0.0f)) continue;
      const Texel& texel = At(x + dx, y + dy);
      if (!all_show_it && !shows_it(texel)) {
        point.may_be_sampled = false;
        continue;
      }
      sum += weight * texel.albedo_rgb;
      weights += weight;
      point.may_be_sampled = point.may_be_sampled && texel.may_be_sampled != 0;
      point.edge_distance_px = std::min(point.edge_distance_px, texel.edge_distance_px);
    }
  }
  if (!(weights > 0.0f)) return std::nullopt;
  point.albedo_rgb = sum / weights;
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
  // Over the surface, of a map or a picture that sees it along `towards` from `range_m`.
  const auto area = [&](const glm::vec3& towards, float pixel_rad) {
    const float range_m = glm::length(towards);
    // Seen at less than 0.6 deg of slant a surface is edge-on: there the bound keeps this finite.
    const float cosine = std::max(std::abs(glm::dot(towards, normal)) / range_m, 1e-2f);
    const float across_m = range_m * pixel_rad;
    return across_m * across_m / cosine;
  };
  const float texel_rad = std::numbers::pi_v<float> / static_cast<float>(size_.height);
  return std::sqrt(area(position_m - origin_m_, texel_rad) /
                   area(position_m - view_origin_m, static_cast<float>(1.0 / focal_px)));
}

}  // namespace pleinair
