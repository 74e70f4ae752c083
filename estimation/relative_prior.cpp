#include "estimation/relative_prior.h"

namespace pleinair {
namespace {

constexpr double kSigma = kSunPriorSigma * 2.0 / 3.0;  // As of an absolute clear sky, at its mean.

}  // namespace

void UseRelativeClearSky(const RoughLight& rough, LightingPrior& prior) {
  const double weight = prior.sun_to_sky_weight;
  prior.sun_to_sky_weight = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double ratio = prior.sun_to_sky_rgb[c];
    const double beam = rough.sun_rgb[c] + ratio * rough.sky_rgb[c];
    prior.scale_rgb[c] = rough.sun_rgb[c] + rough.sky_rgb[c];
    if (!(weight > 0.0) || !(ratio > 0.0) || !(beam > 0.0)) continue;
    const double u = (rough.sun_rgb[c] - kSunPriorMean * ratio * rough.sky_rgb[c]) / beam;
    LightVector row = LightVector::Zero(prior.information_times_mean.size());
    row[c] = (1.0 - u) / (kSigma * beam);
    for (Eigen::Index k = 3 + c; k < row.size(); k += 3) {
      row[k] = -(kSunPriorMean + u) * ratio / (kSigma * beam);
    }
    // row' rough = 0, so that the residual at any light is u / kSigma + row' light.
    prior.information += weight * row * row.transpose();
    prior.information_times_mean -= weight * u / kSigma * row;
  }
}

}  // namespace pleinair
