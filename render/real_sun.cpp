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

bool MostOf(bool a, bool b, bool c) { return a ? b || c : b && c; }

// Two predictions. Only comparisons of log odds decide, so a bound on the radiance takes the place
// of a logarithm for each of the radiances around a pixel.
class Predictions {
 public:
  explicit Predictions(const RealPixel& pixel)
      : floor_(glm::max(1e-6f * pixel.lit, glm::vec3(1e-30f))),
        lit_(glm::max(pixel.lit, floor_)),
        surely_lit_(Sum(glm::mix(pixel.shaded, pixel.lit, kSurelyLit))),
        sigma_(pixel.albedo_measured ? kSharedLogSigmaMeasured : kSharedLogSigmaGuessed) {
    const glm::vec3 shaded = glm::max(pixel.shaded, floor_);
    spread_ = glm::log(lit_ / shaded);
    // Not the root of the product, which may leave the range of floats.
    middle_ = glm::sqrt(lit_) * glm::sqrt(shaded);
  }

  // Radiances whose log odds are `log_odds`:
  //   s (2 x - s) = 2 sigma^2 log_odds  gives  x = s / 2 + sigma^2 log_odds / s,  s = l - d.
  glm::vec3 WithLogOdds(float log_odds) const {
    glm::vec3 bound;
    for (int c = 0; c < 3; ++c) {
      if (spread_[c] > 0.0f) {
        bound[c] = middle_[c] * std::exp(sigma_ * sigma_ * log_odds / spread_[c]);
      } else {  // Every radiance has log odds of 0.
        bound[c] = log_odds >= 0.0f ? std::numeric_limits<float>::infinity() : 0.0f;
      }
    }
    return bound;
  }

  // Whether the log odds, the median of three, are those of `bound` or less.
  bool IsUpTo(const glm::vec3& bound, const glm::vec3& observed, bool clipped) const {
    glm::vec3 x = glm::max(observed, floor_);
    // A clipped value is a lower bound: it may be as bright as lit.
    if (clipped) x = glm::max(x, lit_);
    return MostOf(x.r <= bound.r, x.g <= bound.g, x.b <= bound.b);
  }
  bool IsSurelyLit(const glm::vec3& observed) const { return !(Sum(observed) < surely_lit_); }

 private:
  glm::vec3 floor_;
  glm::vec3 lit_;
  glm::vec3 spread_;
  glm::vec3 middle_;
  float surely_lit_;
  float sigma_;
};

// Three rows of three pixels with the pixel itself in the middle.
template <typename Value>
using Around = std::array<std::array<Value, 3>, 3>;

constexpr float kUnknown = -1.0f;  // Radiance of no pixel.

float MedianOf(float a, float b, float c) {
  return std::min({a, b, c}) >= 0.0f ? Median({a, b, c}) : kUnknown;
}

bool HasEdge(const Around<bool>& is_shaded) {
  const auto& [above, middle, below] = is_shaded;
  return MostOf(above[0], middle[0], below[0]) != MostOf(above[2], middle[2], below[2]) ||
         MostOf(above[0], above[1], above[2]) != MostOf(below[0], below[1], below[2]);
}

// Where one side of a pixel is in shade and the other in the sun: the pixel's share, from its own
// radiance between theirs. None where its radiance is that of one side, as at a crossing of joints.
std::optional<float> ShareAtEdge(const Around<bool>& is_shaded, const Around<float>& radiance) {
  std::optional<float> share;
  float contrast = 0.0f;
  const auto compare = [&](bool is_one_shaded, float one, bool is_other_shaded, float other) {
    if (is_one_shaded == is_other_shaded || one < 0.0f || other < 0.0f) return;
    const float shaded = is_one_shaded ? one : other;
    const float lit = is_one_shaded ? other : one;
    if (!(lit - shaded > contrast)) return;
    contrast = lit - shaded;
    share = std::clamp((radiance[1][1] - shaded) / contrast, 0.0f, 1.0f);
  };
  const auto row = [](const auto& of, const auto& three, std::size_t k) {
    return three(of[k][0], of[k][1], of[k][2]);
  };
  const auto column = [](const auto& of, const auto& three, std::size_t k) {
    return three(of[0][k], of[1][k], of[2][k]);
  };
  compare(column(is_shaded, MostOf, 0),
          column(radiance, MedianOf, 0),
          column(is_shaded, MostOf, 2),
          column(radiance, MedianOf, 2));
  compare(row(is_shaded, MostOf, 0),
          row(radiance, MedianOf, 0),
          row(is_shaded, MostOf, 2),
          row(radiance, MedianOf, 2));
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
template <typename Value, typename ValueAt>
Around<Value> ValuesAround(Value own, const ValueAt& value_at) {
  Around<Value> values{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      values[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] =
          row == 1 && column == 1 ? own : value_at((column - 1) * kAroundPx, (row - 1) * kAroundPx);
    }
  }
  return values;
}

}  // namespace

float SunSeenWithout(const RealPixel& pixel, const RealPicture& picture, int x_px, int y_px) {
  const Predictions predictions(pixel);
  const float model = pixel.model_visibility;
  const float sun = model > 0.0f ? model : 1.0f;
  const float trust = std::clamp(pixel.edge_distance_px / kTrustedEdgeDistancePx, 0.0f, 1.0f);
  const float of_mesh = (2.0f * model - 1.0f) * kMeshLogOdds * trust;
  bool agrees_with_mesh = false;
  if (of_mesh != 0.0f) {
    const glm::vec3 sure = predictions.WithLogOdds(std::copysign(kMeshLogOdds, of_mesh));
    agrees_with_mesh = predictions.IsUpTo(sure, pixel.observed, pixel.clipped) == (of_mesh < 0.0f);
  }
  if (agrees_with_mesh) {
    if (of_mesh < 0.0f) return 0.0f;
    if (predictions.IsSurelyLit(pixel.observed)) return sun;
  }
  const PixelsAround around(picture, x_px, y_px);
  const glm::vec3 even = predictions.WithLogOdds(-of_mesh);
  const bool is_own_shaded = predictions.IsUpTo(even, pixel.observed, pixel.clipped);
  const Around<bool> is_shaded = ValuesAround(is_own_shaded, [&](int dx, int dy) {
    const std::optional<std::size_t> there = around.At(dx, dy);
    if (!there) return is_own_shaded;
    return predictions.IsUpTo(even, around.RadianceAt(*there), around.IsClipped(*there));
  });
  if (HasEdge(is_shaded)) {
    const Around<float> radiance = ValuesAround(Sum(pixel.observed), [&](int dx, int dy) {
      const std::optional<std::size_t> there = around.At(dx, dy);
      return there ? Sum(around.RadianceAt(*there)) : kUnknown;
    });
    if (const std::optional<float> share = ShareAtEdge(is_shaded, radiance)) return *share;
  }
  if (agrees_with_mesh) return sun;
  const auto most_of_row = [](const std::array<bool, 3>& row) {
    return MostOf(row[0], row[1], row[2]);
  };
  const bool is_in_shade =
      MostOf(most_of_row(is_shaded[0]), most_of_row(is_shaded[1]), most_of_row(is_shaded[2]));
  return is_in_shade ? 0.0f : sun;
}

}  // namespace pleinair
