#include "pipeline/internal/effects/real_pixels.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "pipeline/internal/effects/bound_terms.h"
#include "scene/is_finite.h"

namespace pleinair {

PixelLight LightOfPixel(const EffectFrame& frame, std::size_t pixel) {
  const SurfaceView& view = frame.view;
  const glm::vec3 sun = SunOf(frame.lighting);
  PixelLight light;
  light.indirect = sun * view.sun_bounce.pixels[pixel];
  for (std::size_t k = 0; k < view.sky_response.size(); ++k) {
    light.indirect +=
        glm::vec3(frame.lighting.sky[k].irradiance_rgb) * view.sky_response[k].pixels[pixel];
  }
  const glm::vec3 to_sun(frame.lighting.sun.direction_enu);
  light.direct = sun * std::max(glm::dot(view.normal_world.pixels[pixel], to_sun), 0.0f);
  return light;
}

float CodesBetween(const EffectFrame& frame,
                   std::size_t pixel,
                   const glm::vec3& radiance,
                   const glm::vec3& other) {
  if (frame.response.vignetting == 0.0) return frame.codes.Difference(radiance, other);
  const int width = frame.view.Width();
  const auto place = static_cast<int>(pixel);
  const LensCircle circle = LensCircle::Of(width, frame.view.Height());
  const double share = circle.ShareOfCorner({place % width + 0.5, place / width + 0.5});
  const auto kept = static_cast<float>(1.0 - frame.response.vignetting * share);
  return frame.codes.Difference(kept * radiance, kept * other);
}

bool IsClipped(const Frame& frame, std::size_t pixel) {
  return !frame.clipped.Empty() && frame.clipped.pixels[pixel] != 0;
}

RealPixel RealPixelOf(const EffectFrame& frame, std::size_t pixel, const PixelLight& light) {
  const SurfaceView& view = frame.view;
  const glm::vec3 to_radiance = kInvPi * view.albedo_rgb.pixels[pixel];
  RealPixel state;
  state.observed = frame.radiance.pixels[pixel];
  state.clipped = IsClipped(frame.frame, pixel);
  state.lit = to_radiance * (light.indirect + light.direct);
  state.shaded = to_radiance * light.indirect;
  state.model_visibility = view.sun_visibility.pixels[pixel];
  state.edge_distance_px = view.edge_distance_px.pixels[pixel];
  state.albedo_measured = view.albedo_measured.pixels[pixel] != 0;
  return state;
}

namespace {

// `decide` of real_sun.h for a pixel of the frame.
template <class Decide>
auto Of(const EffectFrame& frame, std::size_t pixel, const RealPixel& state, Decide&& decide) {
  const int width = frame.view.Width();
  const auto place = static_cast<int>(pixel);
  const RealPicture picture{frame.radiance, frame.frame.clipped, frame.view};
  return decide(state, picture, place % width, place / width);
}

}  // namespace

float SunSeenWithout(const EffectFrame& frame, std::size_t pixel, const RealPixel& state) {
  return Of(frame, pixel, state, [](auto&&... of) { return SunSeenWithout(of...); });
}

std::optional<bool> LooksSunlit(const EffectFrame& frame, std::size_t pixel) {
  if (frame.view.region.pixels[pixel] == SurfaceView::kNoRegion) return std::nullopt;
  if (!IsFinite(frame.radiance.pixels[pixel])) return std::nullopt;
  const RealPixel state = RealPixelOf(frame, pixel, LightOfPixel(frame, pixel));
  if (state.model_visibility < 0.5f) return std::nullopt;
  if (Of(frame, pixel, state, IsLikelierLit)) return true;
  // Deviations of the albedo by which a surface in shade may be darker than predicted.
  constexpr float kDarkerSigmas = 2.0f;
  constexpr float kTiny = 1e-30f;
  const glm::vec3 log_ratio = glm::log(glm::max(state.observed, glm::vec3(kTiny)) /
                                       glm::max(state.shaded, glm::vec3(kTiny)));
  const float sigma = state.albedo_measured ? kLogSigmaMeasured : kLogSigmaGuessed;
  if (log_ratio.g < -kDarkerSigmas * sigma) return std::nullopt;
  return false;
}

}  // namespace pleinair
