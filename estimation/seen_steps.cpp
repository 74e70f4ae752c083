#include "estimation/seen_steps.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <glm/common.hpp>

#include "estimation/internal/square.h"

namespace pleinair {
namespace {

using estimation_internal::Square;

constexpr std::size_t kSun = 0;
constexpr std::size_t kSky = 1;

// A cloud that changes sun and sky alike to this, in logarithms, is rare.
constexpr double kAlike = 0.05;

bool MayBeExposure(const LightChange& change) {
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  const auto add = [&](double before, double after, double level) {
    constexpr double kNegligible = 0.02;  // Share of a light that shows nothing of a factor.
    if (before < kNegligible * level && after < kNegligible * level) return;
    const double factor = std::log(after / before);
    least = std::min(least, factor);
    most = std::max(most, factor);
  };
  for (int c = 0; c < 3; ++c) {
    const double level = std::max(change.sun_before_rgb[c] + change.sky_before_rgb[c],
                                  change.sun_after_rgb[c] + change.sky_after_rgb[c]);
    add(change.sun_before_rgb[c], change.sun_after_rgb[c], level);
    add(change.sky_before_rgb[c], change.sky_after_rgb[c], level);
  }
  return most - least <= kAlike;
}

}  // namespace

std::optional<SeenSteps> SeenStepsOf(const std::optional<LightChange>& change,
                                     LightUnits units,
                                     double sun_to_horizontal) {
  if (!change) return std::nullopt;
  const bool is_share = units == LightUnits::kRelativePerFrame;
  SeenSteps steps;
  for (int c = 0; c < 3; ++c) {
    const double sun = change->sun_after_rgb[c];
    const double sky = change->sky_after_rgb[c];
    const double now = is_share ? sun_to_horizontal * sun + sky : 1.0;
    const double before =
        is_share ? sun_to_horizontal * change->sun_before_rgb[c] + change->sky_before_rgb[c] : 1.0;
    if (!(now > 0.0) || !(before > 0.0)) return std::nullopt;
    steps[kSun].value[c] = sun / now - change->sun_before_rgb[c] / before;
    steps[kSky].value[c] = sky / now - change->sky_before_rgb[c] / before;
    // d(share) = (d(light) - share d(total)) / total.
    const double sun_share = is_share ? sun / now : 0.0;
    const double sky_share = is_share ? sky / now : 0.0;
    const auto variance = [&](double of_sun, double of_sky) {
      const double sum = Square(of_sun * change->sun_stddev_rgb[c]) +
                         Square(of_sky * change->sky_stddev_rgb[c]) +
                         2.0 * of_sun * of_sky * change->covariance_rgb[c];
      return std::max(0.0, sum) / Square(now);
    };
    steps[kSun].variance[c] = variance(1.0 - sun_share * sun_to_horizontal, -sun_share);
    steps[kSky].variance[c] = variance(-sky_share * sun_to_horizontal, 1.0 - sky_share);
  }
  const bool may_be_exposure = !is_share && MayBeExposure(*change);
  for (SeenStep& step : steps) step.may_be_exposure = may_be_exposure;
  return steps;
}

std::optional<SeenSteps> SumOf(const std::optional<SeenSteps>& first,
                               const std::optional<SeenSteps>& second) {
  if (!first || !second) return std::nullopt;
  SeenSteps sum = *second;
  for (const std::size_t light : {kSun, kSky}) {
    sum[light].value += (*first)[light].value;
    sum[light].variance = glm::max(sum[light].variance, (*first)[light].variance);
    sum[light].may_be_exposure = (*first)[light].may_be_exposure && sum[light].may_be_exposure;
  }
  return sum;
}

}  // namespace pleinair
