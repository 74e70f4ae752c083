#include "estimation/lighting_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "estimation/internal/bounded_quadratic.h"
#include "estimation/internal/ceres_solve.h"
#include "estimation/internal/fit_problem.h"
#include "estimation/internal/reweighting.h"
#include "estimation/internal/robust_start.h"
#include "estimation/internal/symmetric_algebra.h"

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

// Where only the ratio of the clear sky's sun and sky is known, its row is
//   sun - kSunPriorMean ratio sky = 0, give or take kSunPriorSigma times the mean of the two ways
//   to
// tell the beam, 2/3 (sun + ratio sky): the prior of absolute light at the prior's mean, and no
// rigid row where the sky or the sun is 0.
constexpr double kRatioSigma = kSunPriorSigma * 2.0 / 3.0;

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
  LightingFitOptions options;
  FitProblem problem;
  RobustStart start;
  Reweighting reweighting;
  CeresSolver ceres;

  // In the fit's own units and order.
  LightMatrix prior_information;
  LightVector prior_gradient;
  LightMatrix fixed_prior_information;  // Without the rows that are relative to the light found.

  // What the last call found, in the prior's units and order; empty before.
  LightVector last_irradiance_rgb;

  explicit Impl(const LightingFitOptions& fit_options) : options(fit_options) {
    options.Validate();
  }

  void LoadPrior(const LightingPrior& prior);
  void UpdateRelativePriors(const LightingPrior& prior, const LightVector& x);
  void AddRatioPrior(const LightingPrior& prior, const LightVector& x);
  double BeamIn(const LightingPrior& prior, const LightVector& x) const;
  void AddShapePrior(const LightingPrior& prior, const LightVector& x);
  LightVector Begin();
  LightMatrix DataNormal() const;
  LightVector SolveClosed() const;
  LightVector Iterate(const LightingPrior& prior, LightingFit& fit);
  LightMatrix CrossChannelNormal() const;
  void Describe(const LightVector& x, LightingFit& fit) const;
  double ConditionNumber() const;
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

void LightingFitter::Impl::UpdateRelativePriors(const LightingPrior& prior, const LightVector& x) {
  prior_information = fixed_prior_information;
  AddRatioPrior(prior, x);
  AddShapePrior(prior, x);
}

void LightingFitter::Impl::AddRatioPrior(const LightingPrior& prior, const LightVector& x) {
  if (!problem.has_sun || !(prior.sun_to_sky_weight > 0.0)) return;
  const int bases = problem.basis_count;
  for (int c = 0; c < 3; ++c) {
    const double ratio = prior.sun_to_sky_rgb[c];
    if (!(ratio > 0.0)) continue;
    BasisVector row = BasisVector::Constant(bases, -kSunPriorMean * ratio);
    row[0] = 1.0;
    double beam = x[c * bases];
    for (int j = 1; j < bases; ++j) beam += ratio * x[c * bases + j];
    const double sigma = kRatioSigma * beam;
    if (!(sigma > 0.0)) continue;
    prior_information.block(c * bases, c * bases, bases, bases) +=
        prior.sun_to_sky_weight / (sigma * sigma) * row * row.transpose();
  }
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
  // A black sky's shares mean nothing; its rows only have to stay finite.
  constexpr double kLeastSky = 1e-3;
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

LightMatrix LightingFitter::Impl::DataNormal() const {
  const int bases = problem.basis_count;
  LightMatrix normal = LightMatrix::Zero(problem.UnknownCount(), problem.UnknownCount());
  for (int c = 0; c < 3; ++c) {
    normal.block(c * bases, c * bases, bases, bases) = reweighting.Normal(c);
  }
  return normal;
}

LightVector LightingFitter::Impl::SolveClosed() const {
  LightVector gradient = prior_gradient;
  for (int c = 0; c < 3; ++c) {
    gradient.segment(c * problem.basis_count, problem.basis_count) += reweighting.Gradient(c);
  }
  return MinimiseNonNegative(DataNormal() + prior_information, gradient);
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
    if (reweighting.Explains(problem, x, options)) return x;
  }
  reweighting.Forget();
  return start.Find(problem, NoiseUnits(options), options.seed);
}

// Reweighted least squares from a good start. The early passes are closed solves (they only
// bring the weights near); the last one, whose answer is given, is the chosen solver's.
LightVector LightingFitter::Impl::Iterate(const LightingPrior& prior, LightingFit& fit) {
  LightVector x = Begin();
  bool rescale = true;
  for (int pass = 0; pass < options.max_passes; ++pass) {
    if (rescale) UpdateRelativePriors(prior, x);
    const bool knew_the_errors = reweighting.KnowsSharedErrors(problem);
    reweighting.Update(problem, x, prior_information, options, rescale);
    const LightVector next = SolveClosed();
    const double change =
        (next - x).cwiseAbs().maxCoeff() / std::max(next.cwiseAbs().maxCoeff(), kWeakInformation);
    x = next;
    fit.passes = pass + 1;
    fit.converged = !rescale && change < kConverged;
    if (fit.converged) break;
    const bool have_settled = knew_the_errors && change < kScalesHaveSettled;
    rescale = rescale && pass + 1 < kMostPassesThatRescale && !have_settled;
  }
  reweighting.Whiten(problem);
  if (options.solver == LightingFitOptions::Solver::kCeres) {
    const LightMatrix root = LowerRootOf(prior_information);
    const LightVector target = SolveLower(root, prior_gradient);
    fit.converged = ceres.Solve(reweighting, root, target, x) && fit.converged;
  }
  return x;
}

// sum over samples of J J' between all pairs of channels, each pair times the correlation of its
// noise: the variance of the estimating equations. The diagonal blocks are DataNormal()'s.
LightMatrix LightingFitter::Impl::CrossChannelNormal() const {
  const int bases = problem.basis_count;
  LightMatrix normal = DataNormal();
  for (int c = 0; c < 3; ++c) {
    for (int d = 0; d < c; ++d) {
      const BasisMatrix cross = reweighting.CrossNormal(c, d);
      normal.block(c * bases, d * bases, bases, bases) = cross;
      normal.block(d * bases, c * bases, bases, bases) = cross.transpose();
    }
  }
  return normal;
}

double LightingFitter::Impl::ConditionNumber() const {
  double largest = 0.0;
  double smallest = std::numeric_limits<double>::infinity();
  for (int c = 0; c < 3; ++c) {
    const BasisMatrix& normal = reweighting.Normal(c);
    // The Jacobian's singular values squared.
    const LightVector values = EigenvaluesOf(normal);
    largest = std::max(largest, values.maxCoeff());
    smallest = std::min(smallest, values.minCoeff());
  }
  // They carry the rounding of the largest.
  constexpr double kRounding = 1e-14;
  if (!(smallest > kRounding * largest)) return std::numeric_limits<double>::infinity();
  return std::sqrt(largest / smallest);
}

void LightingFitter::Impl::Describe(const LightVector& x, LightingFit& fit) const {
  const int bases = problem.basis_count;
  const int unknowns = problem.UnknownCount();
  const LightMatrix identity = LightMatrix::Identity(unknowns, unknowns);

  const LightMatrix inverse = InverseOf(DataNormal() + prior_information);
  LightMatrix covariance = inverse * (CrossChannelNormal() + prior_information) * inverse;
  covariance = (0.5 * (covariance + covariance.transpose())).eval();
  const LightMatrix data = DataNormal() + kWeakInformation * identity;

  const Eigen::Index lights = fit.irradiance_rgb.size();
  fit.covariance = LightMatrix::Zero(lights, lights);
  fit.data_information = LightMatrix::Zero(lights, lights);
  for (int u = 0; u < unknowns; ++u) {
    const int cu = u / bases;
    const int lu = problem.LightIndex(cu, u % bases);
    fit.irradiance_rgb[lu] = x[u] * problem.irradiance_unit[cu];
    for (int v = 0; v < unknowns; ++v) {
      const int cv = v / bases;
      const int lv = problem.LightIndex(cv, v % bases);
      const double unit = problem.irradiance_unit[cu] * problem.irradiance_unit[cv];
      fit.covariance(lu, lv) = covariance(u, v) * unit;
      fit.data_information(lu, lv) = data(u, v) / unit;
    }
  }
  for (int c = 0; c < 3 && problem.has_sun; ++c) {
    const BasisMatrix block = data.block(c * bases, c * bases, bases, bases);
    fit.sun_stddev_data_rgb[c] = std::sqrt(InverseOf(block)(0, 0)) * problem.irradiance_unit[c];
  }
  fit.condition_number = ConditionNumber();
  fit.inlier_fraction = reweighting.InlierFraction();
  fit.relative_residual = reweighting.RelativeResidual();
  fit.shared_error = reweighting.SharedError();
  fit.sky_shape_error = reweighting.SkyShapeError();
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
  impl_->problem.Load(samples, prior.sky_shapes, sun_is_up, prior.scale_rgb);
  fit.samples_used = impl_->problem.sample_count;
  fit.samples_ignored = impl_->problem.ignored;
  impl_->LoadPrior(prior);
  const LightVector x = impl_->Iterate(prior, fit);
  impl_->Describe(x, fit);
  impl_->last_irradiance_rgb = fit.irradiance_rgb;
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
