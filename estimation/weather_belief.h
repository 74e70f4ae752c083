// The weather's development: the belief of the present light, predicted from the earlier belief.
#pragma once

#include <array>

#include <glm/vec3.hpp>

#include "estimation/sky_climate.h"
#include "scene/utc_time.h"

namespace pleinair {

// One state of the sky: its probability, and the light under it.
struct WeatherLight {
  double share = 0.0;
  LightGaussian light;
  // How well the last picture agreed with it: a logarithm, up to a constant. The next picture of
  // the same light repeats that evidence, and must not count it again.
  double log_evidence = 0.0;
};

// The belief of the light at one time: a mixture over the states of the sky.
struct WeatherBelief {
  UtcTime time{};
  double repeats = 0.0;  // The part of the last picture's evidence that this one repeats.
  std::array<WeatherLight, kSkyStates> states;
};

// Light that was measured at another time, by the survey.
struct SurveyedLight {
  UtcTime time{};
  glm::dvec3 sun_rgb{0.0};  // Normal to the beam.
  glm::dvec3 sun_stddev_rgb{0.0};
  glm::dvec3 sky_rgb{0.0};        // Horizontal, without the disc.
  ClearSkyExpectation clear_sky;  // At the sun of the survey.
  // The survey did not see the sun's place: sun_rgb holds only if no cloud covered it.
  bool sun_may_be_covered = false;
};

// The belief from the climate only.
WeatherBelief BeliefFromClimate(const SkyClimate& climate, UtcTime time);

// The survey's own light under each state, with the states' probabilities given that light.
WeatherBelief BeliefFromSurvey(const SurveyedLight& survey);

// Predicts `last` for `time`, before or after it, under the climate of that time. States follow
// each other as a Markov chain: among broken clouds the sun comes and goes within a minute or so;
// clear, broken and overcast weather last for hours. Within a state the light returns to the
// climate's (an Ornstein-Uhlenbeck process). Where the state changes, the sun is the climate's;
// where the weather changes, so is the sky. For an interval of 0 the result is `last`, for a long
// one the climate.
//
// Source  Interacting-multiple-model prediction: Blom and Bar-Shalom, IEEE Transactions on
//         Automatic Control 33(8), 1988.
WeatherBelief Predict(const WeatherBelief& last, const SkyClimate& climate, UtcTime time);

// Converts a belief from the sun of `then` to that of `now`: each state's light scales with its
// climate's, up to some times as strong.
void FollowTheSun(const SkyClimate& then, const SkyClimate& now, WeatherBelief& belief);

// As the function of the same name for a climate.
void Believe(Weather seen, WeatherBelief& belief);

// Converts to the units of a picture that is brighter by `factor_rgb`.
void Rescale(const glm::dvec3& factor_rgb, WeatherBelief& belief);
void Rescale(const glm::dvec3& factor_rgb, LightGaussian& light);

}  // namespace pleinair
