#include "estimation/lighting_prior.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "sunmodel/sky_shapes.h"

namespace pleinair {
namespace {

// A carried light is widened by this part of its state's own spread. A sun that a frame knows to
// 2 % of the beam is drawn to a clear sky's, known to half of 13 %, by a tenth of their difference.
constexpr double kWidening = 0.5;

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

bool LightingPrior::SaysSomething() const {
  return information.trace() > 0.0 || (!weathers.empty() && !gain_is_free);
}

LightingPrior MakeLightingPrior(const WeatherBelief& belief,
                                const SkyClimate& climate,
                                int sky_shapes) {
  LightingPrior prior = LightingPrior::Nothing(sky_shapes);
  prior.repeats = belief.repeats;
  SunAndSky mean = SunAndSky::Zero();
  for (std::size_t s = 0; s < kSkyStates; ++s) {
    WeatherLight state = belief.states[s];
    state.light.covariance += kWidening * kWidening * climate.states[s].light.covariance;
    mean += state.share * state.light.mean;
    prior.weathers.push_back(state);
  }
  for (int c = 0; c < 3; ++c) prior.scale_rgb[c] = mean[c] + mean[3 + c];
  return prior;
}

LightingPrior MakeClimatePrior(const ClearSkyExpectation& clear_sky,
                               int sky_shapes,
                               const std::optional<Weather>& seen) {
  const glm::dvec3& diffuse = clear_sky.diffuse_rgb;
  if (!(std::min({diffuse.x, diffuse.y, diffuse.z}) > 0.0)) {
    return LightingPrior::Nothing(sky_shapes);
  }
  SkyClimate climate = MakeSkyClimate(clear_sky);
  if (seen) Believe(*seen, climate);
  LightingPrior prior =
      MakeLightingPrior(BeliefFromClimate(climate, UtcTime{}), climate, sky_shapes);
  prior.gain_is_free = !clear_sky.absolute;
  return prior;
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

void HoldIrradiance(const glm::dvec3& sun_rgb, const glm::dvec3& sky_rgb, LightingPrior& prior) {
  constexpr double kTightness = 1e-4;
  prior.weathers.clear();
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

}  // namespace pleinair
