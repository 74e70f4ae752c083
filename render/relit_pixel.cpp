#include "render/relit_pixel.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/common.hpp>

#include "render/internal/median.h"
#include "render/real_sun.h"

namespace pleinair {
namespace {

constexpr float kInvPi = std::numbers::inv_pi_v<float>;

// Radiance for a unit of irradiance.
glm::vec3 ReflectedOf(const PixelInNewLight& pixel) {
  glm::vec3 seen(0.0f);
  for (int c = 0; c < 3; ++c) {
    if (!(pixel.camera[c] > 0.0f)) continue;
    const bool is_possible = pixel.camera[c] < kInvPi * pixel.irradiance_before[c];
    seen[c] = is_possible ? pixel.camera[c] / pixel.irradiance_before[c] : kInvPi;
  }
  const glm::vec3 model = kInvPi * glm::max(pixel.albedo, glm::vec3(kLeastAlbedo));
  const float sigma = pixel.albedo_measured ? kLogSigmaMeasured : kLogSigmaGuessed;
  return glm::min(
      seen, std::exp(kMostAlbedoSigmas * sigma) * std::min(Median(seen / model), 1.0f) * model);
}

}  // namespace

RelitRadiance Relit(const PixelInNewLight& pixel) {
  const glm::vec3& before = pixel.irradiance_before;
  const glm::vec3 added = pixel.irradiance_after - before;
  RelitRadiance relit{pixel.camera, false};
  bool is_brighter = false;
  for (int c = 0; c < 3; ++c) {
    if (!(std::abs(added[c]) > kLeastRelitChange * before[c])) continue;
    relit.is_changed = true;
    if (added[c] > 0.0f) {
      is_brighter = true;
      continue;
    }
    const float model = kInvPi * pixel.albedo[c] * before[c];
    const float without = pixel.clipped ? std::max(pixel.camera[c], model) : pixel.camera[c];
    relit.radiance[c] =
        std::min(without * (pixel.irradiance_after[c] / before[c]), pixel.camera[c]);
  }
  if (!is_brighter) return relit;
  const glm::vec3 reflected = ReflectedOf(pixel);
  for (int c = 0; c < 3; ++c) {
    if (added[c] > kLeastRelitChange * before[c]) relit.radiance[c] += reflected[c] * added[c];
  }
  return relit;
}

}  // namespace pleinair
