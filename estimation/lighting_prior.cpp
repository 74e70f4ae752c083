#include "estimation/lighting_prior.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <string>

#include "estimation/internal/symmetric_algebra.h"
#include "sunmodel/sky_shapes.h"

namespace pleinair {
namespace {

using estimation_internal::InverseOf;

// The sky's part is told well by almost any picture, so its prior only has to be sane: between an
// eighth (rain cloud) and five times (bright broken cloud) a clear sky's at two sigma.
constexpr double kSkyPriorMean = 2.0;   // Of the clear sky's diffuse irradiance.
constexpr double kSkyPriorSigma = 1.5;  // Likewise.

// Broken clouds uncover and cover the sun within a minute or so.
constexpr double kWeatherMemoryS = 60.0;
// exp(-10) of an answer is left after ten of those: the cut is no jump.
constexpr double kLongestCarryS = 10.0 * kWeatherMemoryS;

// Widening of a carried answer. A frame that knows its sun to 2 % of the beam keeps
// (0.02 / 0.15)^2 < 2 % of a step's size as bias.
constexpr double kCarriedSunSigma = 0.15;  // Of the beam.
constexpr double kCarriedSkySigma = 0.5;   // Of the carried sky.

struct UsualLight {
  glm::dvec3 beam{0.0};
  glm::dvec3 sky{0.0};
};

// How strong the light may have become since `earlier`: as a clear sky's or as it was, whichever is
// more. With relative light, the clear sky's beam is its ratio times the carried sky.
UsualLight UsualLightOf(const ClearSkyExpectation& clear_sky, const CarriedLighting& earlier) {
  UsualLight usual;
  for (int channel = 0; channel < 3; ++channel) {
    double sky = 0.0;
    for (Eigen::Index u = 3 + channel; u < earlier.mean.size(); u += 3) sky += earlier.mean[u];
    const double sun = earlier.mean[channel];
    const double diffuse = clear_sky.diffuse_rgb[channel];
    const double ratio = diffuse > 0.0 ? clear_sky.beam_rgb[channel] / diffuse : 0.0;
    usual.beam[channel] =
        std::max(sun, clear_sky.absolute ? clear_sky.beam_rgb[channel] : ratio * sky);
    // A carried sky of 0 would be rigid: a tenth of the sun is the clearest sky's share.
    usual.sky[channel] = std::max({sky, clear_sky.absolute ? diffuse : 0.0, 0.1 * sun});
  }
  return usual;
}

// 1 for the same moment, 0 for what must not be carried.
double Memory(const std::optional<CarriedLighting>& earlier, UtcTime time) {
  if (!earlier) return 0.0;
  // In double before the difference: three centuries of nanoseconds overflow their 64 bits.
  using Seconds = std::chrono::duration<double>;
  const double gap_s =
      (Seconds(time.time_since_epoch()) - Seconds(earlier->time.time_since_epoch())).count();
  if (!(gap_s >= 0.0 && gap_s <= kLongestCarryS)) return 0.0;
  return std::exp(-gap_s / kWeatherMemoryS);
}

void AddClearSky(const ClearSkyExpectation& clear_sky, double weight, LightingPrior& prior) {
  const auto add = [&](Eigen::Index unknown, double mean, double sigma) {
    if (!(sigma > 0.0)) return;
    prior.information(unknown, unknown) += weight / (sigma * sigma);
    prior.information_times_mean[unknown] += weight * mean / (sigma * sigma);
  };
  for (int channel = 0; channel < 3; ++channel) {
    const double beam = clear_sky.beam_rgb[channel];
    const double diffuse = clear_sky.diffuse_rgb[channel];
    if (!clear_sky.absolute) {
      prior.sun_to_sky_rgb[channel] = diffuse > 0.0 ? beam / diffuse : 0.0;
      prior.sun_to_sky_weight = weight;
      continue;
    }
    prior.scale_rgb[channel] = beam + diffuse;
    add(channel, kSunPriorMean * beam, kSunPriorSigma * beam);
    if (!(diffuse > 0.0)) continue;
    // Of the sum over the shapes; what each has of it is the fit's matter.
    const double information = weight / (kSkyPriorSigma * kSkyPriorSigma * diffuse * diffuse);
    for (int a = 3 + channel; a < 3 + 3 * prior.sky_shapes; a += 3) {
      prior.information_times_mean[a] += information * kSkyPriorMean * diffuse;
      for (int b = 3 + channel; b < 3 + 3 * prior.sky_shapes; b += 3) {
        prior.information(a, b) += information;
      }
    }
  }
}

// Covariance of a carried answer now: its own, and what the weather may have done since. The growth
// is the one that leaves the clear-sky prior as it is when nothing at all was known.
LightMatrix CarriedCovariance(const CarriedLighting& earlier,
                              const UsualLight& usual,
                              double memory,
                              bool widened) {
  LightMatrix covariance = earlier.covariance;
  const double growth = (1.0 - memory * memory) / (memory * memory);
  for (Eigen::Index u = 0; u < covariance.rows(); ++u) {
    const int channel = static_cast<int>(u % 3);
    const bool sun = u < 3;
    const double usual_size = sun ? usual.beam[channel] : usual.sky[channel];
    const double stationary = (sun ? kSunPriorSigma : kSkyPriorSigma) * usual_size;
    covariance(u, u) += growth * stationary * stationary;
    if (widened) {
      const double widening = (sun ? kCarriedSunSigma : kCarriedSkySigma) * usual_size;
      covariance(u, u) += widening * widening;
    }
  }
  return covariance;
}

LightingPrior PriorOf(const ClearSkyExpectation& clear_sky,
                      const std::optional<CarriedLighting>& earlier,
                      UtcTime time,
                      int sky_shapes,
                      double kept,
                      bool widened) {
  LightingPrior prior = LightingPrior::Nothing(sky_shapes);
  const bool fits = earlier && earlier->mean.size() == prior.information.rows();
  const double memory = fits ? kept * Memory(earlier, time) : 0.0;
  AddClearSky(clear_sky, 1.0 - memory * memory, prior);
  if (memory <= 0.0) return prior;

  const UsualLight usual = UsualLightOf(clear_sky, *earlier);
  const LightMatrix information = InverseOf(CarriedCovariance(*earlier, usual, memory, widened));
  if (!information.allFinite()) return prior;
  prior.information += information;
  prior.information_times_mean += information * earlier->mean;
  for (int channel = 0; channel < 3; ++channel) {
    prior.scale_rgb[channel] =
        std::max(prior.scale_rgb[channel], usual.beam[channel] + usual.sky[channel]);
  }
  return prior;
}

}  // namespace

LightingPrior LightingPrior::Nothing(int sky_shapes) {
  if (sky_shapes < 1 || sky_shapes > kMaxSkyShapes) {
    throw std::invalid_argument("sky_shapes " + std::to_string(sky_shapes) + ": expected 1 .. " +
                                std::to_string(kMaxSkyShapes));
  }
  LightingPrior prior;
  prior.sky_shapes = sky_shapes;
  const Eigen::Index unknowns = 3 * (1 + sky_shapes);
  prior.information = LightMatrix::Zero(unknowns, unknowns);
  prior.information_times_mean = LightVector::Zero(unknowns);
  return prior;
}

bool LightingPrior::SaysSomething() const { return information.trace() > 0.0; }

std::optional<CarriedLighting> CarryFromSurvey(const SurveyedLight& survey,
                                               UtcTime time,
                                               int sky_shapes) {
  constexpr double kSkySigma = 0.05;   // Of the survey's sky, as a whole.
  constexpr double kShareSigma = 0.5;  // Of each shape's share.
  CarriedLighting carried;
  carried.time = std::min(survey.time, time - (survey.time - time));
  if (!(Memory(carried, time) > 0.0)) return std::nullopt;
  const Eigen::Index unknowns = 3 * (1 + sky_shapes);
  carried.mean = LightVector::Zero(unknowns);
  carried.covariance = LightMatrix::Zero(unknowns, unknowns);
  const double share = 1.0 / sky_shapes;
  for (int c = 0; c < 3; ++c) {
    // A sun that was not there is known to a part of the sky.
    const double sun_sigma = std::max(survey.sun_stddev_rgb[c], kSkySigma * survey.sky_rgb[c]);
    carried.mean[c] = survey.sun_rgb[c];
    carried.covariance(c, c) = sun_sigma * sun_sigma;
    const double sum = kSkySigma * share * survey.sky_rgb[c];
    const double apart = kShareSigma * survey.sky_rgb[c];
    for (int a = 3 + c; a < unknowns; a += 3) {
      carried.mean[a] = share * survey.sky_rgb[c];
      carried.covariance(a, a) += apart * apart;
      for (int b = 3 + c; b < unknowns; b += 3) {
        carried.covariance(a, b) += sum * sum - share * apart * apart;
      }
    }
  }
  return carried;
}

LightingPrior MakeLightingPrior(const ClearSkyExpectation& clear_sky,
                                const std::optional<CarriedLighting>& earlier,
                                UtcTime time,
                                int sky_shapes,
                                double kept) {
  return PriorOf(clear_sky, earlier, time, sky_shapes, kept, /*widened=*/true);
}

void SetBeamShape(std::span<const std::string> shape_names,
                  const ClearSkyExpectation& clear_sky,
                  LightingPrior& prior) {
  const auto clear =
      std::find(shape_names.begin(), shape_names.end(), NameOf(SkyShapeKind::kClear));
  if (clear == shape_names.end()) return;
  prior.beam_shape = static_cast<int>(clear - shape_names.begin());
  for (int c = 0; c < 3; ++c) {
    if (!(clear_sky.diffuse_rgb[c] > 0.0)) continue;
    prior.clear_sun_to_sky_rgb[c] = clear_sky.beam_rgb[c] / clear_sky.diffuse_rgb[c];
  }
}

double KeptMemory(const ClearSkyExpectation& clear_sky,
                  const CarriedLighting& earlier,
                  UtcTime time,
                  const LightVector& found) {
  if (earlier.mean.size() != found.size() || !(Memory(earlier, time) > 0.0)) return 1.0;
  const UsualLight usual = UsualLightOf(clear_sky, earlier);
  const LightVector moved = found - earlier.mean;
  double sun = 0.0;
  double sky = 0.0;
  double usual_sun = 0.0;
  double usual_sky = 0.0;
  for (int channel = 0; channel < 3; ++channel) {
    sun += moved[channel];
    for (Eigen::Index u = 3 + channel; u < moved.size(); u += 3) sky += moved[u];
    usual_sun += usual.beam[channel];
    usual_sky += usual.sky[channel];
  }
  double deviations = 0.0;
  if (usual_sun > 0.0) deviations = std::abs(sun) / (kCarriedSunSigma * usual_sun);
  if (usual_sky > 0.0) {
    deviations = std::max(deviations, std::abs(sky) / (kCarriedSkySigma * usual_sky));
  }
  const double beyond = std::max(0.0, deviations - 1.0);
  return 1.0 / (1.0 + beyond * beyond);
}

void HoldIrradiance(const glm::dvec3& sun_rgb, const glm::dvec3& sky_rgb, LightingPrior& prior) {
  constexpr double kTightness = 1e-4;
  for (int c = 0; c < 3; ++c) {
    const double size = std::max(sun_rgb[c], sky_rgb[c]);
    // A black channel's size is the usual one, or any.
    const double scale = size > 0.0 ? size : prior.scale_rgb[c] > 0.0 ? prior.scale_rgb[c] : 1.0;
    const double weight = 1.0 / (kTightness * scale * kTightness * scale);
    prior.information(c, c) += weight;
    prior.information_times_mean[c] += weight * sun_rgb[c];
    for (int k = 0; k < prior.sky_shapes; ++k) {
      for (int l = 0; l < prior.sky_shapes; ++l) {
        prior.information(3 * (1 + k) + c, 3 * (1 + l) + c) += weight;
      }
      prior.information_times_mean[3 * (1 + k) + c] += weight * sky_rgb[c];
    }
  }
}

CarriedLighting CarryForward(const ClearSkyExpectation& clear_sky,
                             const std::optional<CarriedLighting>& earlier,
                             UtcTime time,
                             const LightVector& mean,
                             const LightMatrix& data_information,
                             double kept) {
  const int sky_shapes = static_cast<int>(mean.size()) / 3 - 1;
  const LightingPrior prior =
      PriorOf(clear_sky, earlier, time, sky_shapes, kept, /*widened=*/false);
  return {time, mean, InverseOf(data_information + prior.information)};
}

}  // namespace pleinair
