#include "estimation/internal/view_footprints.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "estimation/internal/lit_limits.h"
#include "scene/frame.h"
#include "scene/is_finite.h"

namespace pleinair::estimation_internal {
namespace {

// Along one side of a footprint; large ones are read sparsely.
constexpr int kReadsAcross = 7;
constexpr float kSamePlaneCosine = 0.99f;  // 8 degrees.
// Darker than soot: its radiance is glare and noise. Lighter than fresh snow: no diffuse surface.
constexpr float kLeastAlbedo = 0.02f;
constexpr float kLargestAlbedo = 0.95f;

int FacingOf(const glm::vec3& normal) {
  const glm::vec3 size = glm::abs(normal);
  if (size.z >= size.x && size.z >= size.y) return normal.z >= 0.0f ? 0 : 1;
  if (size.x >= size.y) return normal.x >= 0.0f ? 2 : 3;
  return normal.y >= 0.0f ? 4 : 5;
}

}  // namespace

std::optional<glm::ivec2> PixelAt(const glm::vec3& place_world_m,
                                  const Camera& camera,
                                  const Lens& lens) {
  const glm::dvec4 place_m(glm::dvec3(place_world_m), 1.0);
  const auto image_point = lens.ProjectToPixel(glm::dvec3(camera.camera_from_world * place_m));
  if (!image_point) return std::nullopt;
  const glm::ivec2 at(glm::round(*image_point));
  const bool is_inside = at.x >= 0 && at.y >= 0 && at.x < camera.intrinsics.width_px &&
                         at.y < camera.intrinsics.height_px;
  return is_inside ? std::optional(at) : std::nullopt;
}

ViewFootprints::ViewFootprints(const SurfaceView& view,
                               const glm::dvec3& sun_direction_enu,
                               const RgbImage& radiance,
                               const Gray8Image& unusable,
                               bool takes_grazing)
    : view_(view),
      sun_(sun_direction_enu),
      radiance_(radiance),
      unusable_(unusable),
      takes_grazing_(takes_grazing) {}

int ViewFootprints::PlaneAt(std::size_t pixel) const {
  return view_.region.pixels[pixel] * kFacings + FacingOf(view_.normal_world.pixels[pixel]);
}

std::optional<std::size_t> ViewFootprints::PixelOf(const SampleFootprint& footprint,
                                                   const Lens& lens) const {
  const glm::dvec3 place_m(footprint.place_world_m);
  const std::optional<glm::ivec2> at = PixelAt(footprint.place_world_m, view_.camera, lens);
  if (!at) return std::nullopt;
  const std::size_t pixel = view_.region.Index(at->x, at->y);
  if (view_.region.pixels[pixel] < 0 || PlaneAt(pixel) != footprint.plane) {
    return std::nullopt;
  }
  // Another surface of the same kind may occlude it. The pixel's own place is half a pixel away,
  // or more at a grazing view.
  constexpr double kLargestShift = 0.02;
  const glm::dvec3 shown_m(view_.position_world_m.pixels[pixel]);
  const double range_m = glm::distance(shown_m, view_.camera.CentreWorldM());
  const double height_m = glm::dot(glm::dvec3(view_.normal_world.pixels[pixel]), shown_m - place_m);
  if (!(std::abs(height_m) < 0.5 * kLargestShift * range_m) ||
      !(glm::distance(shown_m, place_m) < kLargestShift * range_m)) {
    return std::nullopt;
  }
  return pixel;
}

int ViewFootprints::RadiusAt(std::size_t pixel) const {
  // Past this a footprint is a good part of the picture, and an edge is always near.
  constexpr float kLargest = 64.0f;
  const float radius = view_.footprint_radius_px.pixels[pixel];
  if (!(radius <= kLargest)) return static_cast<int>(kLargest);
  return std::max(1, static_cast<int>(std::ceil(radius)));
}

bool ViewFootprints::IsCandidate(std::size_t pixel) {
  if (view_.may_be_sampled.pixels[pixel] == 0 || view_.region.pixels[pixel] < 0) return false;
  const float corner = static_cast<float>(RadiusAt(pixel)) * std::numbers::sqrt2_v<float>;
  if (!(view_.edge_distance_px.pixels[pixel] > corner + kEdgeMarginPx)) return false;
  const glm::vec3& albedo = view_.albedo_rgb.pixels[pixel];
  for (int c = 0; c < 3; ++c) {
    if (!(albedo[c] >= kLeastAlbedo && albedo[c] <= kLargestAlbedo)) return false;
  }
  if (JudgedAt(pixel) == JudgedSun::kGrazing) return false;
  const float visibility = SunVisibilityAt(pixel);
  if (visibility <= kFullyShaded) return true;
  const double cosine = glm::dot(glm::dvec3(view_.normal_world.pixels[pixel]), sun_);
  if (visibility >= kFullyLit && cosine <= 0.0) return true;
  if (cosine >= kLeastSunCosine) return visibility >= kFullyLit;
  // Of a sun that rises, too, a part of which is seen from everywhere.
  left_out_grazing_ = left_out_grazing_ || !takes_grazing_;
  return takes_grazing_;
}

JudgedSun ViewFootprints::JudgedAt(std::size_t pixel) const {
  return view_.judged_sun.pixels.empty() ? JudgedSun::kUnknown : view_.judged_sun.pixels[pixel];
}

float ViewFootprints::SunVisibilityAt(std::size_t pixel) const {
  switch (JudgedAt(pixel)) {
    case JudgedSun::kLit:
      return 1.0f;
    case JudgedSun::kShaded:
      return 0.0f;
    case JudgedSun::kUnknown:
    case JudgedSun::kGrazing:
      break;
  }
  return view_.sun_visibility.pixels[pixel];
}

bool ViewFootprints::IsLit(std::size_t pixel) const {
  return SunVisibilityAt(pixel) >= kFullyLit &&
         glm::dot(glm::dvec3(view_.normal_world.pixels[pixel]), sun_) > 0.0;
}

std::optional<SampleFootprint> ViewFootprints::Gather(std::size_t centre) {
  SampleFootprint footprint;
  const int width = view_.Width();
  footprint.x = static_cast<int>(centre % static_cast<std::size_t>(width));
  footprint.y = static_cast<int>(centre / static_cast<std::size_t>(width));
  footprint.radius = RadiusAt(centre);
  footprint.stride = std::max(1, (2 * footprint.radius + kReadsAcross - 1) / kReadsAcross);
  const auto region = view_.region.pixels[centre];
  const glm::vec3 normal = view_.normal_world.pixels[centre];
  const bool measured = view_.albedo_measured.pixels[centre] != 0;
  footprint.place_world_m = view_.position_world_m.pixels[centre];
  footprint.is_lit = IsLit(centre);
  int count = 0;
  for (int dy = -footprint.radius; dy <= footprint.radius; dy += footprint.stride) {
    for (int dx = -footprint.radius; dx <= footprint.radius; dx += footprint.stride) {
      const int x = footprint.x + dx;
      const int y = footprint.y + dy;
      if (!view_.region.Contains(x, y)) return std::nullopt;
      const std::size_t pixel = view_.region.Index(x, y);
      if (view_.region.pixels[pixel] != region || view_.may_be_sampled.pixels[pixel] == 0 ||
          !(glm::dot(view_.normal_world.pixels[pixel], normal) >= kSamePlaneCosine)) {
        return std::nullopt;
      }
      if ((unusable_.pixels[pixel] & kUnusable) != 0 || !IsFinite(radiance_.pixels[pixel])) {
        refused_unusable_ = true;
        return std::nullopt;
      }
      const glm::dvec3 reflectance = glm::dvec3(view_.albedo_rgb.pixels[pixel]) / std::numbers::pi;
      const glm::dvec3 sun_seen =
          glm::dvec3(view_.normal_world.pixels[pixel]) * double{SunVisibilityAt(pixel)};
      for (int c = 0; c < 3; ++c) {
        footprint.direct[static_cast<std::size_t>(c)] += reflectance[c] * sun_seen;
      }
      if (measured) footprint.measured_albedo += std::numbers::pi * reflectance;
      footprint.bounce += reflectance * glm::dvec3(view_.sun_bounce.pixels[pixel]);
      for (std::size_t k = 0; k < view_.sky_response.size(); ++k) {
        footprint.sky[k] += reflectance * glm::dvec3(view_.sky_response[k].pixels[pixel]);
      }
      ++count;
    }
  }
  const double share = 1.0 / count;
  for (glm::dvec3& direct : footprint.direct) direct *= share;
  footprint.bounce *= share;
  footprint.measured_albedo *= share;
  for (glm::dvec3& sky : footprint.sky) sky *= share;
  return footprint;
}

}  // namespace pleinair::estimation_internal
