#include "estimation/fading_light.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "estimation/internal/seconds_between.h"
#include "estimation/light_component.h"

namespace pleinair {
namespace {

using estimation_internal::SecondsBetween;

// A change of less than this share of a light is no cloud; it fades with this time constant.
constexpr double kCreep = 0.03;
constexpr double kFadingS = 0.2;
// So does, with this one, what surfaces in common do not show: the errors of other surfaces, of a
// tenth of a light and more, which at thirty frames a second are then below its noise.
constexpr double kFadingOfUnseenS = 1.0;
// The deviations by which a change that is followed at once may differ from what is seen. Creep
// fades whatever they are.
constexpr double kFollowedSigmas = 1.0;

// Of a change of the mean the share that surfaces in common may have shown, by channel.
glm::dvec3 SeenShare(const glm::dvec3& change, const SeenStep& seen, double sigmas) {
  glm::dvec3 share(0.0);
  for (int c = 0; c < 3; ++c) {
    if (change[c] == 0.0) continue;
    const double reach =
        std::max(sigmas * std::sqrt(seen.variance[c]), kSeenAgreement * std::abs(seen.value[c]));
    const double followed = std::clamp(change[c], seen.value[c] - reach, seen.value[c] + reach);
    share[c] = std::clamp(followed / change[c], 0.0, 1.0);
  }
  return share;
}

}  // namespace

double SunToHorizontal(const Lighting& lighting) {
  return std::max(0.0, lighting.sun.direction_enu.z);
}

void GiveTotalOf(const Lighting& raw, Lighting& lighting) {
  const auto total = [](const Lighting& light) {
    return SunToHorizontal(light) * light.sun.irradiance_rgb + light.SkyIrradianceRgb();
  };
  const glm::dvec3 wanted = total(raw);
  const glm::dvec3 found = total(lighting);
  for (std::size_t u = 0; u < SideOf(lighting); ++u) {
    const auto c = static_cast<int>(u % 3);
    if (!(found[c] > 0.0)) continue;
    const double factor = wanted[c] / found[c];
    Component(lighting, u) *= factor;
    ScaleDeviations(u, factor, lighting);
  }
}

glm::dvec3 UnitOf(const Lighting& lighting, LightUnits units) {
  glm::dvec3 unit(1.0);
  if (units != LightUnits::kRelativePerFrame) return unit;
  const glm::dvec3 total =
      SunToHorizontal(lighting) * lighting.sun.irradiance_rgb + lighting.SkyIrradianceRgb();
  for (int c = 0; c < 3; ++c) unit[c] = total[c] > 0.0 ? total[c] : 1.0;
  return unit;
}

void FadingLight::Add(LightUnits units,
                      const std::array<RunEnding, 2>& endings,
                      Lighting& lighting,
                      const Lighting& raw) {
  const std::size_t side = SideOf(lighting);
  const glm::dvec3 unit = UnitOf(raw, units);
  const auto unit_of = [&unit](std::size_t u) { return unit[static_cast<int>(u % 3)]; };
  const bool has_reported = !reported_.empty();
  const double elapsed_s =
      has_reported ? std::max(0.0, SecondsBetween(reported_time_, lighting.time)) : 0.0;
  fading_.resize(side, 0.0);
  for (std::size_t light = 0; light < endings.size(); ++light) {
    const std::size_t begin = light == 0 ? 0 : 3;
    const std::size_t end = light == 0 ? 3 : side;
    if (endings[light].has_ended && has_reported) {
      glm::dvec3 change(0.0);
      double level = 0.0;
      for (std::size_t u = begin; u < end; ++u) {
        fading_[u] = reported_[u] - Component(lighting, u) / unit_of(u);
        change[static_cast<int>(u % 3)] -= fading_[u];
        level += reported_[u];
      }
      const std::optional<SeenStep>& seen = endings[light].seen;
      const bool is_creep = std::abs(change.x + change.y + change.z) <= kCreep * level;
      const glm::dvec3 share = seen ? SeenShare(change, *seen, is_creep ? 0.0 : kFollowedSigmas)
                                    : glm::dvec3(is_creep ? 0.0 : 1.0);
      for (std::size_t u = begin; u < end; ++u) fading_[u] *= 1.0 - share[static_cast<int>(u % 3)];
      fading_s_[light] = seen ? kFadingOfUnseenS : kFadingS;
    }
    const double left = has_reported ? std::exp(-elapsed_s / fading_s_[light]) : 0.0;
    for (std::size_t u = begin; u < end; ++u) {
      fading_[u] *= left;
      double& component = Component(lighting, u);
      component = std::max(0.0, component + unit_of(u) * fading_[u]);
    }
    for (std::size_t u = begin; u < end && HasCovariance(lighting); ++u) {
      for (std::size_t v = begin; v < end; ++v) {
        lighting.covariance[u * side + v] += unit_of(u) * fading_[u] * unit_of(v) * fading_[v];
      }
    }
  }
  if (units == LightUnits::kRelativePerFrame) GiveTotalOf(raw, lighting);
  reported_time_ = lighting.time;
  reported_.resize(side);
  for (std::size_t u = 0; u < side; ++u) reported_[u] = Component(lighting, u) / unit_of(u);
}

}  // namespace pleinair
