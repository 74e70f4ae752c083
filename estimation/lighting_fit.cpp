#include "estimation/lighting_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "estimation/internal/lighting_fitter.h"
#include "estimation/internal/symmetric_algebra.h"

namespace pleinair {
namespace {

using namespace estimation_internal;  // The folder's own.

// The scales settle within a few passes. They are kept once the light moves by less than this, so
// that the weights can converge: a small part of any standard deviation.
constexpr double kScalesHaveSettled = 5e-4;
constexpr int kMostPassesThatRescale = 8;
// A thousandth of a deviation at most, far above rounding.
constexpr double kConverged = 1e-5;

}  // namespace

void LightingFitOptions::Validate() const {
  const auto refuse = [](const char* field, double value, const char* expected) {
    throw std::invalid_argument(std::string("LightingFitOptions::") + field + " is " +
                                std::to_string(value) + ": expected " + expected);
  };
  const auto positive = [&](const char* field, double value) {
    if (!(value > 0.0) || !std::isfinite(value)) refuse(field, value, "a number above 0");
  };
  positive("tukey_width", tukey_width);
  positive("huber_width", huber_width);
  positive("expected_noise", expected_noise);
  positive("noise_floor", noise_floor);
  if (!(shared_error >= 0.0) || !std::isfinite(shared_error)) {
    refuse("shared_error", shared_error, "a number not below 0");
  }
  if (!(sky_shape_error >= 0.0) || !std::isfinite(sky_shape_error)) {
    refuse("sky_shape_error", sky_shape_error, "a number not below 0");
  }
  positive("shape_share_spread", shape_share_spread);
  positive("shape_share_colour_spread", shape_share_colour_spread);
  if (max_passes < 1) refuse("max_passes", max_passes, "at least 1");
}

bool DeterminesSun(const LightingFit& fit, double clear_sky_beam) {
  const glm::dvec3& sigma = fit.sun_stddev_data_rgb;
  // Infinite without any samples, whose deviation is in a unit of nothing.
  return fit.sun_is_fitted && std::isfinite(fit.condition_number) &&
         (sigma.x + sigma.y + sigma.z) / 3.0 < kObservableSunSigma * clear_sky_beam;
}

void LightingFitter::Impl::Load(std::span<const DiffuseSample> samples,
                                const LightingPrior& prior,
                                bool sun_is_up,
                                double exponent) {
  problem.Load(samples, prior, sun_is_up, exponent);
  if (camera_errors.size() != problem.error_count) ExpectErrors();
  // The last one was what differed from another exponent.
  if (problem.exponent_stddev > 0.0) camera_errors[problem.error_count - 1] = 0.0;
  LoadPrior(prior);
  mixture.Load(prior, problem);
}

void LightingFitter::Impl::ExpectErrors() {
  camera_errors = ErrorVector::Zero(problem.error_count);
  for (const auto* error : {&problem.vignetting, &problem.saturation}) {
    if (error->place >= 0) camera_errors[error->place] = error->mean;
  }
}

void LightingFitter::Impl::LoadPrior(const LightingPrior& prior) {
  const int unknowns = problem.UnknownCount();
  const int bases = problem.basis_count;
  fixed_prior_information = kWeakInformation * LightMatrix::Identity(unknowns, unknowns);
  prior_gradient = LightVector::Zero(unknowns);
  for (int u = 0; u < unknowns; ++u) {
    const int cu = u / bases;
    const int lu = problem.LightIndex(cu, u % bases);
    const double unit_u = problem.irradiance_unit[cu];
    prior_gradient[u] += prior.information_times_mean[lu] * unit_u;
    for (int v = 0; v < unknowns; ++v) {
      const int cv = v / bases;
      fixed_prior_information(u, v) += prior.information(lu, problem.LightIndex(cv, v % bases)) *
                                       unit_u * problem.irradiance_unit[cv];
    }
  }
  prior_information = fixed_prior_information;
}

// How much there is of the beam that a shape's light belongs to. It is 1 from 0.7 of the clear
// sky's sun over sky on, as haze that is not known takes some of it. That light is the beam's own,
// scattered: without such a bound a sky of it takes the sun's place where things that the mesh
// lacks darken the shade. Where a clear sky's sun would be a twentieth of its light or less, as at
// sunset, a missing sun is no evidence: the value rises gradually to 1.
double LightingFitter::Impl::BeamIn(const LightingPrior& prior, const LightVector& x) const {
  constexpr double kEnough = 0.7;
  constexpr double kTellingRatio = 0.5;
  const int bases = problem.basis_count;
  double sun = 0.0;
  double sky = 0.0;
  double clear_sun = 0.0;  // Of a clear sky of the same light.
  for (int c = 0; c < 3; ++c) {
    const double unit = problem.irradiance_unit[c];
    const double of_channel = unit * x.segment(c * bases + 1, bases - 1).sum();
    sun += unit * x[c * bases];
    sky += of_channel;
    clear_sun += prior.clear_sun_to_sky_rgb[c] * of_channel;
  }
  if (!(clear_sun > 0.0)) return 1.0;
  const double beam = std::min(1.0, sun / (kEnough * clear_sun));
  return std::lerp(1.0, beam, std::min(1.0, clear_sun / (kTellingRatio * sky)));
}

// With S the sum of a channel's sky, m_k the share expected of shape k and p_k the mean over the
// channels of its share, rows
//   (s_k - m_k S) / S = 0                                        give or take shape_share_spread,
//   (s_k - p_k S) / S of one channel - the same of another = 0 give or take the colour's spread,
// with denominators and p_k evaluated at `x`. They are 0 for any S: the sky's sum is left to the
// data. All m_k are equal, except that the shape of a beam has 0, give or take a tenth, where there
// is no beam. Under an overcast sky walls and ground differ little between shapes, and a few per
// cent of error within a plane would decide.
void LightingFitter::Impl::AddShapePrior(const LightingPrior& prior, const LightVector& x) {
  const int bases = problem.basis_count;
  const int first = problem.has_sun ? 1 : 0;
  const int shapes = bases - first;
  if (shapes < 2) return;
  // The shares of a sky that is black at `x` mean nothing, and `x` may be only a bad start. They
  // are computed for a tenth of the light that explains the median sample.
  constexpr double kLeastSky = 0.1;
  std::array<double, 3> sky{};
  BasisVector mean_share = BasisVector::Zero(shapes);
  for (int c = 0; c < 3; ++c) {
    const auto part = x.segment(c * bases + first, shapes);
    sky[static_cast<std::size_t>(c)] = std::max(part.sum(), kLeastSky);
    mean_share += part / (3.0 * sky[static_cast<std::size_t>(c)]);
  }
  const auto deviation = [&](int shape, double share, int c) {
    LightVector row = LightVector::Zero(x.size());
    const double scale = 1.0 / sky[static_cast<std::size_t>(c)];
    row.segment(c * bases + first, shapes).setConstant(-share * scale);
    row[c * bases + first + shape] += scale;
    return row;
  };
  constexpr double kSpreadWithoutBeam = 0.1;
  const bool one_needs_a_beam = problem.has_sun && prior.beam_shape >= 0;
  const double beam = one_needs_a_beam ? BeamIn(prior, x) : 1.0;
  const double share_with_beam = beam / shapes;
  const double colour_weight =
      1.0 / (options.shape_share_colour_spread * options.shape_share_colour_spread);
  for (int k = 0; k < shapes; ++k) {
    const bool needs_a_beam = one_needs_a_beam && k == prior.beam_shape;
    const double share = !one_needs_a_beam ? 1.0 / shapes
                         : needs_a_beam    ? share_with_beam
                                           : (1.0 - share_with_beam) / (shapes - 1);
    const double least_spread = std::min(kSpreadWithoutBeam, options.shape_share_spread);
    const double spread = needs_a_beam ? std::lerp(least_spread, options.shape_share_spread, beam)
                                       : options.shape_share_spread;
    const double weight = 1.0 / (spread * spread);
    for (int c = 0; c < 3; ++c) {
      const LightVector row = deviation(k, share, c);
      prior_information += weight * row * row.transpose();
      const LightVector between =
          deviation(k, mean_share[k], c) - deviation(k, mean_share[k], (c + 1) % 3);
      prior_information += colour_weight * between * between.transpose();
    }
  }
}

Evidence LightingFitter::Impl::WithErrors() const {
  const int bases = problem.basis_count;
  const int errors = problem.error_count;
  const int unknowns = problem.UnknownCount();
  Evidence evidence{LightMatrix::Zero(unknowns + errors, unknowns + errors),
                    LightVector::Zero(unknowns + errors)};
  evidence.normal.bottomRightCorner(errors, errors).setIdentity();
  for (int c = 0; c < 3; ++c) {
    const BasisMatrix& normal = reweighting.Normal(c);
    const BasisVector& gradient = reweighting.Gradient(c);
    evidence.normal.block(c * bases, c * bases, bases, bases) = normal.topLeftCorner(bases, bases);
    evidence.normal.block(c * bases, unknowns, bases, errors) =
        normal.topRightCorner(bases, errors);
    evidence.normal.block(unknowns, c * bases, errors, bases) =
        normal.bottomLeftCorner(errors, bases);
    evidence.normal.bottomRightCorner(errors, errors) += normal.bottomRightCorner(errors, errors);
    evidence.gradient.segment(c * bases, bases) = gradient.head(bases);
    evidence.gradient.tail(errors) += gradient.tail(errors);
  }
  if (errors > 0) evidence.gradient[unknowns + errors - 1] += problem.exponent_mean;
  for (const auto* error : {&problem.vignetting, &problem.saturation}) {
    if (error->place >= 0) evidence.gradient[unknowns + error->place] += error->mean;
  }
  return evidence;
}

// The errors are free to be as the lights want them: Schur's complement.
Evidence LightingFitter::Impl::WithoutErrors(const Evidence& with_errors) const {
  const int errors = problem.error_count;
  const int unknowns = problem.UnknownCount();
  Evidence evidence{with_errors.normal.topLeftCorner(unknowns, unknowns),
                    with_errors.gradient.head(unknowns)};
  if (errors == 0) return evidence;
  const LightMatrix inverse =
      InverseOf(with_errors.normal.bottomRightCorner(errors, errors).eval());
  const LightMatrix coupling = with_errors.normal.topRightCorner(unknowns, errors) * inverse;
  evidence.normal -= coupling * with_errors.normal.bottomLeftCorner(errors, unknowns);
  evidence.normal = (0.5 * (evidence.normal + evidence.normal.transpose())).eval();
  evidence.gradient -= coupling * with_errors.gradient.tail(errors);
  return evidence;
}

void LightingFitter::Impl::FindErrors(const Evidence& with_errors, const LightVector& x) {
  const int errors = problem.error_count;
  if (errors == 0) return;
  const LightMatrix inverse =
      InverseOf(with_errors.normal.bottomRightCorner(errors, errors).eval());
  camera_errors = inverse * (with_errors.gradient.tail(errors) -
                             with_errors.normal.bottomLeftCorner(errors, x.size()) * x);
}

Evidence LightingFitter::Impl::WithPrior(const Evidence& samples) const {
  return {samples.normal + prior_information, samples.gradient + prior_gradient};
}

// The last frame's light where it still holds: then a few passes are enough. Otherwise the robust
// start, so that light that is gone does not keep the samples that it explains.
LightVector LightingFitter::Impl::Begin() {
  const int unknowns = problem.UnknownCount();
  if (last_irradiance_rgb.size() == 3 + unknowns - (problem.has_sun ? 3 : 0)) {
    LightVector x(unknowns);
    for (int u = 0; u < unknowns; ++u) {
      const int c = u / problem.basis_count;
      x[u] = last_irradiance_rgb[problem.LightIndex(c, u % problem.basis_count)] /
             problem.irradiance_unit[c];
    }
    restarted = !reweighting.Explains(problem, {x, camera_errors}, options);
    if (!restarted) return x;
  }
  restarted = true;
  reweighting.Restart();
  ExpectErrors();
  return start.Find(problem, NoiseUnits(options), options.shared_error, options.seed);
}

// Reweighted least squares from a good start. The early passes are closed solves (they only
// bring the weights near); the last one, whose answer is given, is the chosen solver's.
LightVector LightingFitter::Impl::Iterate(const LightingPrior& prior,
                                          LightVector x,
                                          LightingFit& fit) {
  bool rescale = true;
  LightMatrix expected = prior_information;
  for (int pass = 0; pass < options.max_passes; ++pass) {
    if (rescale) {
      prior_information = fixed_prior_information;
      AddShapePrior(prior, x);
    }
    const bool knew_the_errors = reweighting.KnowsSharedErrors(problem);
    reweighting.Update(problem, {x, camera_errors}, expected, options, rescale);
    const Evidence with_errors = WithErrors();
    const Evidence samples = WithoutErrors(with_errors);
    if (rescale) mixture.ChooseGains(samples);
    mixture.Solve(WithPrior(samples),
                  rescale ? WeatherMixture::Which::kAll : WeatherMixture::Which::kLikely);
    const LightVector next = mixture.Light();
    FindErrors(with_errors, next);
    expected = prior_information + mixture.Information();
    const double change =
        (next - x).cwiseAbs().maxCoeff() / std::max(next.cwiseAbs().maxCoeff(), kWeakInformation);
    x = next;
    fit.passes = pass + 1;
    fit.converged = !rescale && change < kConverged;
    if (fit.converged) break;
    const bool have_settled = knew_the_errors && change < kScalesHaveSettled;
    rescale = rescale && pass + 1 < kMostPassesThatRescale && !have_settled;
  }
  mixture.Solve(WithPrior(WithoutErrors(WithErrors())), WeatherMixture::Which::kAll);
  if (options.solver == LightingFitOptions::Solver::kCeres) {
    const Evidence evidence = WithPrior(WithoutErrors(WithErrors()));
    fit.converged = mixture.Refine(evidence, ceres) && fit.converged;
  }
  reweighting.Whiten(problem);
  return mixture.Light();
}

LightVector LightingFitter::Impl::FitFrom(const LightingPrior& prior,
                                          LightVector x,
                                          LightingFit& fit) {
  LightVector found = Iterate(prior, std::move(x), fit);
  Describe(prior, found, fit);
  fit.picture_over_light_rgb = PictureOverLight(found);
  return found;
}

LightVector LightingFitter::Impl::WithSun(const LightingPrior& prior, const LightVector& x) const {
  const WeatherLight* sunniest = nullptr;
  for (const WeatherLight& weather : prior.weathers) {
    if (!sunniest || weather.light.mean[1] > sunniest->light.mean[1]) sunniest = &weather;
  }
  LightVector with_sun = x;
  if (!problem.has_sun || !sunniest) return {};
  const int bases = problem.basis_count;
  double before = 0.0;
  double after = 0.0;
  for (int c = 0; c < 3; ++c) {
    const SunAndSky& mean = sunniest->light.mean;
    double& sun = with_sun[c * bases];
    before += sun;
    sun = mean[c] / mean[3 + c] * x.segment(c * bases + 1, bases - 1).sum();
    after += sun;
  }
  // Nearer, and the fit would go to the same light from either.
  constexpr double kAnotherLight = 0.5;
  return before < kAnotherLight * after ? with_sun : LightVector();
}

// In a picture without sun, something that the mesh lacks may hide the sun from all surfaces that
// the mesh has in it. The fit without those samples is weighted by how improbable such shadows are.
void LightingFitter::Impl::WeighAgainstHiddenSun(const LightingPrior& prior,
                                                 const LightVector& x,
                                                 LightingFit& fit) {
  if (!restarted) return;
  LightVector start_with_sun = WithSun(prior, x);
  if (start_with_sun.size() == 0) return;
  const ErrorVector errors = camera_errors;
  reweighting.Restart();
  ExpectErrors();
  LightingFit other = fit;
  const LightVector y = FitFrom(prior, std::move(start_with_sun), other);
  // Mostly the fit goes to the same sun from either start.
  const Eigen::Vector3d apart = other.irradiance_rgb.head<3>() - fit.irradiance_rgb.head<3>();
  double share = 0.0;
  if (apart.squaredNorm() > fit.covariance.topLeftCorner<3, 3>().trace()) {
    const double log_odds = start.LogOdds(problem, NoiseUnits(options), options.shared_error, x, y);
    share = 1.0 / (1.0 + std::exp(-log_odds));
  }
  is_ambiguous = share > WeatherMixture::kLeastShare && share < 1.0 - WeatherMixture::kLeastShare;
  if (share > 0.5) std::swap(fit, other);
  if (is_ambiguous) Blend(other, std::min(share, 1.0 - share), fit);
  if (share > 0.5 || is_ambiguous) return;
  // The next frame continues from here.
  reweighting.Restart();
  camera_errors = errors;
  Iterate(prior, x, other);
}

LightingFitter::LightingFitter(const LightingFitOptions& options)
    : impl_(std::make_unique<Impl>(options)) {}
LightingFitter::~LightingFitter() = default;
LightingFitter::LightingFitter(LightingFitter&&) noexcept = default;
LightingFitter& LightingFitter::operator=(LightingFitter&&) noexcept = default;

LightingFit LightingFitter::Fit(std::span<const DiffuseSample> samples,
                                const LightingPrior& prior,
                                bool sun_is_up,
                                FitStart start) {
  const Eigen::Index lights = 3 * (1 + prior.sky_shapes);
  if (prior.sky_shapes < 1 || prior.sky_shapes > kMaxSkyShapes ||
      prior.information.rows() != lights || prior.information_times_mean.size() != lights) {
    throw std::invalid_argument("LightingPrior: sky_shapes is " + std::to_string(prior.sky_shapes) +
                                ", its matrix has " + std::to_string(prior.information.rows()) +
                                " rows");
  }
  if (prior.beam_shape >= prior.sky_shapes) {
    throw std::invalid_argument("LightingPrior: beam_shape is " + std::to_string(prior.beam_shape) +
                                ", expected less than the " + std::to_string(prior.sky_shapes) +
                                " shapes");
  }
  LightingFit fit;
  fit.sun_is_fitted = sun_is_up;
  fit.irradiance_rgb = LightVector::Zero(lights);
  impl_->options.shared_error = std::max(impl_->given_options.shared_error, prior.albedo_stddev);
  impl_->is_ambiguous = false;
  if (start == FitStart::kRobust) impl_->last_irradiance_rgb.resize(0);
  impl_->Load(samples, prior, sun_is_up, prior.camera.exponent);
  fit.samples_used = impl_->problem.sample_count;
  fit.samples_ignored = impl_->problem.ignored;
  LightVector x = impl_->FitFrom(prior, impl_->Begin(), fit);
  // Over lights fifty times apart, what the fit leaves out of g is 8 g^2 of them: below 0.1 %.
  constexpr double kIsLinear = 0.01;
  constexpr int kMostSteps = 4;
  bool is_new = impl_->restarted;
  for (int step = 0; step < kMostSteps; ++step) {
    if (!(std::abs(fit.exponent - impl_->problem.removed_exponent) > kIsLinear)) break;
    impl_->Load(samples, prior, sun_is_up, fit.exponent);
    impl_->last_irradiance_rgb = fit.irradiance_rgb;
    x = impl_->FitFrom(prior, impl_->Begin(), fit);
    is_new = is_new || impl_->restarted;
  }
  impl_->restarted = is_new;
  impl_->WeighAgainstHiddenSun(prior, x, fit);
  // A blend of two lights is neither of them.
  impl_->last_irradiance_rgb = impl_->is_ambiguous ? LightVector() : fit.irradiance_rgb;
  return fit;
}

void MarkRejected(const LightingFit& fit, std::span<DiffuseSample> samples) {
  for (DiffuseSample& sample : samples) sample.is_rejected = true;
  for (const std::int32_t inlier : fit.inliers) {
    samples[static_cast<std::size_t>(inlier)].is_rejected = false;
  }
}

}  // namespace pleinair
