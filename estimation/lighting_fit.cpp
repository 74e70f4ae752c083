#include "estimation/lighting_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "estimation/internal/ceres_solve.h"
#include "estimation/internal/fit_problem.h"
#include "estimation/internal/reweighting.h"
#include "estimation/internal/robust_start.h"
#include "estimation/internal/square.h"
#include "estimation/internal/symmetric_algebra.h"
#include "estimation/internal/weather_mixture.h"

namespace pleinair {
namespace {

using namespace estimation_internal;  // The folder's own.

// The scales settle within a few passes: they are kept once the light moves by less than this, a
// small part of any standard deviation, so that the weights can converge.
constexpr double kScalesHaveSettled = 5e-4;
constexpr int kMostPassesThatRescale = 8;
// A thousandth of a deviation at most, far above rounding.
constexpr double kConverged = 1e-5;

// The weak prior: an unknown of 0, give or take a hundred times the light that explains the median
// sample. It keeps every matrix regular, and costs a fit that 10 samples with 5 % of noise carry
// (100)^-2 / (10 / 0.05^2) < 1e-7 of itself.
constexpr double kWeakInformation = 1e-4;

// A normal distribution's second moment about `origin`, of the part of it that is not negative.
double NonNegativeSquare(double mean, double stddev, double origin) {
  const double a = -mean / stddev;
  // phi(a) / (1 - Phi(a)), and from where on its series is the better way to tell it.
  constexpr double kFar = 6.0;
  if (a > kFar) {
    const double first = stddev / a * (1.0 - 2.0 / Square(a));
    const double second = 2.0 * Square(stddev / a) * (1.0 - 5.0 / Square(a));
    return second - 2.0 * origin * first + Square(origin);
  }
  const double hazard = std::sqrt(2.0 / std::numbers::pi) * std::exp(-0.5 * Square(a)) /
                        std::erfc(a / std::numbers::sqrt2);
  const double first = mean + stddev * hazard;
  const double second = Square(mean) + Square(stddev) + mean * stddev * hazard;
  return second - 2.0 * origin * first + Square(origin);
}

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

bool TellsTheSun(const LightingFit& fit, double clear_sky_beam) {
  const glm::dvec3& sigma = fit.sun_stddev_data_rgb;
  // Infinite without any samples, whose deviation is in a unit of nothing.
  return fit.sun_is_fitted && std::isfinite(fit.condition_number) &&
         (sigma.x + sigma.y + sigma.z) / 3.0 < kObservableSunSigma * clear_sky_beam;
}

struct LightingFitter::Impl {
  const LightingFitOptions given_options;
  LightingFitOptions options;  // Of this call: the prior may know less of the albedos.
  FitProblem problem;
  RobustStart start;
  Reweighting reweighting;
  WeatherMixture mixture;
  CeresSolver ceres;

  // In the fit's own units and order: the common factor of the prior.
  LightMatrix prior_information;
  LightVector prior_gradient;
  LightMatrix fixed_prior_information;  // Without the rows that are relative to the light found.

  // What the last call found, in the prior's units and order; empty before.
  LightVector last_irradiance_rgb;
  ErrorVector camera_errors;  // In standard deviations.

  explicit Impl(const LightingFitOptions& fit_options)
      : given_options(fit_options), options(fit_options) {
    options.Validate();
  }

  void LoadPrior(const LightingPrior& prior);
  double BeamIn(const LightingPrior& prior, const LightVector& x) const;
  void AddShapePrior(const LightingPrior& prior, const LightVector& x);
  LightVector Begin();
  // What the samples say of lights and camera errors together, those last and with their prior.
  Evidence WithErrors() const;
  Evidence WithoutErrors(const Evidence& with_errors) const;
  void FindErrors(const Evidence& with_errors, const LightVector& x);
  Evidence WithPrior(const Evidence& samples) const;
  LightVector Iterate(const LightingPrior& prior, LightingFit& fit);
  LightMatrix SampleVariance() const;
  LightMatrix CovarianceOf(const WeatherSolution& solution,
                           const Evidence& with_errors,
                           const LightMatrix& variance) const;
  void WidenAtBounds(const WeatherSolution& solution,
                     const Evidence& evidence,
                     LightMatrix& covariance) const;
  void Describe(const LightingPrior& prior, const LightVector& x, LightingFit& fit) const;
  glm::dvec3 PictureOverLight(const LightVector& x) const;
  void DescribeCamera(const CameraErrors& camera,
                      const Evidence& with_errors,
                      LightingFit& fit) const;
  double ConditionNumber(const LightMatrix& normal) const;
  void DescribeWeathers(const LightMatrix& normal, LightingFit& fit) const;
};

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

// How much there is of the beam that comes with a shape's light: 1 from a tenth of the clear sky's
// sun over sky on, which thin cloud lets through and still brightens around the sun. Where that
// would be a twentieth of the sky's light or less, as at sunset, a sun that is not found says
// nothing: 1 too, by and by.
double LightingFitter::Impl::BeamIn(const LightingPrior& prior, const LightVector& x) const {
  constexpr double kEnough = 0.1;
  constexpr double kTellingRatio = 0.5;
  const int bases = problem.basis_count;
  double sun = 0.0;
  double sky = 0.0;
  double clear_sun = 0.0;  // Over such a sky, were it clear.
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
//   (s_k - p_k S) / S of one channel - the same of another = 0   likewise the colour's spread,
// their denominators and p_k being those of `x`. They are 0 for any S: the sky's sum is left to the
// data. All m_k are alike, but without its beam that of the shape that comes with one is 0, give or
// take a tenth: an overcast sky's walls and ground differ by little between shapes, and a few per
// cent of error within a plane would choose.
void LightingFitter::Impl::AddShapePrior(const LightingPrior& prior, const LightVector& x) {
  const int bases = problem.basis_count;
  const int first = problem.has_sun ? 1 : 0;
  const int shapes = bases - first;
  if (shapes < 2) return;
  // Shares of a sky that is black at `x`, which may be no more than a bad start, mean nothing: they
  // are those of a tenth of the light that explains the median sample.
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
  if (problem.exponent_stddev > 0.0)
    evidence.gradient[unknowns + errors - 1] = problem.expected_exponent;
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

// The last frame's light where it still holds: then a few passes do. Otherwise the robust start, so
// that a light that is gone cannot keep what it explains.
LightVector LightingFitter::Impl::Begin() {
  const int unknowns = problem.UnknownCount();
  if (last_irradiance_rgb.size() == 3 + unknowns - (problem.has_sun ? 3 : 0)) {
    LightVector x(unknowns);
    for (int u = 0; u < unknowns; ++u) {
      const int c = u / problem.basis_count;
      x[u] = last_irradiance_rgb[problem.LightIndex(c, u % problem.basis_count)] /
             problem.irradiance_unit[c];
    }
    if (reweighting.Explains(problem, x, camera_errors, options)) return x;
  }
  reweighting.Forget();
  camera_errors.setZero();
  return start.Find(problem, NoiseUnits(options), options.seed);
}

// Reweighted least squares from a good start. The early passes are closed solves (they only
// bring the weights near); the last one, whose answer is given, is the chosen solver's.
LightVector LightingFitter::Impl::Iterate(const LightingPrior& prior, LightingFit& fit) {
  LightVector x = Begin();
  bool rescale = true;
  LightMatrix expected = prior_information;
  for (int pass = 0; pass < options.max_passes; ++pass) {
    if (rescale) {
      prior_information = fixed_prior_information;
      AddShapePrior(prior, x);
    }
    const bool knew_the_errors = reweighting.KnowsSharedErrors(problem);
    reweighting.Update(problem, x, camera_errors, expected, options, rescale);
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

// sum over samples of J J' between all pairs of channels, each pair times the correlation of its
// noise: the variance of the estimating equations, over lights and camera errors. The diagonal
// blocks of the lights are those of WithErrors.
LightMatrix LightingFitter::Impl::SampleVariance() const {
  const int bases = problem.basis_count;
  const int errors = problem.error_count;
  const int unknowns = problem.UnknownCount();
  LightMatrix variance = LightMatrix::Zero(unknowns + errors, unknowns + errors);
  for (int c = 0; c < 3; ++c) {
    for (int d = 0; d < 3; ++d) {
      const BasisMatrix cross = c == d ? reweighting.Normal(c) : reweighting.CrossNormal(c, d);
      variance.block(c * bases, d * bases, bases, bases) = cross.topLeftCorner(bases, bases);
      variance.block(c * bases, unknowns, bases, errors) += cross.topRightCorner(bases, errors);
      variance.block(unknowns, d * bases, errors, bases) += cross.bottomLeftCorner(errors, bases);
      variance.bottomRightCorner(errors, errors) += cross.bottomRightCorner(errors, errors);
    }
  }
  return variance;
}

LightMatrix LightingFitter::Impl::CovarianceOf(const WeatherSolution& solution,
                                               const Evidence& with_errors,
                                               const LightMatrix& variance) const {
  const int errors = problem.error_count;
  const int unknowns = problem.UnknownCount();
  // The errors' own prior is in with_errors.
  LightMatrix prior = LightMatrix::Zero(unknowns + errors, unknowns + errors);
  prior.topLeftCorner(unknowns, unknowns) = prior_information + solution.information;
  const LightMatrix inverse = InverseOf(with_errors.normal + prior);
  prior.bottomRightCorner(errors, errors).setIdentity();
  const LightMatrix covariance = inverse * (variance + prior) * inverse;
  return (0.5 * (covariance + covariance.transpose())).topLeftCorner(unknowns, unknowns);
}

// At its bound a light has one side only, and what the samples say of it is the tail of a normal
// distribution: its second moment about the answer. Of the sun, and of the sky as a whole.
void LightingFitter::Impl::WidenAtBounds(const WeatherSolution& solution,
                                         const Evidence& evidence,
                                         LightMatrix& covariance) const {
  const int bases = problem.basis_count;
  const int first_sky = problem.has_sun ? 1 : 0;
  const LightVector unbounded = SolvePositive(evidence.normal + solution.information,
                                              evidence.gradient + solution.information_times_mean);
  const auto widen = [&](int channel, int first, int count) {
    const int at = channel * bases + first;
    const double variance = covariance.block(at, at, count, count).sum();
    if (!(variance > 0.0)) return;
    const double factor = std::sqrt(NonNegativeSquare(unbounded.segment(at, count).sum(),
                                                      std::sqrt(variance),
                                                      solution.light.segment(at, count).sum()) /
                                    variance);
    covariance.middleRows(at, count) *= factor;
    covariance.middleCols(at, count) *= factor;
  };
  for (int c = 0; c < 3; ++c) {
    if (problem.has_sun) widen(c, 0, 1);
    widen(c, first_sky, bases - first_sky);
  }
}

// Over the channels: of each by itself.
double LightingFitter::Impl::ConditionNumber(const LightMatrix& normal) const {
  const int bases = problem.basis_count;
  double largest = 0.0;
  double smallest = std::numeric_limits<double>::infinity();
  for (int c = 0; c < 3; ++c) {
    // The Jacobian's singular values squared.
    const LightVector values =
        EigenvaluesOf(normal.block(c * bases, c * bases, bases, bases).eval());
    largest = std::max(largest, values.maxCoeff());
    smallest = std::min(smallest, values.minCoeff());
  }
  // They carry the rounding of the largest.
  constexpr double kRounding = 1e-14;
  if (!(smallest > kRounding * largest)) return std::numeric_limits<double>::infinity();
  return std::sqrt(largest / smallest);
}

// Mean radiance of the samples over that of their light alone: what a response that is not the
// stated one makes of light as bright as theirs. A picture of unknown exposure is drawn into with
// light in its own units, so these are the ones to report.
glm::dvec3 LightingFitter::Impl::PictureOverLight(const LightVector& x) const {
  if (!(problem.exponent_stddev > 0.0)) return glm::dvec3(1.0);
  glm::dvec3 picture(0.0);
  glm::dvec3 light(0.0);
  for (int i = 0; i < problem.sample_count; ++i) {
    const double weight = reweighting.Weights()[static_cast<std::size_t>(i)];
    for (int c = 0; c < 3; ++c) {
      const auto v = static_cast<std::size_t>(i * 3 + c);
      if (!(problem.weight[v] > 0.0)) continue;
      const double* row = problem.Transport(i, c);
      picture[c] += weight * problem.radiance[v];
      for (int j = 0; j < problem.basis_count; ++j) {
        light[c] += weight * row[j] * x[c * problem.basis_count + j];
      }
    }
  }
  for (int c = 0; c < 3; ++c) {
    picture[c] = picture[c] > 0.0 && light[c] > 0.0 ? picture[c] / light[c] : 1.0;
  }
  return picture;
}

void LightingFitter::Impl::DescribeCamera(const CameraErrors& camera,
                                          const Evidence& with_errors,
                                          LightingFit& fit) const {
  if (problem.error_count == 0) return;
  const int unknowns = problem.UnknownCount();
  if (camera.veil_stddev > 0.0) fit.veil = camera.veil_stddev * camera_errors[0];
  if (!(camera.exponent_stddev > 0.0)) return;
  LightMatrix normal = with_errors.normal;
  normal.topLeftCorner(unknowns, unknowns) += prior_information + mixture.Information();
  const int last = problem.error_count - 1;
  fit.exponent = camera.exponent_stddev * camera_errors[last];
  fit.exponent_stddev =
      camera.exponent_stddev * std::sqrt(InverseOf(normal)(unknowns + last, unknowns + last));
}

void LightingFitter::Impl::Describe(const LightingPrior& prior,
                                    const LightVector& x,
                                    LightingFit& fit) const {
  const int bases = problem.basis_count;
  const int unknowns = problem.UnknownCount();
  const LightMatrix identity = LightMatrix::Identity(unknowns, unknowns);
  const Evidence with_errors = WithErrors();
  const Evidence samples = WithoutErrors(with_errors);
  const Evidence evidence = WithPrior(samples);
  const LightMatrix variance = SampleVariance();

  // Of the mixture: each weather's own, and how far it is from the answer.
  LightMatrix covariance = LightMatrix::Zero(unknowns, unknowns);
  double shares = 0.0;
  for (const WeatherSolution& solution : mixture.Solutions()) {
    if (!(solution.share > WeatherMixture::kLeastShare)) continue;
    LightMatrix own = CovarianceOf(solution, with_errors, variance);
    WidenAtBounds(solution, evidence, own);
    const LightVector apart = solution.light - x;
    covariance += solution.share * (own + apart * apart.transpose());
    shares += solution.share;
  }
  covariance /= shares;
  const LightMatrix data = samples.normal + kWeakInformation * identity;
  const LightMatrix data_covariance = InverseOf(data);

  const Eigen::Index lights = fit.irradiance_rgb.size();
  fit.covariance = LightMatrix::Zero(lights, lights);
  for (int u = 0; u < unknowns; ++u) {
    const int cu = u / bases;
    const int lu = problem.LightIndex(cu, u % bases);
    fit.irradiance_rgb[lu] = x[u] * problem.irradiance_unit[cu];
    for (int v = 0; v < unknowns; ++v) {
      const int cv = v / bases;
      const int lv = problem.LightIndex(cv, v % bases);
      fit.covariance(lu, lv) =
          covariance(u, v) * problem.irradiance_unit[cu] * problem.irradiance_unit[cv];
    }
  }
  for (int c = 0; c < 3 && problem.has_sun; ++c) {
    fit.sun_stddev_data_rgb[c] =
        std::sqrt(data_covariance(c * bases, c * bases)) * problem.irradiance_unit[c];
  }
  fit.condition_number = ConditionNumber(samples.normal);
  fit.inlier_fraction = reweighting.InlierFraction();
  fit.relative_residual = reweighting.RelativeResidual();
  fit.shared_error = reweighting.SharedError();
  fit.sky_shape_error = reweighting.SkyShapeError();
  DescribeCamera(prior.camera, with_errors, fit);
  DescribeWeathers(samples.normal + prior_information, fit);
}

// The samples' word on the sums that weathers speak of, once for all weathers.
void LightingFitter::Impl::DescribeWeathers(const LightMatrix& normal, LightingFit& fit) const {
  const int bases = problem.basis_count;
  const int unknowns = problem.UnknownCount();
  Eigen::Matrix<double, Eigen::Dynamic, 6, 0, kMaxFitUnknowns, 6> sums =
      Eigen::Matrix<double, Eigen::Dynamic, 6, 0, kMaxFitUnknowns, 6>::Zero(unknowns, 6);
  for (int u = 0; u < unknowns; ++u) {
    const int c = u / bases;
    const bool is_sun = problem.has_sun && u % bases == 0;
    sums(u, is_sun ? c : 3 + c) = problem.irradiance_unit[c];
  }
  const LightMatrix covariance = InverseOf(normal);
  fit.data_covariance = sums.transpose() * covariance * sums;
  fit.weathers.clear();
  for (const WeatherSolution& solution : mixture.Solutions()) {
    WeatherFit& weather = fit.weathers.emplace_back();
    weather.share = solution.share;
    weather.gain = solution.gain;
    weather.log_evidence = solution.log_evidence;
    if (solution.share > WeatherMixture::kLeastShare) {
      weather.light = sums.transpose() * solution.light;
    }
  }
}

LightingFitter::LightingFitter(const LightingFitOptions& options)
    : impl_(std::make_unique<Impl>(options)) {}
LightingFitter::~LightingFitter() = default;
LightingFitter::LightingFitter(LightingFitter&&) noexcept = default;
LightingFitter& LightingFitter::operator=(LightingFitter&&) noexcept = default;

LightingFit LightingFitter::Fit(std::span<const DiffuseSample> samples,
                                const LightingPrior& prior,
                                bool sun_is_up) {
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
  impl_->problem.Load(samples, prior.sky_shapes, sun_is_up, prior.camera, prior.scale_rgb);
  if (impl_->camera_errors.size() != impl_->problem.error_count) {
    impl_->camera_errors = ErrorVector::Zero(impl_->problem.error_count);
  }
  fit.samples_used = impl_->problem.sample_count;
  fit.samples_ignored = impl_->problem.ignored;
  impl_->options.shared_error = std::max(impl_->given_options.shared_error, prior.albedo_stddev);
  impl_->LoadPrior(prior);
  impl_->mixture.Load(prior, impl_->problem);
  const LightVector x = impl_->Iterate(prior, fit);
  impl_->Describe(prior, x, fit);
  impl_->last_irradiance_rgb = fit.irradiance_rgb;
  fit.picture_over_light_rgb = impl_->PictureOverLight(x);
  return fit;
}

void LightingFitter::Forget() { impl_->last_irradiance_rgb.resize(0); }

LightingFit FitLighting(std::span<const DiffuseSample> samples,
                        const LightingPrior& prior,
                        bool sun_is_up,
                        const LightingFitOptions& options) {
  return LightingFitter(options).Fit(samples, prior, sun_is_up);
}

}  // namespace pleinair
