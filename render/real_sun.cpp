#include "render/real_sun.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "render/internal/median.h"
#include "render/internal/real_radiance.h"
#include "render/relit_pixel.h"

namespace pleinair {
namespace {

float Sum(const glm::vec3& radiance) { return radiance.r + radiance.g + radiance.b; }

// A radiance of the pixel's albedo: log odds of lit over shaded, and a measure of its amount.
struct Level {
  static constexpr float kUnknown = -1.0f;
  float log_odds;
  float radiance;
};
// Unknown if one of them is.
Level MedianOf(const Level& a, const Level& b, const Level& c) {
  const bool are_known = std::min({a.radiance, b.radiance, c.radiance}) >= 0.0f;
  return {Median({a.log_odds, b.log_odds, c.log_odds}),
          are_known ? Median({a.radiance, b.radiance, c.radiance}) : Level::kUnknown};
}

// Two predictions, and the log odds between them.
class Predictions {
 public:
  explicit Predictions(const RealPixel& pixel)
      : floor_(glm::max(1e-6f * pixel.lit, glm::vec3(1e-30f))),
        shaded_(glm::max(pixel.shaded, floor_)),
        spread_(glm::log(glm::max(pixel.lit, floor_) / shaded_)),
        surely_lit_(Sum(glm::mix(pixel.shaded, pixel.lit, kSurelyLit))),
        sigma_(pixel.albedo_measured ? kSharedLogSigmaMeasured : kSharedLogSigmaGuessed) {}

  Level LevelOf(const glm::vec3& observed, bool clipped) const {
    glm::vec3 x = glm::log(glm::max(observed, floor_) / shaded_);
    // A clipped value is a lower bound: it may be as bright as lit.
    if (clipped) x = glm::max(x, spread_);
    return {Median(spread_ * (2.0f * x - spread_)) / (2.0f * sigma_ * sigma_), Sum(observed)};
  }
  bool IsHalfShaded(const Level& level) const {
    return level.log_odds > 0.0f && level.radiance < surely_lit_;
  }

 private:
  glm::vec3 floor_;
  glm::vec3 shaded_;
  glm::vec3 spread_;
  float surely_lit_;
  float sigma_;
};

// Where one side of a pixel is in shade and the other in the sun, the pixel's share by its own
// radiance between theirs; none where it is as one of them, as at a crossing of joints. `around`
// has rows of three, [1][1] is the pixel.
std::optional<float> ShareAtEdge(const std::array<std::array<Level, 3>, 3>& around, float of_mesh) {
  std::optional<float> share;
  float contrast = 0.0f;
  const auto compare = [&](const Level& one, const Level& other) {
    if (one.radiance < 0.0f || other.radiance < 0.0f) return;
    const bool is_one_shaded = one.log_odds + of_mesh <= 0.0f;
    if (is_one_shaded == (other.log_odds + of_mesh <= 0.0f)) return;
    const float shaded = is_one_shaded ? one.radiance : other.radiance;
    const float lit = is_one_shaded ? other.radiance : one.radiance;
    if (!(lit - shaded > contrast)) return;
    contrast = lit - shaded;
    share = std::clamp((around[1][1].radiance - shaded) / contrast, 0.0f, 1.0f);
  };
  const auto& [above, middle, below] = around;
  compare(MedianOf(above[0], middle[0], below[0]), MedianOf(above[2], middle[2], below[2]));
  compare(MedianOf(above[0], above[1], above[2]), MedianOf(below[0], below[1], below[2]));
  if (share && std::min(*share, 1.0f - *share) < kLeastEdgeShare) return std::nullopt;
  return share;
}

}  // namespace

float SunSeenWithout(const RealPixel& pixel, const RealPicture& picture, int x_px, int y_px) {
  const SurfaceView& view = picture.view;
  const Predictions predictions(pixel);
  const Level own = predictions.LevelOf(pixel.observed, pixel.clipped);
  const Level unknown{own.log_odds, Level::kUnknown};
  const auto level_at = [&](int dx, int dy) {
    const int x = x_px + dx;
    const int y = y_px + dy;
    if (x < 0 || y < 0 || x >= view.Width() || y >= view.Height()) return unknown;
    const std::size_t here = view.region.Index(x_px, y_px);
    const std::size_t there = view.region.Index(x, y);
    const glm::vec3 camera = picture.gain * picture.camera_radiance.pixels[there];
    const bool is_one_plane =
        glm::dot(view.normal_world.pixels[here], view.normal_world.pixels[there]) > kOnePlaneCosine;
    if (!is_one_plane || !IsKnownRadiance(camera)) return unknown;
    const glm::vec3 albedo = glm::max(view.albedo_rgb.pixels[here], glm::vec3(kLeastAlbedo));
    const glm::vec3 other = glm::max(view.albedo_rgb.pixels[there], glm::vec3(kLeastAlbedo));
    const bool is_clipped = !picture.clipped.Empty() && picture.clipped.pixels[there] != 0;
    return predictions.LevelOf(camera * (albedo / other), is_clipped);
  };
  const float model = pixel.model_visibility;
  const float trust = std::clamp(pixel.edge_distance_px / kTrustedEdgeDistancePx, 0.0f, 1.0f);
  const float of_mesh = (2.0f * model - 1.0f) * kMeshLogOdds * trust;
  float log_odds = own.log_odds;
  const bool agrees_with_mesh = log_odds * of_mesh > 0.0f && std::abs(log_odds) > kMeshLogOdds;
  if (!agrees_with_mesh || predictions.IsHalfShaded(own)) {
    std::array<std::array<Level, 3>, 3> around;
    glm::vec3 of_rows;
    for (int row = 0; row < 3; ++row) {
      const int dy = (row - 1) * kAroundPx;
      auto& levels = around[static_cast<std::size_t>(row)];
      levels = {level_at(-kAroundPx, dy), level_at(0, dy), level_at(kAroundPx, dy)};
      of_rows[row] = MedianOf(levels[0], levels[1], levels[2]).log_odds;
    }
    if (const std::optional<float> share = ShareAtEdge(around, of_mesh)) return *share;
    if (!agrees_with_mesh) log_odds = Median(of_rows);
  }
  if (log_odds + of_mesh <= 0.0f) return 0.0f;
  return model > 0.0f ? model : 1.0f;
}

}  // namespace pleinair
