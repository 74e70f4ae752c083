#include "datasets/lighting_score.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "scene/angle_between.h"
#include "scene/lighting.h"

namespace pleinair {
namespace {

// Requirements on an estimate where sun and sky cannot be distinguished.
constexpr double kMaxErrorSigmas = 3.0;
constexpr double kMaxStddevOfClearBeam = 0.4;

// Share of the largest true sun below which the ratio of sun to sky is noise.
constexpr double kLeastSunOfARatio = 0.05;

// Between an estimated ratio and the true one: from here on there is as good as none.
constexpr double kLargestFactor = 100.0;

std::optional<double> ColourAngleRad(const glm::dvec3& a, const glm::dvec3& b) {
  if (!(glm::length(a) > 0.0) || !(glm::length(b) > 0.0)) return std::nullopt;
  return AngleBetweenRad(a, b);
}

glm::dvec3 InSigmas(const glm::dvec3& error, const glm::dvec3& stddev) {
  glm::dvec3 sigmas;
  for (int c = 0; c < 3; ++c) {
    sigmas[c] = stddev[c] > 0.0  ? error[c] / stddev[c]
                : error[c] > 0.0 ? std::numeric_limits<double>::infinity()
                                 : 0.0;
  }
  return sigmas;
}

std::optional<double> SunToSkyError(const RecordedLight& estimate,
                                    const TruthFrame& truth,
                                    double largest_true_sun) {
  if (!estimate.sun_irradiance_rgb || !estimate.sky_irradiance_rgb) return std::nullopt;
  if (!(MeanOf(truth.sun_irradiance_rgb) >= kLeastSunOfARatio * largest_true_sun)) {
    return std::nullopt;
  }
  double error = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double sky = (*estimate.sky_irradiance_rgb)[c] * truth.sun_irradiance_rgb[c];
    if (!(sky > 0.0)) return std::nullopt;
    error += std::abs((*estimate.sun_irradiance_rgb)[c] * truth.sky_irradiance_rgb[c] / sky - 1.0);
  }
  return error / 3.0;
}

double Largest(const glm::dvec3& v) { return std::max({v.x, v.y, v.z}); }

template <typename Value>
std::vector<Value> Known(const std::vector<LightScore>& scores,
                         std::optional<Value> LightScore::*member) {
  std::vector<Value> values;
  for (const LightScore& score : scores) {
    if (score.*member) values.push_back(*(score.*member));
  }
  return values;
}

std::optional<SigmaCoverage> CoverageOf(const std::vector<glm::dvec3>& errors_in_sigmas) {
  if (errors_in_sigmas.empty()) return std::nullopt;
  SigmaCoverage coverage;
  for (const glm::dvec3& sigmas : errors_in_sigmas) {
    for (int c = 0; c < 3; ++c) {
      ++coverage.count;
      coverage.within_1 += sigmas[c] <= 1.0 ? 1.0 : 0.0;
      coverage.within_2 += sigmas[c] <= 2.0 ? 1.0 : 0.0;
    }
  }
  coverage.within_1 /= coverage.count;
  coverage.within_2 /= coverage.count;
  return coverage;
}

}  // namespace

std::optional<bool> LightScore::SaysWhatItDoesNotKnow() const {
  if (!sun_error_sigmas || !sky_error_sigmas || !sun_stddev_of_clear_beam ||
      !sky_stddev_of_clear_beam) {
    return std::nullopt;
  }
  return Largest(*sun_error_sigmas) <= kMaxErrorSigmas &&
         Largest(*sky_error_sigmas) <= kMaxErrorSigmas &&
         *sun_stddev_of_clear_beam <= kMaxStddevOfClearBeam &&
         *sky_stddev_of_clear_beam <= kMaxStddevOfClearBeam;
}

double LargestTrueSun(const std::vector<TruthFrame>& truth) {
  double largest = 0.0;
  for (const TruthFrame& frame : truth) {
    largest = std::max(largest, MeanOf(frame.sun_irradiance_rgb));
  }
  return largest;
}

std::optional<LightScore> ScoreLight(const RecordedLight& estimate,
                                     const TruthFrame& truth,
                                     double largest_true_sun,
                                     const glm::dvec3& clear_beam_rgb) {
  if (!estimate.sun_irradiance_rgb && !estimate.sky_irradiance_rgb) return std::nullopt;
  LightScore score;
  const double clear_beam = MeanOf(clear_beam_rgb);
  const bool is_absolute = estimate.units == LightUnits::kAbsolute;
  if (is_absolute && estimate.sun_irradiance_rgb) {
    const glm::dvec3 error = glm::abs(*estimate.sun_irradiance_rgb - truth.sun_irradiance_rgb);
    if (largest_true_sun > 0.0) score.sun_error = MeanOf(error) / largest_true_sun;
    score.sun_colour_angle_rad =
        ColourAngleRad(*estimate.sun_irradiance_rgb, truth.sun_irradiance_rgb);
    if (const auto& stddev = estimate.sun_irradiance_stddev_rgb) {
      score.sun_error_sigmas = InSigmas(error, *stddev);
      if (clear_beam > 0.0) score.sun_stddev_of_clear_beam = MeanOf(*stddev) / clear_beam;
    }
  }
  if (is_absolute && estimate.sky_irradiance_rgb) {
    const glm::dvec3 error = glm::abs(*estimate.sky_irradiance_rgb - truth.sky_irradiance_rgb);
    const double true_sky = MeanOf(truth.sky_irradiance_rgb);
    if (true_sky > 0.0) score.sky_error = MeanOf(error) / true_sky;
    score.sky_colour_angle_rad =
        ColourAngleRad(*estimate.sky_irradiance_rgb, truth.sky_irradiance_rgb);
    if (const auto& stddev = estimate.sky_irradiance_stddev_rgb) {
      score.sky_error_sigmas = InSigmas(error, *stddev);
      if (clear_beam > 0.0) score.sky_stddev_of_clear_beam = MeanOf(*stddev) / clear_beam;
    }
  }
  score.sun_to_sky_error = SunToSkyError(estimate, truth, largest_true_sun);
  if (estimate.sun_direction_enu) {
    score.sun_direction_error_rad =
        AngleBetweenRad(*estimate.sun_direction_enu, truth.sun_direction_enu);
  }
  return score;
}

std::optional<glm::dvec3> LogSunOverSkyError(const RecordedLight& estimate,
                                             const TruthFrame& truth,
                                             double largest_true_sun) {
  if (!estimate.sun_irradiance_rgb || !estimate.sky_irradiance_rgb) return std::nullopt;
  if (!(MeanOf(truth.sun_irradiance_rgb) >= kLeastSunOfARatio * largest_true_sun)) {
    return std::nullopt;
  }
  glm::dvec3 error;
  for (int c = 0; c < 3; ++c) {
    const double estimated = (*estimate.sun_irradiance_rgb)[c] * truth.sky_irradiance_rgb[c];
    const double expected = (*estimate.sky_irradiance_rgb)[c] * truth.sun_irradiance_rgb[c];
    if (!(std::max(estimated, expected) > 0.0)) return std::nullopt;
    error[c] = std::min(std::abs(std::log(estimated / expected)), std::log(kLargestFactor));
  }
  return error;
}

LightSummary SummariseLight(const std::vector<LightScore>& scores) {
  LightSummary summary;
  summary.frames = static_cast<int>(scores.size());
  summary.sun_error = DistributionOf(Known(scores, &LightScore::sun_error));
  summary.sky_error = DistributionOf(Known(scores, &LightScore::sky_error));
  summary.sun_to_sky_error = DistributionOf(Known(scores, &LightScore::sun_to_sky_error));
  summary.sun_colour_angle_rad = DistributionOf(Known(scores, &LightScore::sun_colour_angle_rad));
  summary.sky_colour_angle_rad = DistributionOf(Known(scores, &LightScore::sky_colour_angle_rad));
  summary.sun_direction_error_rad =
      DistributionOf(Known(scores, &LightScore::sun_direction_error_rad));
  summary.sun_sigma = CoverageOf(Known(scores, &LightScore::sun_error_sigmas));
  summary.sky_sigma = CoverageOf(Known(scores, &LightScore::sky_error_sigmas));
  for (const LightScore& score : scores) {
    const std::optional<bool> says = score.SaysWhatItDoesNotKnow();
    summary.with_stddev += says ? 1 : 0;
    summary.says_what_it_does_not_know += says.value_or(false) ? 1 : 0;
  }
  return summary;
}

}  // namespace pleinair
