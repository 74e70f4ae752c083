// How weather goes on: what is believed of the light now, from what was known of it before.
#pragma once

#include <array>

#include <glm/vec3.hpp>

#include "estimation/sky_climate.h"
#include "scene/utc_time.h"

namespace pleinair {

// One state of the sky: how probable it is, and the light if it is the one.
struct WeatherLight {
  double share = 0.0;
  LightGaussian light;
  // How well the last picture agreed with it: a logarithm, but for a constant. The next picture of
  // the same light says the same once more, which is no news.
  double log_evidence = 0.0;
};

struct WeatherBelief {
  UtcTime time{};
  double repeats = 0.0;  // Of the last picture's evidence: the part that this one shares.
  std::array<WeatherLight, kSkyStates> states;
};

// Light that was measured at another time, by the survey.
struct SurveyedLight {
  UtcTime time{};
  glm::dvec3 sun_rgb{0.0};  // Normal to the beam.
  glm::dvec3 sun_stddev_rgb{0.0};
  glm::dvec3 sky_rgb{0.0};        // Horizontal, without the disc.
  ClearSkyExpectation clear_sky;  // At the sun of the survey.
};

// What the climate alone says.
WeatherBelief BeliefFromClimate(const SkyClimate& climate, UtcTime time);

// The survey's own light under each state, and the states as probable as they make it.
WeatherBelief BeliefFromSurvey(const SurveyedLight& survey);

// `last` at `time`, before or after it, under the climate of that time. States follow each other as
// a Markov chain: the sun comes and goes among broken clouds within a minute or so, clear, broken
// and overcast weather stay for hours. Within a state the light goes back to the climate's
// (an Ornstein-Uhlenbeck process); where the state changes the sun is the climate's, and where the
// weather changes so is the sky. Nothing is known for certain for long, and nothing is forgotten at
// once: for an interval of 0 it is `last`, for a long one the climate (an
// interacting-multiple-model prediction: Blom and Bar-Shalom, IEEE Transactions on Automatic
// Control 33(8), 1988).
WeatherBelief Predict(const WeatherBelief& last, const SkyClimate& climate, UtcTime time);

// As it would be under the sun of `now`, known under that of `then`: each state's light goes with
// its climate's, up to some times as strong.
void FollowTheSun(const SkyClimate& then, const SkyClimate& now, WeatherBelief& belief);

// As the same function of a climate.
void Believe(Weather seen, WeatherBelief& belief);

// In a picture that is brighter by `factor_rgb`.
void Rescale(const glm::dvec3& factor_rgb, WeatherBelief& belief);
void Rescale(const glm::dvec3& factor_rgb, LightGaussian& light);

}  // namespace pleinair
