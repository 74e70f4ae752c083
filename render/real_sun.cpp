#include "render/real_sun.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>

#include "render/internal/median.h"

namespace pleinair {
float SunSeenWithout(const RealPixel& pixel) {
  const glm::vec3 floor_value = glm::max(1e-6f * pixel.lit, glm::vec3(1e-30f));
  const glm::vec3 shaded = glm::max(pixel.shaded, floor_value);
  const glm::vec3 spread = glm::log(glm::max(pixel.lit, floor_value) / shaded);
  glm::vec3 x = glm::log(glm::max(pixel.observed, floor_value) / shaded);
  // A clipped value is a lower bound: it may be as bright as lit.
  if (pixel.clipped) x = glm::max(x, spread);
  const float sigma = pixel.albedo_measured ? kLogSigmaMeasured : kLogSigmaGuessed;
  float log_odds = Median(spread * (2.0f * x - spread)) / (2.0f * sigma * sigma);
  const float trust = std::clamp(pixel.edge_distance_px / kTrustedEdgeDistancePx, 0.0f, 1.0f);
  log_odds += (2.0f * pixel.model_visibility - 1.0f) * kMeshLogOdds * trust;
  if (log_odds <= 0.0f) return 0.0f;
  return pixel.model_visibility > 0.0f ? pixel.model_visibility : 1.0f;
}

}  // namespace pleinair
