#include "render/real_sun.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "render/internal/median.h"
#include "render/internal/real_radiance.h"
#include "render/relit_pixel.h"

namespace pleinair {
namespace {

float Sum(const glm::vec3& radiance) { return radiance.r + radiance.g + radiance.b; }

// Two predictions, and where a radiance is between them. Bounds on the radiance take the place of
// logarithms for most of the radiances around a pixel.
class Predictions {
 public:
  // `mesh_log_odds` of lit over shaded.
  Predictions(const RealPixel& pixel, float mesh_log_odds)
      : mesh_log_odds_(mesh_log_odds),
        floor_(glm::max(1e-6f * pixel.lit, glm::vec3(1e-30f))),
        lit_(glm::max(pixel.lit, floor_)),
        surely_lit_(Sum(glm::mix(pixel.shaded, pixel.lit, kSurelyLit))),
        left_in_shade_(Sum(glm::max(pixel.shaded, floor_)) / Sum(lit_)) {
    const float sigma = pixel.albedo_measured ? kSharedLogSigmaMeasured : kSharedLogSigmaGuessed;
    const glm::vec3 shaded = glm::max(pixel.shaded, floor_);
    // Not the root of the product, which may leave the range of floats.
    const glm::vec3 middle = glm::sqrt(lit_) * glm::sqrt(shaded);
    const glm::vec3 spread = glm::log(lit_ / shaded);
    for (int c = 0; c < 3; ++c) {
      if (spread[c] > 0.0f) {
        // With s = l - d the log odds are s (2 x - l - d) / (2 sigma^2).
        const float even = -sigma * sigma * mesh_log_odds / spread[c];
        const float half = std::max(0.5f * spread[c] - kSurelySigmas * sigma, kLeastHalfBetween);
        from_[c] = middle[c] * std::exp(even - half);
        to_[c] = middle[c] * std::exp(even + half);
        per_log_[c] = 0.5f / half;
        const float sure = sigma * sigma * kMeshLogOdds / spread[c];
        agrees_from_[c] = mesh_log_odds > 0.0f ? std::max(to_[c], middle[c] * std::exp(sure))
                                               : std::min(from_[c], middle[c] * std::exp(-sure));
      } else {  // The mesh alone decides.
        from_[c] = to_[c] = agrees_from_[c] =
            mesh_log_odds > 0.0f ? 0.0f : std::numeric_limits<float>::infinity();
      }
    }
  }

  // Whether the radiance says what the mesh says, and as surely.
  bool AgreesWithMesh(const glm::vec3& observed, bool clipped) const {
    if (mesh_log_odds_ == 0.0f) return false;
    const glm::vec3 x = Bounded(observed, clipped);
    const int reached = static_cast<int>(x.r > agrees_from_.r) +
                        static_cast<int>(x.g > agrees_from_.g) +
                        static_cast<int>(x.b > agrees_from_.b);
    return (reached >= 2) == (mesh_log_odds_ > 0.0f);
  }
  // 0: in shade; 1: in the sun.
  float PlaceOf(const glm::vec3& observed, bool clipped) const {
    const glm::vec3 x = Bounded(observed, clipped);
    glm::vec3 place;
    for (int c = 0; c < 3; ++c) {
      if (x[c] <= from_[c]) {
        place[c] = 0.0f;
      } else if (x[c] >= to_[c]) {
        place[c] = 1.0f;
      } else {
        place[c] = std::log(x[c] / from_[c]) * per_log_[c];
      }
    }
    return Median(place);
  }
  // Of the sun, of which a new shadow leaves left_in_shade_^place.
  float ShareAt(float place) const {
    if (place <= 0.0f || place >= 1.0f || left_in_shade_ > kEvenLeft) return place;
    return (std::pow(left_in_shade_, -place) - 1.0f) / (1.0f / left_in_shade_ - 1.0f);
  }
  bool IsSurelyLit(const glm::vec3& observed) const { return !(Sum(observed) < surely_lit_); }

 private:
  // A clipped value is a lower bound: it may be as bright as lit.
  glm::vec3 Bounded(const glm::vec3& observed, bool clipped) const {
    return glm::max(observed, clipped ? lit_ : floor_);
  }

  float mesh_log_odds_;
  glm::vec3 floor_;
  glm::vec3 lit_;
  glm::vec3 from_{0.0f};
  glm::vec3 to_{0.0f};
  glm::vec3 per_log_{0.0f};
  glm::vec3 agrees_from_{0.0f};
  float surely_lit_;
  float left_in_shade_;
};

// Three rows of three pixels with the pixel itself in the middle.
using Around = std::array<std::array<float, 3>, 3>;

constexpr float kUnknown = -1.0f;  // Radiance of no pixel.

float MedianOf(float a, float b, float c) { return Median({a, b, c}); }
float RadianceOf(float a, float b, float c) {
  return std::min({a, b, c}) >= 0.0f ? MedianOf(a, b, c) : kUnknown;
}

bool IsStep(float one, float other) {
  return (one > 0.5f) != (other > 0.5f) && std::abs(one - other) >= kLeastEdgeStep;
}

template <class Of>
float OfRow(const Around& around, std::size_t k, const Of& of) {
  return of(around[k][0], around[k][1], around[k][2]);
}
template <class Of>
float OfColumn(const Around& around, std::size_t k, const Of& of) {
  return of(around[0][k], around[1][k], around[2][k]);
}

bool HasEdge(const Around& place) {
  return IsStep(OfColumn(place, 0, MedianOf), OfColumn(place, 2, MedianOf)) ||
         IsStep(OfRow(place, 0, MedianOf), OfRow(place, 2, MedianOf));
}

// Where one side of a pixel is in shade and the other in the sun: the pixel's share, from its own
// radiance between theirs. None where its radiance is that of one side, as at a crossing of joints.
std::optional<float> ShareAtEdge(const Around& place, const Around& radiance) {
  std::optional<float> share;
  float contrast = 0.0f;
  const auto compare = [&](float one_place, float one, float other_place, float other) {
    if (!IsStep(one_place, other_place) || one < 0.0f || other < 0.0f) return;
    const bool is_other_lit = other_place > one_place;
    const float shaded = is_other_lit ? one : other;
    const float lit = is_other_lit ? other : one;
    if (!(lit - shaded > contrast)) return;
    contrast = lit - shaded;
    share = std::clamp((radiance[1][1] - shaded) / contrast, 0.0f, 1.0f);
  };
  compare(OfColumn(place, 0, MedianOf),
          OfColumn(radiance, 0, RadianceOf),
          OfColumn(place, 2, MedianOf),
          OfColumn(radiance, 2, RadianceOf));
  compare(OfRow(place, 0, MedianOf),
          OfRow(radiance, 0, RadianceOf),
          OfRow(place, 2, MedianOf),
          OfRow(radiance, 2, RadianceOf));
  if (share && std::min(*share, 1.0f - *share) < kLeastEdgeShare) return std::nullopt;
  return share;
}

// The pixels around one, where they are of its plane and known.
class PixelsAround {
 public:
  PixelsAround(const RealPicture& picture, int x_px, int y_px)
      : picture_(picture), x_px_(x_px), y_px_(y_px), own_(picture.view.region.Index(x_px, y_px)) {}

  std::optional<std::size_t> At(int dx, int dy) const {
    const SurfaceView& view = picture_.view;
    const int x = x_px_ + dx;
    const int y = y_px_ + dy;
    if (x < 0 || y < 0 || x >= view.Width() || y >= view.Height()) return std::nullopt;
    const std::size_t there = view.region.Index(x, y);
    const bool is_one_plane =
        glm::dot(view.normal_world.pixels[own_], view.normal_world.pixels[there]) > kOnePlaneCosine;
    if (!is_one_plane || !IsKnownRadiance(CameraAt(there))) return std::nullopt;
    return there;
  }
  // The radiance there if the surface had the pixel's own albedo.
  glm::vec3 RadianceAt(std::size_t there) const {
    const std::vector<glm::vec3>& albedos = picture_.view.albedo_rgb.pixels;
    const glm::vec3 albedo = glm::max(albedos[own_], glm::vec3(kLeastAlbedo));
    const glm::vec3 other = glm::max(albedos[there], glm::vec3(kLeastAlbedo));
    return CameraAt(there) * (albedo / other);
  }
  bool IsClipped(std::size_t there) const {
    return !picture_.clipped.Empty() && picture_.clipped.pixels[there] != 0;
  }

 private:
  glm::vec3 CameraAt(std::size_t there) const {
    return picture_.gain * picture_.camera_radiance.pixels[there];
  }

  const RealPicture& picture_;
  int x_px_;
  int y_px_;
  std::size_t own_;
};

// `own` in the middle, and of the pixels around.
template <class ValueAt>
Around ValuesAround(float own, const ValueAt& value_at) {
  Around values{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      values[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] =
          row == 1 && column == 1 ? own : value_at((column - 1) * kAroundPx, (row - 1) * kAroundPx);
    }
  }
  return values;
}

struct Decision {
  float share = 0.0f;
  bool is_likelier_lit = false;
};

Decision Decide(const RealPixel& pixel, const RealPicture& picture, int x_px, int y_px) {
  const float model = pixel.model_visibility;
  const float sun = model > 0.0f ? model : 1.0f;
  const float trust = std::clamp(pixel.edge_distance_px / kTrustedEdgeDistancePx, 0.0f, 1.0f);
  const float of_mesh = (2.0f * model - 1.0f) * kMeshLogOdds * trust;
  const Predictions predictions(pixel, of_mesh);
  const bool agrees_with_mesh = predictions.AgreesWithMesh(pixel.observed, pixel.clipped);
  if (agrees_with_mesh) {
    if (of_mesh < 0.0f) return {0.0f, false};
    if (predictions.IsSurelyLit(pixel.observed)) return {sun, true};
  }
  const PixelsAround around(picture, x_px, y_px);
  const float own = predictions.PlaceOf(pixel.observed, pixel.clipped);
  const Around places = ValuesAround(own, [&](int dx, int dy) {
    const std::optional<std::size_t> there = around.At(dx, dy);
    return there ? predictions.PlaceOf(around.RadianceAt(*there), around.IsClipped(*there)) : own;
  });
  if (HasEdge(places)) {
    const Around radiance = ValuesAround(Sum(pixel.observed), [&](int dx, int dy) {
      const std::optional<std::size_t> there = around.At(dx, dy);
      return there ? Sum(around.RadianceAt(*there)) : kUnknown;
    });
    if (const auto share = ShareAtEdge(places, radiance)) return {*share, *share >= 0.5f};
  }
  if (agrees_with_mesh) return {sun, true};
  const float place =
      MedianOf(OfRow(places, 0, MedianOf), OfRow(places, 1, MedianOf), OfRow(places, 2, MedianOf));
  return {sun * predictions.ShareAt(place), place > 0.5f};
}

}  // namespace

float SunSeenWithout(const RealPixel& pixel, const RealPicture& picture, int x_px, int y_px) {
  return Decide(pixel, picture, x_px, y_px).share;
}

bool IsLikelierLit(const RealPixel& pixel, const RealPicture& picture, int x_px, int y_px) {
  return Decide(pixel, picture, x_px, y_px).is_likelier_lit;
}

}  // namespace pleinair
