#include "render/real_sun.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "render/internal/median.h"
#include "render/internal/real_radiance.h"
#include "render/relit_pixel.h"

namespace pleinair {
namespace {

// Two predictions, and log odds of lit over shaded by a radiance of the pixel's own albedo.
class Predictions {
 public:
  explicit Predictions(const RealPixel& pixel)
      : floor_(glm::max(1e-6f * pixel.lit, glm::vec3(1e-30f))),
        shaded_(glm::max(pixel.shaded, floor_)),
        spread_(glm::log(glm::max(pixel.lit, floor_) / shaded_)),
        sigma_(pixel.albedo_measured ? kSharedLogSigmaMeasured : kSharedLogSigmaGuessed) {}

  float LogOdds(const glm::vec3& observed, bool clipped) const {
    glm::vec3 x = glm::log(glm::max(observed, floor_) / shaded_);
    // A clipped value is a lower bound: it may be as bright as lit.
    if (clipped) x = glm::max(x, spread_);
    return Median(spread_ * (2.0f * x - spread_)) / (2.0f * sigma_ * sigma_);
  }

 private:
  glm::vec3 floor_;
  glm::vec3 shaded_;
  glm::vec3 spread_;
  float sigma_;
};

}  // namespace

float SunSeenWithout(const RealPixel& pixel, const RealPicture& picture, int x_px, int y_px) {
  const SurfaceView& view = picture.view;
  const Predictions predictions(pixel);
  const float own = predictions.LogOdds(pixel.observed, pixel.clipped);
  const auto log_odds_at = [&](int dx, int dy) {
    const int x = x_px + dx;
    const int y = y_px + dy;
    if (x < 0 || y < 0 || x >= view.Width() || y >= view.Height()) return own;
    const std::size_t here = view.region.Index(x_px, y_px);
    const std::size_t there = view.region.Index(x, y);
    const glm::vec3 camera = picture.gain * picture.camera_radiance.pixels[there];
    const bool is_one_plane =
        glm::dot(view.normal_world.pixels[here], view.normal_world.pixels[there]) > kOnePlaneCosine;
    if (!is_one_plane || !IsKnownRadiance(camera)) return own;
    const glm::vec3 albedo = glm::max(view.albedo_rgb.pixels[here], glm::vec3(kLeastAlbedo));
    const glm::vec3 other = glm::max(view.albedo_rgb.pixels[there], glm::vec3(kLeastAlbedo));
    const bool is_clipped = !picture.clipped.Empty() && picture.clipped.pixels[there] != 0;
    return predictions.LogOdds(camera * (albedo / other), is_clipped);
  };
  const float model = pixel.model_visibility;
  const float trust = std::clamp(pixel.edge_distance_px / kTrustedEdgeDistancePx, 0.0f, 1.0f);
  const float of_mesh = (2.0f * model - 1.0f) * kMeshLogOdds * trust;
  const bool agrees_with_mesh = own * of_mesh > 0.0f && std::abs(own) > kMeshLogOdds;
  float log_odds = own;
  if (!agrees_with_mesh) {
    glm::vec3 of_rows;
    for (int row = 0; row < 3; ++row) {
      const int dy = (row - 1) * kAroundPx;
      of_rows[row] =
          Median({log_odds_at(-kAroundPx, dy), log_odds_at(0, dy), log_odds_at(kAroundPx, dy)});
    }
    log_odds = Median(of_rows);
  }
  if (log_odds + of_mesh <= 0.0f) return 0.0f;
  return model > 0.0f ? model : 1.0f;
}

}  // namespace pleinair
