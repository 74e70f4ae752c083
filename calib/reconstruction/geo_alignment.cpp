#include "calib/reconstruction/geo_alignment.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

namespace pleinair {
namespace {

// A horizontal vector: east + i north. Turning it by an angle is a product with exp(i angle).
using Plan = std::complex<double>;

Plan PlanOf(const glm::dvec3& v) { return {v.x, v.y}; }

struct PlanFit {
  Plan factor{1.0, 0.0};  // Scale and turn.
  Plan translation{0.0, 0.0};
  double spread = 0.0;  // Root of the weighted sum of squared distances from their mean; units.
  double sigma_m = 0.0;
  double rms_m = 0.0;
};

struct PlanPair {
  Plan model;
  Plan enu;
  double sigma_m;
};

PlanFit FitPlan(const std::vector<PlanPair>& pairs, std::optional<double> scale) {
  std::vector<double> weights(pairs.size(), 1.0);
  PlanFit fit;
  constexpr int kRounds = 30;
  for (int round = 0; round < kRounds; ++round) {
    double sum = 0.0;
    Plan model_mean = 0.0;
    Plan enu_mean = 0.0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      sum += weights[i];
      model_mean += weights[i] * pairs[i].model;
      enu_mean += weights[i] * pairs[i].enu;
    }
    model_mean /= sum;
    enu_mean /= sum;
    Plan product = 0.0;
    double squares = 0.0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const Plan model = pairs[i].model - model_mean;
      product += weights[i] * std::conj(model) * (pairs[i].enu - enu_mean);
      squares += weights[i] * std::norm(model);
    }
    fit.spread = std::sqrt(squares);
    if (squares > 0.0 && std::abs(product) > 0.0) {
      fit.factor = scale ? *scale * product / std::abs(product) : product / squares;
    } else {
      fit.factor = scale.value_or(1.0);
    }
    fit.translation = enu_mean - fit.factor * model_mean;
    double residuals = 0.0;
    double variances = 0.0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const double off = std::abs(fit.factor * pairs[i].model + fit.translation - pairs[i].enu);
      residuals += weights[i] * off * off;
      variances += weights[i] * pairs[i].sigma_m * pairs[i].sigma_m;
      constexpr double kCauchy = 2.4;
      weights[i] = 1.0 / (1.0 + std::pow(off / (kCauchy * pairs[i].sigma_m), 2.0));
    }
    fit.rms_m = std::sqrt(residuals / sum);
    // The stated errors of the receivers, or their residuals for each axis, whichever are larger.
    fit.sigma_m = std::max(std::sqrt(variances / sum), fit.rms_m / std::numbers::sqrt2);
  }
  return fit;
}

}  // namespace

GeoAlignment AlignToEarth(std::span<const GeoReading> readings, std::optional<double> scale) {
  constexpr double kNoNorthRad = std::numbers::pi;
  std::vector<PlanPair> pairs;
  Plan headings = 0.0;
  double heading_weights = 0.0;
  double heading_sigmas = 0.0;  // Weighted.
  for (const GeoReading& reading : readings) {
    if (reading.position_enu_m) {
      pairs.push_back(
          {PlanOf(reading.centre), PlanOf(*reading.position_enu_m), reading.position_sigma_m});
    }
    const Plan forward = PlanOf(reading.forward);
    if (reading.heading_rad && std::abs(forward) > 0.1) {
      // Azimuths run clockwise from north.
      const Plan stated = std::polar(1.0, 0.5 * std::numbers::pi - *reading.heading_rad);
      const double weight = 1.0 / (reading.heading_sigma_rad * reading.heading_sigma_rad);
      headings += weight * stated * std::conj(forward) / std::abs(forward);
      heading_weights += weight;
      heading_sigmas += weight * reading.heading_sigma_rad;
    }
  }

  GeoAlignment found;
  found.scale = scale.value_or(1.0);
  found.scale_sigma = scale ? 0.0 : std::numeric_limits<double>::infinity();
  found.turn_sigma_rad = kNoNorthRad;
  Plan turns = 0.0;
  double precision = 0.0;
  if (!pairs.empty()) {
    const PlanFit fit = FitPlan(pairs, scale);
    found.has_position = true;
    found.position_rms_m = fit.rms_m;
    const double length_m = fit.spread * std::abs(fit.factor);
    // The turn's deviation; the scale's, relative, is the same.
    const double sigma =
        length_m > 0.0 ? fit.sigma_m / length_m : std::numeric_limits<double>::infinity();
    if (sigma < 1.0) {
      found.turn_by_positions_rad = std::arg(fit.factor);
      turns += std::polar(1.0 / (sigma * sigma), std::arg(fit.factor));
      precision += 1.0 / (sigma * sigma);
      if (!scale) {
        found.scale = std::abs(fit.factor);
        found.scale_sigma = sigma;
      }
    }
  }
  if (std::abs(headings) > 0.0) {
    // One compass has the same errors in all pictures: they do not average out.
    const double sigma = heading_sigmas / heading_weights;
    const double weight = 1.0 / (sigma * sigma);
    found.turn_by_headings_rad = std::arg(headings);
    turns += std::polar(weight, std::arg(headings));
    precision += weight;
  }
  if (precision > 0.0) {
    found.turn_rad = std::arg(turns);
    found.turn_sigma_rad = std::min(1.0 / std::sqrt(precision), kNoNorthRad);
  }
  if (!pairs.empty()) {
    // Where the cameras' weighted mean is, with the turn and scale that are taken.
    Plan off = 0.0;
    double sum = 0.0;
    for (const PlanPair& pair : pairs) {
      const double weight = 1.0 / (pair.sigma_m * pair.sigma_m);
      off += weight * (pair.enu - std::polar(found.scale, found.turn_rad) * pair.model);
      sum += weight;
    }
    off /= sum;
    found.translation = {off.real(), off.imag(), 0.0};
  }
  return found;
}

}  // namespace pleinair
