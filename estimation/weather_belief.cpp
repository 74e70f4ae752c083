#include "estimation/weather_belief.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "estimation/internal/seconds_between.h"
#include "estimation/internal/square.h"

namespace pleinair {
namespace {

using estimation_internal::SecondsBetween;
using estimation_internal::Square;

// Durations of the states. Within broken cloud the sun comes and goes in a minute or two. A weather
// lasts for some hours, and the light in it changes at the same rate.
constexpr double kBrokenCloudsS = 90.0;
// After this time a picture shows other shadows. Its surfaces' errors of albedo and geometry are
// the same all day.
constexpr double kEvidenceS = 3600.0;
constexpr double kWeatherS = 12.0 * 3600.0;

struct Memory {
  double sun_s;
  double sky_s;
};
// In SkyState's order.
constexpr Memory kMemories[kSkyStates] = {
    {4.0 * 3600.0, 4.0 * 3600.0},
    {3.0 * 3600.0, 3.0 * 3600.0},
    {60.0, 1.0 * 3600.0},
    {600.0, 1.0 * 3600.0},
    {4.0 * 3600.0, 3.0 * 3600.0},
};

// Errors of a survey's light: common to the channels (radiometry, and the sky that it did not see),
// and of one channel against the others.
constexpr double kSurveyStddev = 0.05;
constexpr double kSurveyHueStddev = 0.01;

// Probabilities of the next state, given the last; rows add up to 1.
std::array<std::array<double, kSkyStates>, kSkyStates> TransitionsOver(double gap_s,
                                                                       const SkyClimate& climate) {
  const double broken_stays = std::exp(-gap_s / kBrokenCloudsS);
  const double weather_stays = std::exp(-gap_s / kWeatherS);
  double broken = 0.0;
  const auto is_broken = [](std::size_t s) {
    return WeatherOf(static_cast<SkyState>(s)) == Weather::kBroken;
  };
  for (std::size_t s = 0; s < kSkyStates; ++s) {
    if (is_broken(s)) broken += climate.states[s].share;
  }
  std::array<std::array<double, kSkyStates>, kSkyStates> transitions{};
  for (std::size_t i = 0; i < kSkyStates; ++i) {
    for (std::size_t j = 0; j < kSkyStates; ++j) {
      const double share = climate.states[j].share;
      double within = i == j ? 1.0 : 0.0;
      if (is_broken(i)) {
        within =
            broken_stays * within + (is_broken(j) ? (1.0 - broken_stays) * share / broken : 0.0);
      }
      transitions[i][j] = weather_stays * within + (1.0 - weather_stays) * share;
    }
  }
  return transitions;
}

// Predicts `last` in the same state: each light keeps a part of its distance from the climate.
LightGaussian GoOn(const LightGaussian& last,
                   const LightGaussian& climate,
                   double sun_kept,
                   double sky_kept) {
  SunAndSky kept;
  kept << sun_kept, sun_kept, sun_kept, sky_kept, sky_kept, sky_kept;
  LightGaussian next;
  next.mean = climate.mean + kept.cwiseProduct(last.mean - climate.mean);
  // Sun and sky regain the climate's correlation to the degree that both are forgotten: positive
  // definite whatever their memories.
  const SunAndSky forgotten = (1.0 - kept.array().square()).max(0.0).sqrt();
  next.covariance = kept.asDiagonal() * last.covariance * kept.asDiagonal();
  next.covariance += forgotten.asDiagonal() * climate.covariance * forgotten.asDiagonal();
  return next;
}

// log N(value; light.mean, light.covariance), but for a constant.
double LogDensity(const SunAndSky& value, const LightGaussian& light) {
  const Eigen::LLT<SunAndSkyMatrix> root(light.covariance);
  const SunAndSky scaled = root.matrixL().solve(value - light.mean);
  const double log_root = root.matrixLLT().diagonal().array().log().sum();
  return -0.5 * scaled.squaredNorm() - log_root;
}

// Covariance of what the survey measures under a state: of a sun as strong as the state's. The
// error of the sun is a factor: one that the map clips is uncertain by 60 %, but it was not
// covered.
SunAndSkyMatrix ErrorUnder(const SunAndSky& state,
                           double sun_relative,
                           const LightGaussian& measured) {
  SunAndSkyMatrix error = measured.covariance;
  const auto sun = measured.mean.head<3>();
  const Eigen::Vector3d under = state.head<3>().cwiseMin(sun);
  error.topLeftCorner<3, 3>() +=
      Square(sun_relative) * (under * under.transpose() - sun * sun.transpose());
  return error;
}

}  // namespace

WeatherBelief BeliefFromClimate(const SkyClimate& climate, UtcTime time) {
  WeatherBelief belief;
  belief.time = time;
  for (std::size_t s = 0; s < kSkyStates; ++s) {
    belief.states[s] = {climate.states[s].share, climate.states[s].light};
  }
  return belief;
}

WeatherBelief BeliefFromSurvey(const SurveyedLight& survey) {
  const SkyClimate climate = MakeSkyClimate(survey.clear_sky);
  LightGaussian measured;
  double sun_relative = 0.0;
  double sun = 0.0;
  for (int c = 0; c < 3; ++c) {
    measured.mean[c] = survey.sun_rgb[c];
    measured.mean[3 + c] = survey.sky_rgb[c];
    sun += survey.sun_rgb[c];
    sun_relative += survey.sun_stddev_rgb[c];
  }
  sun_relative = sun > 0.0 ? sun_relative / sun : 0.0;
  for (int a = 0; a < 6; ++a) {
    for (int b = 0; b < 6; ++b) {
      if ((a < 3) != (b < 3)) continue;
      const double common = a < 3 ? sun_relative : kSurveyStddev;
      const double relative = Square(common) + (a == b ? Square(kSurveyHueStddev) : 0.0);
      measured.covariance(a, b) = relative * measured.mean[a] * measured.mean[b];
    }
    // The error of a sun of 0 is no factor.
    if (a < 3 && !(sun > 0.0)) {
      for (int b = 0; b < 3; ++b) {
        measured.covariance(a, b) += survey.sun_stddev_rgb[a] * survey.sun_stddev_rgb[b];
      }
    }
    // A sun that was not there is known to a part of the sky.
    if (a < 3) measured.covariance(a, a) += Square(kSurveyHueStddev * survey.sky_rgb[a]);
  }

  WeatherBelief belief;
  belief.time = survey.time;
  std::array<double, kSkyStates> log_share{};
  for (std::size_t s = 0; s < kSkyStates; ++s) {
    LightGaussian expected = climate.states[s].light;
    AddGainError(survey.clear_sky.gain_stddev, expected);
    expected.covariance += survey.sun_may_be_covered
                               ? measured.covariance
                               : ErrorUnder(climate.states[s].light.mean, sun_relative, measured);
    log_share[s] = std::log(climate.states[s].share) + LogDensity(measured.mean, expected);
  }
  const double largest = *std::max_element(log_share.begin(), log_share.end());
  double sum = 0.0;
  for (const double value : log_share) sum += std::exp(value - largest);
  for (std::size_t s = 0; s < kSkyStates; ++s) {
    belief.states[s] = {std::exp(log_share[s] - largest) / sum, measured};
  }
  return belief;
}

WeatherBelief Predict(const WeatherBelief& last, const SkyClimate& climate, UtcTime time) {
  const double gap_s = std::abs(SecondsBetween(last.time, time));
  const auto transitions = TransitionsOver(gap_s, climate);
  WeatherBelief next;
  next.time = time;
  next.repeats = last.repeats > 0.0 ? std::exp(-gap_s / kEvidenceS) : 0.0;
  for (std::size_t j = 0; j < kSkyStates; ++j) {
    const LightGaussian& usual = climate.states[j].light;
    const double sun_kept = std::exp(-gap_s / kMemories[j].sun_s);
    const double sky_kept = std::exp(-gap_s / kMemories[j].sky_s);
    WeatherLight& state = next.states[j];
    state.log_evidence = last.states[j].log_evidence;
    std::array<LightGaussian, kSkyStates> parts;
    std::array<double, kSkyStates> shares{};
    for (std::size_t i = 0; i < kSkyStates; ++i) {
      shares[i] = last.states[i].share * transitions[i][j];
      if (!(shares[i] > 0.0)) continue;
      // A sun that appears or goes is the climate's, and so is the sky of another weather.
      const bool same_weather =
          WeatherOf(static_cast<SkyState>(i)) == WeatherOf(static_cast<SkyState>(j));
      parts[i] =
          GoOn(last.states[i].light, usual, i == j ? sun_kept : 0.0, same_weather ? sky_kept : 0.0);
      state.share += shares[i];
      state.light.mean += shares[i] * parts[i].mean;
    }
    if (!(state.share > 0.0)) {
      state.light = usual;
      continue;
    }
    state.light.mean /= state.share;
    for (std::size_t i = 0; i < kSkyStates; ++i) {
      if (!(shares[i] > 0.0)) continue;
      const SunAndSky apart = parts[i].mean - state.light.mean;
      state.light.covariance +=
          shares[i] / state.share * (parts[i].covariance + apart * apart.transpose());
    }
  }
  return next;
}

void FollowTheSun(const SkyClimate& then, const SkyClimate& now, WeatherBelief& belief) {
  // A sun that was at the horizon has little information; for one that sets, the covariance stays
  // positive definite.
  constexpr double kMost = 4.0;
  constexpr double kLeast = 1e-3;
  // A state without a sun uses that of the clear state.
  constexpr auto kClear = static_cast<std::size_t>(SkyState::kClear);
  for (std::size_t s = 0; s < kSkyStates; ++s) {
    SunAndSky factor = SunAndSky::Ones();
    for (int a = 0; a < 6; ++a) {
      const std::size_t of = a < 3 ? kClear : s;
      const double before = then.states[of].light.mean[a];
      if (!(before > 0.0)) continue;
      factor[a] = std::clamp(now.states[of].light.mean[a] / before, kLeast, kMost);
    }
    LightGaussian& light = belief.states[s].light;
    light.mean = light.mean.cwiseProduct(factor);
    light.covariance = factor.asDiagonal() * light.covariance * factor.asDiagonal();
  }
}

void Believe(Weather seen, WeatherBelief& belief) {
  SkyClimate shares;
  for (std::size_t s = 0; s < kSkyStates; ++s) shares.states[s].share = belief.states[s].share;
  Believe(seen, shares);
  for (std::size_t s = 0; s < kSkyStates; ++s) belief.states[s].share = shares.states[s].share;
}

void Rescale(const glm::dvec3& factor_rgb, LightGaussian& light) {
  for (int a = 0; a < 6; ++a) {
    light.mean[a] *= factor_rgb[a % 3];
    for (int b = 0; b < 6; ++b) light.covariance(a, b) *= factor_rgb[a % 3] * factor_rgb[b % 3];
  }
}

void Rescale(const glm::dvec3& factor_rgb, WeatherBelief& belief) {
  for (WeatherLight& state : belief.states) Rescale(factor_rgb, state.light);
}

}  // namespace pleinair
