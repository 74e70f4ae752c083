#include "relight/volume/internal/probe_rays.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "scene/lat_long.h"
#include "scene/surface_view.h"

namespace pleinair::internal {
namespace {

// Normals of one surface: mesh facets of a curved wall differ by less than this, a wall and the
// ground before it by more (cos 37 deg).
constexpr double kLeastNormalAgreement = 0.8;

// How far off the plane of what the pixel shows a point may lie, in texels. The plane is known to
// float accuracy, so this is for facets of curved surfaces; a step or a sill is taller.
constexpr double kPlaneToleranceTexels = 1.0;

// A point in a pixel is at most 0.71 texel from its centre across the line of sight, here doubled
// for the map's azimuth stretch near the poles. Along a surface seen at a slant it is stretched by
// the inverse cosine. Beyond ten times the pixel says less of the point than its patch does.
constexpr double kDistanceToleranceTexels = 1.5;
constexpr double kLeastSlantCosine = 0.1;

LatLongSize MapSize(const Survey& survey) { return {survey.view.Width(), survey.view.Height()}; }

// Angle that the wider side of a pixel spans at the map's equator.
double TexelRad(LatLongSize size) {
  return std::max(std::numbers::pi / size.height, 2.0 * std::numbers::pi / size.width);
}

}  // namespace

std::optional<std::uint32_t> SurveyPixelOfSurface(const Survey& survey,
                                                  const glm::vec3& position_m,
                                                  const glm::vec3& normal) {
  const SurfaceView& view = survey.view;
  const LatLongSize size = MapSize(survey);
  const glm::dvec3 line_of_sight = glm::dvec3(position_m) - survey.position_m;
  const double range_m = glm::length(line_of_sight);
  if (!(range_m > 0.0)) return std::nullopt;

  const glm::ivec2 xy = LatLongPixelFromDirection(line_of_sight, size);
  const std::size_t pixel = view.region.Index(xy.x, xy.y);
  if (view.region.pixels[pixel] == SurfaceView::kNoRegion) return std::nullopt;
  if (view.albedo_measured.pixels[pixel] == 0) return std::nullopt;
  // The model has the sun there, which the face's albedo, too dark, makes up for.
  if (!survey.unmodelled_shade.Empty() && survey.unmodelled_shade.pixels[pixel] != 0) {
    return std::nullopt;
  }

  const glm::dvec3 shown_normal(view.normal_world.pixels[pixel]);
  if (!(glm::dot(shown_normal, glm::dvec3(normal)) >= kLeastNormalAgreement)) return std::nullopt;
  const glm::dvec3 apart = glm::dvec3(position_m) - glm::dvec3(view.position_world_m.pixels[pixel]);
  const double texel_m = TexelRad(size) * range_m;
  if (!(std::abs(glm::dot(apart, shown_normal)) <= kPlaneToleranceTexels * texel_m)) {
    return std::nullopt;
  }
  const double slant_cosine =
      std::max(kLeastSlantCosine, std::abs(glm::dot(shown_normal, line_of_sight)) / range_m);
  if (!(glm::length(apart) <= kDistanceToleranceTexels * texel_m / slant_cosine)) {
    return std::nullopt;
  }
  return static_cast<std::uint32_t>(pixel);
}

std::optional<std::uint32_t> SurveyPixelOfSky(const Survey& survey, const glm::vec3& direction) {
  const LatLongSize size = MapSize(survey);
  const glm::ivec2 xy = LatLongPixelFromDirection(glm::dvec3(direction), size);
  // In a map of odd height one row has its centres on the horizon, where a sky shape may be 0.
  if (2 * xy.y + 1 >= size.height) return std::nullopt;
  const std::size_t pixel = survey.view.region.Index(xy.x, xy.y);
  if (survey.view.region.pixels[pixel] != SurfaceView::kNoRegion) return std::nullopt;
  return static_cast<std::uint32_t>(pixel);
}

RayCounts ProbeRays::Cast(const glm::vec3& origin_m, std::span<std::uint32_t> sources) const {
  RayCounts counts;
  for (std::size_t ray = 0; ray < directions_.size(); ++ray) {
    const glm::vec3& direction = directions_[ray];
    const auto hit = scene_.caster.Intersect(origin_m, direction);
    std::optional<std::uint32_t> pixel;
    if (hit) {
      const bool back = glm::dot(hit->geometric_normal, direction) > 0.0f;
      ++(back ? counts.back : counts.front);
      const glm::vec3 normal = back ? -hit->geometric_normal : hit->geometric_normal;
      if (survey_ != nullptr) pixel = SurveyPixelOfSurface(*survey_, hit->position_m, normal);
      const auto face = static_cast<std::uint32_t>(scene_.FaceOfHit(*hit, direction));
      sources[ray] = pixel ? *pixel : layout_.pixels + face;
    } else if (direction.z > 0.0f) {
      ++counts.sky;
      if (survey_ != nullptr) pixel = SurveyPixelOfSky(*survey_, direction);
      // The directions go from the zenith down: those of the sky are the first ones.
      sources[ray] =
          pixel ? *pixel : layout_.pixels + layout_.faces + static_cast<std::uint32_t>(ray);
    } else {
      sources[ray] = SourceLayout::kDark;
    }
  }
  return counts;
}

}  // namespace pleinair::internal
