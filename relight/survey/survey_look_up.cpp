#include "relight/survey/survey_look_up.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <glm/geometric.hpp>

#include "relight/transport/same_plane.h"

namespace pleinair {
namespace {

// Means over 16 pixels a side: enough for the most that a pixel of a view is taken to cover.
constexpr std::size_t kMostLevels = 4;

// To float's rounding, in a third of the library's time: Abramowitz and Stegun, "Handbook of
// Mathematical Functions", 4.4.49. 0 for two zeros.
float FastAtan2(float y, float x) {
  const float across = std::abs(x);
  const float up = std::abs(y);
  const float longer = std::max(across, up);
  if (!(longer > 0.0f)) return 0.0f;
  const float slope = std::min(across, up) / longer;
  const float square = slope * slope;
  float series = 0.0028662257f;
  for (const float coefficient : {-0.0161657367f,
                                  0.0429096138f,
                                  -0.0752896400f,
                                  0.1065626393f,
                                  -0.1420889944f,
                                  0.1999355085f,
                                  -0.3333314528f,
                                  1.0f}) {
    series = series * square + coefficient;
  }
  float angle_rad = slope * series;
  if (up > across) angle_rad = 0.5f * std::numbers::pi_v<float> - angle_rad;
  if (x < 0.0f) angle_rad = std::numbers::pi_v<float> - angle_rad;
  return std::copysign(angle_rad, y);
}

// Floor of a place in a map, which is more than -1.
int FloorOfPlace(float place) { return static_cast<int>(place + 1.0f) - 1; }

}  // namespace

SurveyLookUp::SurveyLookUp(const Survey& survey)
    : albedo_rgb_(survey.view.albedo_rgb.pixels),
      origin_m_(survey.position_m),
      size_{survey.view.Width(), survey.view.Height()} {
  const SurfaceView& view = survey.view;
  texels_.reserve(view.region.pixels.size());
  for (std::size_t i = 0; i < view.region.pixels.size(); ++i) {
    Texel texel{};
    texel.position_m = view.position_world_m.pixels[i];
    texel.normal = view.normal_world.pixels[i];
    texel.edge_distance_px = view.edge_distance_px.pixels[i];
    texel.region =
        view.albedo_measured.pixels[i] != 0 ? view.region.pixels[i] : SurfaceView::kNoRegion;
    texel.may_be_sampled = view.may_be_sampled.pixels[i];
    texel.is_in_unmodelled_shade =
        survey.unmodelled_shade.Empty() ? 0 : survey.unmodelled_shade.pixels[i];
    texels_.push_back(texel);
  }
  for (int y = 0; y < size_.height; ++y) {
    for (int x = 0; x < size_.width; ++x) DescribeCell(x, y);
  }
  while (levels_.size() < kMostLevels) AddLevel();
}

std::size_t SurveyLookUp::Index(const LatLongSize& size, int x, int y) {
  const int row = std::clamp(y, 0, size.height - 1);
  const int column = x < 0 ? x + size.width : x < size.width ? x : x - size.width;
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(size.width) +
         static_cast<std::size_t>(column);
}

const SurveyLookUp::Texel& SurveyLookUp::NearestTexel(const glm::vec2& place) const {
  return texels_[Index(FloorOfPlace(place.x + 0.5f), FloorOfPlace(place.y + 0.5f))];
}

void SurveyLookUp::AddLevel() {
  const int step = 2 << levels_.size();
  const LatLongSize finer_size = levels_.empty() ? size_ : levels_.back().size;
  Level level{{finer_size.width / 2, finer_size.height / 2}, {}, {}};
  for (int y = 0; y < level.size.height; ++y) {
    for (int x = 0; x < level.size.width; ++x) {
      const Texel& first = texels_[Index(step * x, step * y)];
      const float range_m = glm::distance(first.position_m, origin_m_);
      bool is_one_plane = true;
      glm::vec3 sum(0.0f);
      for (const int dy : {0, 1}) {
        for (const int dx : {0, 1}) {
          const std::size_t finer = Index(finer_size, 2 * x + dx, 2 * y + dy);
          const Texel& texel = texels_[Index(step * x + dx * step / 2, step * y + dy * step / 2)];
          is_one_plane = is_one_plane && first.region != SurfaceView::kNoRegion &&
                         (levels_.empty() || levels_.back().is_one_plane[finer] != 0) &&
                         Shows(texel, first.position_m, first.normal, first.region, range_m);
          sum += levels_.empty() ? albedo_rgb_[finer] : levels_.back().albedo_rgb[finer];
        }
      }
      level.albedo_rgb.push_back(0.25f * sum);
      level.is_one_plane.push_back(is_one_plane ? 1 : 0);
    }
  }
  levels_.push_back(std::move(level));
}

void SurveyLookUp::DescribeCell(int left, int top) {
  Texel& first = texels_[Index(left, top)];
  first.cell_edge_distance_px = first.edge_distance_px;
  first.cell_may_be_sampled = first.may_be_sampled;
  bool is_one_plane = first.region != SurfaceView::kNoRegion;
  const float range_m = glm::distance(first.position_m, origin_m_);
  for (const std::size_t next :
       {Index(left + 1, top), Index(left, top + 1), Index(left + 1, top + 1)}) {
    const Texel& other = texels_[next];
    is_one_plane =
        is_one_plane && Shows(other, first.position_m, first.normal, first.region, 0.5f * range_m);
    first.cell_edge_distance_px = std::min(first.cell_edge_distance_px, other.edge_distance_px);
    first.cell_may_be_sampled &= other.may_be_sampled;
  }
  first.cell_is_one_plane = is_one_plane ? 1 : 0;
}

bool SurveyLookUp::Shows(const Texel& texel,
                         const glm::vec3& position_m,
                         const glm::vec3& normal,
                         std::int32_t region,
                         float range_m) {
  return texel.region == region &&
         SamePlane(position_m, normal, texel.position_m, texel.normal, range_m);
}

glm::vec2 SurveyLookUp::PlaceOf(const glm::vec3& position_m) const {
  const glm::vec3 towards = position_m - origin_m_;
  // As LatLongFromDirection, from the middle of the first texel, in single precision: a ten
  // thousandth of a texel.
  const float horizontal_m = std::sqrt(towards.x * towards.x + towards.y * towards.y);
  const float turns = FastAtan2(towards.x, towards.y) * (0.5f * std::numbers::inv_pi_v<float>);
  const float rise = FastAtan2(towards.z, horizontal_m) * std::numbers::inv_pi_v<float>;
  return {(turns + 0.5f) * static_cast<float>(size_.width) - 0.5f,
          (0.5f - rise) * static_cast<float>(size_.height) - 0.5f};
}

std::optional<SurveyedPoint> SurveyLookUp::At(const glm::vec2& place,
                                              const glm::vec3& position_m,
                                              const glm::vec3& normal,
                                              std::int32_t region) const {
  const float range_m = glm::distance(position_m, origin_m_);
  if (!(range_m > 0.0f) || region == SurfaceView::kNoRegion) return std::nullopt;
  const int x = FloorOfPlace(place.x);
  const int y = FloorOfPlace(place.y);
  const glm::vec2 share(place.x - static_cast<float>(x), place.y - static_cast<float>(y));
  const std::array<std::size_t, 4> texels = {
      Index(x, y), Index(x + 1, y), Index(x, y + 1), Index(x + 1, y + 1)};
  const std::array<float, 4> weights = {(1.0f - share.x) * (1.0f - share.y),
                                        share.x * (1.0f - share.y),
                                        (1.0f - share.x) * share.y,
                                        share.x * share.y};
  const Texel& first = texels_[texels[0]];
  if (first.cell_is_one_plane != 0 && Shows(first, position_m, normal, region, range_m)) {
    return SurveyedPoint{weights[0] * albedo_rgb_[texels[0]] + weights[1] * albedo_rgb_[texels[1]] +
                             weights[2] * albedo_rgb_[texels[2]] +
                             weights[3] * albedo_rgb_[texels[3]],
                         first.cell_edge_distance_px,
                         first.cell_may_be_sampled != 0};
  }
  SurveyedPoint point;
  point.edge_distance_px = std::numeric_limits<float>::infinity();
  point.may_be_sampled = true;
  glm::vec3 sum(0.0f);
  float shown = 0.0f;
  for (std::size_t k = 0; k < texels.size(); ++k) {
    if (!(weights[k] > 0.0f)) continue;
    const Texel& texel = texels_[texels[k]];
    if (!Shows(texel, position_m, normal, region, range_m)) {
      point.may_be_sampled = false;
      continue;
    }
    sum += weights[k] * albedo_rgb_[texels[k]];
    shown += weights[k];
    point.may_be_sampled = point.may_be_sampled && texel.may_be_sampled != 0;
    point.edge_distance_px = std::min(point.edge_distance_px, texel.edge_distance_px);
  }
  if (!(shown > 0.0f)) return std::nullopt;
  point.albedo_rgb = sum / shown;
  return point;
}

std::optional<glm::vec3> SurveyLookUp::MeanAlbedo(const glm::vec2& place,
                                                  float side_px,
                                                  const glm::vec3& position_m,
                                                  const glm::vec3& normal,
                                                  std::int32_t region) const {
  // A blend of four is a mean over two a side.
  int level = 0;
  for (float side = 2.0f * std::numbers::sqrt2_v<float>; side < side_px; side *= 2.0f) ++level;
  if (level > static_cast<int>(levels_.size()) || region == SurfaceView::kNoRegion) {
    return std::nullopt;
  }
  const float range_m = glm::distance(position_m, origin_m_);
  const LatLongSize& size = level > 0 ? levels_[static_cast<std::size_t>(level) - 1].size : size_;
  const int step = 1 << level;
  // Middles of texels are at whole numbers, here as in the map.
  const glm::vec2 at = (place + 0.5f) / static_cast<float>(step) - 0.5f;
  const glm::ivec2 lower(FloorOfPlace(at.x), FloorOfPlace(at.y));
  const glm::vec2 share = at - glm::vec2(lower);
  glm::vec3 sum(0.0f);
  for (const int dy : {0, 1}) {
    for (const int dx : {0, 1}) {
      const int x = lower.x + dx;
      const int y = lower.y + dy;
      const std::size_t texel = Index(size, x, y);
      const auto row = static_cast<int>(texel / static_cast<std::size_t>(size.width));
      const auto column = static_cast<int>(texel % static_cast<std::size_t>(size.width));
      const bool is_one_plane =
          level == 0 || levels_[static_cast<std::size_t>(level) - 1].is_one_plane[texel] != 0;
      if (!is_one_plane ||
          !Shows(texels_[Index(step * column, step * row)], position_m, normal, region, range_m)) {
        return std::nullopt;
      }
      const float weight =
          (dx == 0 ? 1.0f - share.x : share.x) * (dy == 0 ? 1.0f - share.y : share.y);
      sum += weight * (level == 0 ? albedo_rgb_[texel]
                                  : levels_[static_cast<std::size_t>(level) - 1].albedo_rgb[texel]);
    }
  }
  return sum;
}

glm::vec3 SurveyLookUp::TintOf(const PatchScene& real,
                               std::int32_t side,
                               const glm::vec3& position_m) const {
  // Below this an albedo's ratio to another says nothing.
  constexpr float kLeastAlbedo = 1e-3f;
  const auto of_triangle = static_cast<std::size_t>(side);
  const auto region = static_cast<std::int32_t>(real.mesh.triangle_group[of_triangle / 2]);
  const auto surveyed = At(position_m, real.SideNormal(of_triangle), region);
  if (!surveyed) return glm::vec3(1.0f);
  // The model has the sun there, which the face's albedo, too dark, makes up for.
  if (NearestTexel(PlaceOf(position_m)).is_in_unmodelled_shade != 0) return glm::vec3(1.0f);
  return surveyed->albedo_rgb /
         glm::max(real.face_albedo_rgb[static_cast<std::size_t>(real.FaceOfSide(side))],
                  glm::vec3(kLeastAlbedo));
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
