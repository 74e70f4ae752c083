#include "estimation/outdoor_estimator.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>

#include "estimation/camera_errors.h"
#include "estimation/internal/symmetric_algebra.h"
#include "estimation/shadow_cues.h"

namespace pleinair {
namespace {

// A frame as much later is likely to show the same light.
constexpr auto kStartsAtTheLast = std::chrono::seconds(10);

// Standard deviations of each channel's gain. In order: units of the survey; a picture whose
// exposure and white balance changed by a known factor; a picture of unknown white balance.
constexpr double kSurveyedGainStddev = 0.02;
constexpr double kFollowedGainStddev = 0.02;
constexpr double kUnknownGainStddev = 0.35;
// Standard deviation of the climate's light in units that only earlier frames have tied.
constexpr double kLearnedGainStddev = 0.3;

bool AnyOfTheDiscIsUp(const SunState& sun) {
  return sun.direction_enu.z > -std::sin(sun.angular_radius_rad);
}

// By deep night its light is no number to compute with.
bool IsKnown(const ClearSkyExpectation& clear_sky) {
  constexpr double kLowestSine = -0.2;
  return clear_sky.sine_of_elevation > kLowestSine &&
         std::min({clear_sky.diffuse_rgb.x, clear_sky.diffuse_rgb.y, clear_sky.diffuse_rgb.z}) >
             0.0;
}

// Fuses two Gaussians that may share their errors: in each direction the better one counts, mean
// and variance. Errors of albedo and geometry are the same in the next picture, so that many
// pictures have hardly more information than one, and the same picture again changes nothing where
// it knows less than was known. After Sijs and Lazar, Automatica 48(8), 2012, ellipsoidal
// intersection.
//
// `both` is the mean given both, as of independent Gaussians.
LightGaussian BetterOf(const LightGaussian& known,
                       const SunAndSkyMatrix& measured,
                       const SunAndSky& both) {
  using estimation_internal::SolveLower;
  const LightMatrix root = estimation_internal::LowerRootOf(known.covariance);
  // Factor of `measured` over `known`.
  LightMatrix relative = SolveLower(root, LightMatrix(measured));
  relative = SolveLower(root, LightMatrix(relative.transpose()));
  relative = (0.5 * (relative + relative.transpose())).eval();
  const auto eigen = estimation_internal::DecompositionOf(relative);
  if (!eigen) return known;
  const LightMatrix turned = root * eigen->vectors;
  const LightVector variances = eigen->values.cwiseMax(0.0).cwiseMin(1.0);
  LightVector step = eigen->vectors.transpose() * SolveLower(root, LightVector(both - known.mean));
  for (Eigen::Index k = 0; k < step.size(); ++k) {
    if (!(eigen->values[k] < 1.0)) step[k] = 0.0;
  }
  LightGaussian better;
  better.mean = (known.mean + turned * step).cwiseMax(0.0);
  better.covariance = turned * variances.asDiagonal() * turned.transpose();
  return better;
}

// A picture that lies far from what was known shows other light. What was known is then known less
// well: such a step becomes one of kLikely standard deviations, as far as one frame in a hundred
// errs in two directions, the sum of sun and sky and their ratio.
void DoubtWhatIsContradicted(const SunAndSky& both, LightGaussian& known) {
  constexpr double kLikely = 3.0;
  const LightVector step = both - known.mean;
  const double square =
      step.dot(estimation_internal::SolvePositive(LightMatrix(known.covariance), step));
  if (square > kLikely * kLikely) known.covariance *= square / (kLikely * kLikely);
}

double SkyOf(const LightVector& irradiance_rgb, int channel) {
  double sum = 0.0;
  for (Eigen::Index u = 3 + channel; u < irradiance_rgb.size(); u += 3) sum += irradiance_rgb[u];
  return sum;
}

// The clear-sky beam in the frame's units, mean over RGB. Where nothing is known of it, all the
// light there is.
double BeamOf(const OutdoorConditions& conditions,
              double climate_gain,
              const LightVector& irradiance_rgb) {
  const ClearSkyExpectation& clear_sky = conditions.clear_sky;
  double beam = 0.0;
  for (int c = 0; c < 3; ++c) {
    beam += IsKnown(clear_sky) && !conditions.held ? climate_gain * clear_sky.beam_rgb[c]
                                                   : irradiance_rgb[c] + SkyOf(irradiance_rgb, c);
  }
  return beam / 3.0;
}

// Air alone scatters more than half of a standard clear sky's light: with a sun there is a sky, of
// every colour.
bool HasASkyForItsSun(const ClearSkyExpectation& clear_sky, const LightVector& irradiance_rgb) {
  constexpr double kLeastOfClear = 0.4;
  for (int c = 0; c < 3; ++c) {
    if (!(clear_sky.beam_rgb[c] > 0.0)) return true;
    const double clear = irradiance_rgb[c] * clear_sky.diffuse_rgb[c] / clear_sky.beam_rgb[c];
    if (SkyOf(irradiance_rgb, c) < kLeastOfClear * clear) return false;
  }
  return true;
}

// Whether the samples determine the sun, as a share of it, better than the sky.
bool DeterminesSunBetterThanSky(const LightingFit& fit) {
  double sun = 0.0;
  double sky = 0.0;
  for (int c = 0; c < 3; ++c) {
    sun += fit.irradiance_rgb[c];
    sky += SkyOf(fit.irradiance_rgb, c);
  }
  const double sun_variance = fit.data_covariance.topLeftCorner<3, 3>().trace();
  const double sky_variance = fit.data_covariance.bottomRightCorner<3, 3>().trace();
  return sun_variance * sky * sky < sky_variance * sun * sun;
}

// The sky over the sun is the clear sky's, to a thousandth: no samples contradict that.
void HoldSkyToSun(const ClearSkyExpectation& clear_sky,
                  const LightVector& irradiance_rgb,
                  LightingPrior& prior) {
  constexpr double kHeldTo = 1e-3;
  for (int c = 0; c < 3; ++c) {
    const double ratio = clear_sky.diffuse_rgb[c] / clear_sky.beam_rgb[c];
    const double deviation = kHeldTo * ratio * irradiance_rgb[c];
    if (!(deviation > 0.0)) continue;
    LightVector row = LightVector::Zero(prior.information_times_mean.size());
    row[c] = -ratio / deviation;
    for (Eigen::Index u = 3 + c; u < row.size(); u += 3) row[u] = 1.0 / deviation;
    prior.information += row * row.transpose();
  }
}

// Adds an error of sun and of sky, for each channel.
void Widen(const glm::dvec3& sun_stddev, const glm::dvec3& sky_stddev, LightingFit& fit) {
  const Eigen::Index shapes = fit.irradiance_rgb.size() / 3 - 1;
  for (int c = 0; c < 3; ++c) {
    fit.covariance(c, c) += sun_stddev[c] * sun_stddev[c];
    fit.data_covariance(c, c) += sun_stddev[c] * sun_stddev[c];
    const double of_shape = sky_stddev[c] / static_cast<double>(shapes);
    for (Eigen::Index u = 3 + c; u < fit.irradiance_rgb.size(); u += 3) {
      for (Eigen::Index v = 3 + c; v < fit.irradiance_rgb.size(); v += 3) {
        fit.covariance(u, v) += of_shape * of_shape;
      }
    }
    fit.data_covariance(3 + c, 3 + c) += sky_stddev[c] * sky_stddev[c];
  }
}

// A held value is not a measurement: real skies have from half a clear one's light to twice that
// light.
void WidenHeldSky(LightingFit& fit) {
  constexpr double kStddev = 0.6;
  glm::dvec3 sky(0.0);
  for (int c = 0; c < 3; ++c) sky[c] = kStddev * SkyOf(fit.irradiance_rgb, c);
  Widen(glm::dvec3(0.0), sky, fit);
}

// Surfaces that differ more from the model than `trusted_residual` show something else, and say as
// little of the light: a car before a wall in shade looks like less sky, and more sun.
void WidenByMisfit(double trusted_residual, LightingFit& fit) {
  const double residual = fit.relative_residual;
  if (!(residual > trusted_residual)) return;
  const double excess = std::sqrt(residual * residual - trusted_residual * trusted_residual);
  glm::dvec3 light(0.0);
  for (int c = 0; c < 3; ++c) {
    light[c] = excess * (fit.irradiance_rgb[c] + SkyOf(fit.irradiance_rgb, c));
  }
  if (!fit.sun_is_fitted) {
    Widen(glm::dvec3(0.0), light, fit);
    return;
  }
  Widen(light, light, fit);
  for (int c = 0; c < 3; ++c) {
    fit.sun_stddev_data_rgb[c] = std::hypot(fit.sun_stddev_data_rgb[c], light[c]);
  }
}

// The share of a picture's evidence of the weather that counts.
double TrustIn(const LightingFit& fit, double trusted_residual) {
  if (!(fit.relative_residual > trusted_residual)) return 1.0;
  const double ratio = trusted_residual / fit.relative_residual;
  return ratio * ratio;
}

void Describe(const OutdoorConditions& conditions,
              const LightingFit& fit,
              double climate_gain,
              LightingEstimate& estimate) {
  Lighting& lighting = estimate.lighting;
  lighting.time = conditions.time;
  lighting.sun.direction_enu = conditions.sun.direction_enu;
  lighting.sun.angular_radius_rad = conditions.sun.angular_radius_rad;
  // Without an exposure in the picture's own units: light as bright as what it shows is as it is.
  const bool is_relative = conditions.units == LightUnits::kRelativePerFrame;
  const glm::dvec3 unit = is_relative ? fit.picture_over_light_rgb : glm::dvec3(1.0);
  if (conditions.camera.exponent_stddev > 0.0) {
    estimate.response = CorrectionOf(conditions.camera, fit, unit);
  }
  LightVector light = fit.irradiance_rgb;
  for (Eigen::Index u = 0; u < light.size(); ++u) light[u] *= unit[static_cast<int>(u % 3)];
  lighting.sun.irradiance_rgb = {light[0], light[1], light[2]};
  for (std::size_t k = 0; k < conditions.sky_shape_names.size(); ++k) {
    const auto first = static_cast<Eigen::Index>(3 * (1 + k));
    lighting.sky.push_back(
        {conditions.sky_shape_names[k], {light[first], light[first + 1], light[first + 2]}});
  }
  // Light is radiance over albedo: where all albedos are too high, all lights are too weak.
  const glm::dvec3& scale = conditions.albedo_stddev_rgb;
  lighting.common_stddev_rgb = scale;
  const Eigen::Index unknowns = light.size();
  for (Eigen::Index u = 0; u < unknowns; ++u) {
    for (Eigen::Index v = 0; v < unknowns; ++v) {
      const double shared =
          scale[static_cast<int>(u % 3)] * light[u] * scale[static_cast<int>(v % 3)] * light[v];
      const double units = unit[static_cast<int>(u % 3)] * unit[static_cast<int>(v % 3)];
      lighting.covariance.push_back(units * fit.covariance(u, v) + shared);
    }
  }
  estimate.sun_observable =
      fit.sun_is_fitted && conditions.sun.direction_enu.z > 0.0 &&
      DeterminesSun(fit, BeamOf(conditions, climate_gain, fit.irradiance_rgb));
  estimate.samples_used = fit.samples_used;
  estimate.inlier_fraction = fit.inlier_fraction;
  estimate.condition_number = fit.condition_number;
  estimate.relative_residual = fit.relative_residual;
}

// For the prior's weathers: the belief's states with a share.
void DescribeWeather(const WeatherBelief& belief,
                     const LightingFit& fit,
                     LightingEstimate& estimate) {
  estimate.weather_shares.emplace();
  std::size_t w = 0;
  for (std::size_t s = 0; s < kSkyStates; ++s) {
    if (!(belief.states[s].share > 0.0)) continue;
    const auto weather = static_cast<std::size_t>(WeatherOf(static_cast<SkyState>(s)));
    (*estimate.weather_shares)[weather] += fit.weathers[w++].share;
  }
}

}  // namespace

double TrustedResidual(double plane_albedo_stddev) {
  return std::hypot(kLargestTrustedResidual, plane_albedo_stddev);
}

tl::expected<LightingEstimate, LightingFailure> OutdoorEstimator::Estimate(
    std::span<DiffuseSample> samples, const OutdoorConditions& conditions) {
  const int sky_shapes = static_cast<int>(conditions.sky_shape_names.size());
  const bool sun_is_up = AnyOfTheDiscIsUp(conditions.sun);
  Expectation expectation = Expect(conditions, sky_shapes);
  if (!conditions.surveyed && sun_is_up && !expectation.prior.weathers.empty()) {
    auto log_likelihood = LogLikelihood(FindShadows(samples));
    if (conditions.texture) {
      const auto of_texture = LogLikelihood(*conditions.texture);
      for (std::size_t s = 0; s < kSkyStates; ++s) log_likelihood[s] += of_texture[s];
    }
    expectation.prior.log_likelihood.assign(log_likelihood.begin(), log_likelihood.end());
  }
  // A wrong model may favour either of two starts: frames of a recording, minutes apart, are each
  // fitted without the last one.
  const auto since = last_time_ ? conditions.time - *last_time_ : UtcTime::duration::max();
  const bool continues = since >= UtcTime::duration::zero() && since <= kStartsAtTheLast;
  last_time_ = conditions.time;
  LightingFit fit = fitter_.Fit(
      samples, expectation.prior, sun_is_up, continues ? FitStart::kLast : FitStart::kRobust);
  // Surfaces that are all in the sun contain little evidence of the sky, and errors of the model
  // may result in a sky of 0.
  if (sun_is_up && IsKnown(conditions.clear_sky) && !conditions.held &&
      DeterminesSunBetterThanSky(fit) &&
      !HasASkyForItsSun(conditions.clear_sky, fit.irradiance_rgb)) {
    HoldSkyToSun(conditions.clear_sky, fit.irradiance_rgb, expectation.prior);
    fit = fitter_.Fit(samples, expectation.prior, sun_is_up);
    WidenHeldSky(fit);
  }
  const double trusted_residual = TrustedResidual(conditions.plane_albedo_stddev);
  WidenByMisfit(trusted_residual, fit);
  if (fit.samples_used == 0 && !expectation.prior.SaysSomething()) {
    std::string reason =
        "no usable sample: expected a surface of the mesh in view that is neither clipped nor "
        "masked";
    // By night, or without a sun, neither would help.
    if (sun_is_up && IsKnown(conditions.clear_sky)) {
      reason += ", or, to fall back on earlier light and weather, ";
      reason += conditions.clear_sky.absolute ? "the frame's exposure"
                : conditions.surveyed         ? "an environment map that shows the sky, from above "
                                                "the ground (environment.position_m)"
                                              : "environment.image in the sequence";
    }
    return tl::unexpected(LightingFailure{std::move(reason)});
  }
  if (sun_is_up && !expectation.prior.weathers.empty()) {
    Learn(expectation, fit, TrustIn(fit, trusted_residual));
    last_clear_sky_ = conditions.clear_sky;
  } else {
    belief_.reset();
    climate_gain_ = expectation.climate_gain;
  }
  // Where the model does not fit, anything may look like a response. It is drawn with all the same:
  // light and response explain the picture together.
  if (!(fit.relative_residual > trusted_residual)) {
    LearnResponse(expectation.prior.camera, fit, conditions.time);
  }
  MarkRejected(fit, samples);
  LightingEstimate estimate;
  estimate.units = conditions.units;
  estimate.exposure_change = conditions.exposure_change;
  Describe(conditions, fit, climate_gain_, estimate);
  if (fit.sun_is_fitted && !expectation.prior.weathers.empty()) {
    DescribeWeather(expectation.belief, fit, estimate);
  }
  return estimate;
}

OutdoorEstimator::Expectation OutdoorEstimator::Expect(const OutdoorConditions& conditions,
                                                       int sky_shapes) {
  const ClearSkyExpectation& clear_sky = conditions.clear_sky;
  Expectation expectation;
  expectation.prior = LightingPrior::Nothing(sky_shapes);
  if (IsKnown(clear_sky)) {
    SkyClimate climate = MakeSkyClimate(clear_sky);
    if (conditions.weather) Believe(*conditions.weather, climate);
    // Twilight and lamps are in no climate: only the colour of their light is.
    const bool is_tied = clear_sky.absolute && conditions.units == LightUnits::kAbsolute &&
                         AnyOfTheDiscIsUp(conditions.sun);
    const ExposureChange& change = conditions.exposure_change;
    const bool is_followed = belief_.has_value() && AnyOfTheDiscIsUp(conditions.sun) &&
                             (conditions.units != LightUnits::kRelativePerFrame ||
                              change.kind == ExposureChange::Kind::kNone ||
                              change.kind == ExposureChange::Kind::kExposure);

    std::optional<WeatherBelief> last = belief_;
    if (last) FollowTheSun(MakeSkyClimate(last_clear_sky_), climate, *last);
    expectation.climate_gain = is_tied ? 1.0 : is_followed ? climate_gain_ : 1.0;
    if (last && !is_tied && is_followed && conditions.units == LightUnits::kRelativePerFrame) {
      Rescale(change.factor_rgb, *last);
      expectation.climate_gain *=
          (change.factor_rgb.x + change.factor_rgb.y + change.factor_rgb.z) / 3.0;
    } else if (last && !is_tied && !is_followed) {
      for (WeatherLight& state : last->states) ScaleBy(1.0 / climate_gain_, state.light);
    }
    if (conditions.surveyed && conditions.surveyed->clear_sky.absolute && (is_tied || !last)) {
      const auto gap = [&](UtcTime time) {
        return time > conditions.time ? time - conditions.time : conditions.time - time;
      };
      if (!last || gap(conditions.surveyed->time) < gap(last->time)) {
        last = BeliefFromSurvey(*conditions.surveyed);
        FollowTheSun(MakeSkyClimate(conditions.surveyed->clear_sky), climate, *last);
      }
    }
    for (SkyClimate::State& state : climate.states) {
      ScaleBy(expectation.climate_gain, state.light);
      if (is_tied) AddGainError(clear_sky.gain_stddev, state.light);
      if (!is_tied && is_followed) AddGainError(kLearnedGainStddev, state.light);
    }
    expectation.belief = last ? Predict(*last, climate, conditions.time)
                              : BeliefFromClimate(climate, conditions.time);
    if (conditions.weather) Believe(*conditions.weather, expectation.belief);
    expectation.prior = MakeLightingPrior(expectation.belief, climate, sky_shapes);
    expectation.prior.gain_is_free = !is_tied && !is_followed;
    expectation.exposure_changed = !is_tied && change.kind == ExposureChange::Kind::kExposure;
    expectation.prior.channel_gain_stddev = is_tied       ? kSurveyedGainStddev
                                            : is_followed ? kFollowedGainStddev
                                                          : kUnknownGainStddev;
    SetBeamShape(conditions.sky_shape_names, clear_sky, expectation.prior);
  }
  expectation.prior.albedo_stddev = conditions.plane_albedo_stddev;
  expectation.prior.camera = conditions.camera;
  if (response_ && conditions.camera.exponent_stddev > 0.0) {
    CameraErrors& camera = expectation.prior.camera;
    camera.vignetting = response_->vignetting.value;
    camera.vignetting_stddev = response_->vignetting.stddev;
    camera.saturation = response_->saturation.value;
    camera.saturation_stddev = response_->saturation.stddev;
    camera.exponent = response_->exponent.value;
    camera.exponent_stddev = response_->exponent.stddev;
  }
  if (conditions.held) {
    HoldIrradiance(conditions.held->sun_rgb, conditions.held->sky_rgb, expectation.prior);
  }
  return expectation;
}

// Pictures of one light share their errors: how much new evidence a picture has grows with the time
// since the last.
void OutdoorEstimator::LearnResponse(const CameraErrors& expected,
                                     const LightingFit& fit,
                                     UtcTime time) {
  if (!(expected.exponent_stddev > 0.0) || !(fit.exponent_stddev > 0.0)) return;
  constexpr double kOtherLightS = 600.0;
  double part = 1.0;
  if (response_) {
    using Seconds = std::chrono::duration<double>;
    const double gap_s = std::abs(Seconds(time.time_since_epoch()).count() -
                                  Seconds(response_->time.time_since_epoch()).count());
    part = std::min(1.0, gap_s / kOtherLightS);
  }
  const LearnedError vignetting{expected.vignetting, expected.vignetting_stddev};
  const LearnedError saturation{expected.saturation, expected.saturation_stddev};
  const LearnedError exponent{expected.exponent, expected.exponent_stddev};
  response_ = Response{
      WithEvidence(vignetting, vignetting, {fit.vignetting, fit.vignetting_stddev}, part),
      WithEvidenceDownTo(
          kLeastSaturationStddev, saturation, {fit.saturation, fit.saturation_stddev}, part),
      WithEvidence(exponent, exponent, {fit.exponent, fit.exponent_stddev}, part),
      time};
}

void OutdoorEstimator::Learn(const Expectation& expectation, const LightingFit& fit, double trust) {
  const LightingPrior& prior = expectation.prior;
  double gain = 0.0;
  for (const WeatherFit& weather : fit.weathers) gain += weather.share * weather.gain;
  // Units of white balance and exposure that the last picture did not have.
  const bool has_new_units = prior.gain_is_free || expectation.exposure_changed;
  WeatherBelief belief = expectation.belief;
  std::size_t w = 0;
  for (WeatherLight& state : belief.states) {
    if (!(state.share > 0.0)) continue;
    const WeatherFit& found = fit.weathers[w++];
    state.share += trust * (found.share - state.share);
    state.log_evidence = trust * found.log_evidence;
    ScaleBy(prior.gain_is_free ? found.gain : 1.0, state.light);
    if (prior.gain_is_free) AddGainError(1.0, state.light);
    if (has_new_units) AddChannelGainError(prior.channel_gain_stddev, state.light);
    const bool is_fitted = !found.light.isZero();
    const SunAndSky both = is_fitted ? SunAndSky(found.light) : state.light.mean;
    // A weather that is not likely is contradicted by every picture of another one.
    if (found.share > 0.5) DoubtWhatIsContradicted(both, state.light);
    state.light = BetterOf(state.light, fit.data_covariance, both);
  }
  belief.repeats = 1.0;
  belief_ = belief;
  climate_gain_ = expectation.climate_gain * (prior.gain_is_free ? gain : 1.0);
}

}  // namespace pleinair
