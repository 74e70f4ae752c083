#include "pipeline/unproven_sun.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <iterator>

#include <glm/vec3.hpp>

#include "estimation/light_component.h"
#include "scene/weather.h"

namespace pleinair {
namespace {

// A wrong shadow counts as 1.5 times as bad as one that is missing. The climate alone has 0.53. A
// sun that is drawn stays until it is less likely than not, so that it does not come and go.
constexpr double kLeastProbability = 0.6;
constexpr double kLeastToStay = 0.5;
constexpr double kSunAmongBrokenClouds = 0.5;
constexpr std::chrono::hours kKeptFor{1};

double ProbabilityOfSun(const std::array<double, std::size(kAllWeathers)>& shares) {
  return shares[static_cast<std::size_t>(Weather::kClear)] +
         kSunAmongBrokenClouds * shares[static_cast<std::size_t>(Weather::kBroken)];
}

}  // namespace

Lighting LightWithoutSun(const Lighting& lighting) {
  Lighting without = lighting;
  without.sun.irradiance_rgb = glm::dvec3(0.0);
  if (!HasCovariance(lighting)) return without;
  const std::size_t side = SideOf(lighting);
  // Of row u with the sun of its channel.
  const auto covariance = [&](std::size_t u) {
    const std::size_t c = u % 3;
    const double common = lighting.common_stddev_rgb[static_cast<int>(c)];
    return lighting.covariance[u * side + c] -
           common * common * Component(lighting, u) * Component(lighting, c);
  };
  for (std::size_t u = 3; u < side; ++u) {
    const double variance = covariance(u % 3);
    // Less is what rounding leaves of the common factor.
    constexpr double kRounding = 1e-9;
    if (!(variance > kRounding * lighting.covariance[u % 3 * (side + 1)])) continue;
    double& sky = Component(without, u);
    sky = std::max(0.0, sky - covariance(u) / variance * Component(lighting, u % 3));
  }
  for (std::size_t u = 0; u < 3; ++u) ScaleDeviations(u, 0.0, without);
  return without;
}

std::optional<Lighting> UnprovenSun::Without(const LightingEstimate& estimate, bool is_held) {
  const Lighting& lighting = estimate.lighting;
  if (is_held) return is_drawn_without_ ? std::optional(LightWithoutSun(lighting)) : std::nullopt;
  std::optional<Lighting> without = WithoutUnlessHeld(estimate);
  is_drawn_without_ = without.has_value();
  return without;
}

std::optional<Lighting> UnprovenSun::WithoutUnlessHeld(const LightingEstimate& estimate) {
  const Lighting& lighting = estimate.lighting;
  if (!estimate.weather_shares || ModelMismatch(estimate)) return std::nullopt;
  if (LightIsKnown(lighting)) {
    last_known_ = lighting.time;
    return std::nullopt;
  }
  if (last_known_ && std::chrono::abs(lighting.time - *last_known_) <= kKeptFor) {
    return std::nullopt;
  }
  was_without_ = ProbabilityOfSun(*estimate.weather_shares) <
                 (was_without_ ? kLeastProbability : kLeastToStay);
  if (!was_without_) return std::nullopt;
  return LightWithoutSun(lighting);
}

}  // namespace pleinair
