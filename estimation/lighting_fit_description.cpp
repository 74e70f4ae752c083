// The uncertainty of the fit's result.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "estimation/internal/lighting_fitter.h"
#include "estimation/internal/square.h"
#include "estimation/internal/symmetric_algebra.h"

namespace pleinair {
namespace {

using namespace estimation_internal;  // The folder's own.

// A normal distribution's second moment about `origin`, of the part of it that is not negative.
double NonNegativeSquare(double mean, double stddev, double origin) {
  const double a = -mean / stddev;
  // phi(a) / (1 - Phi(a)), and the argument from which its series is more accurate.
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

// sum over samples of J J' between all pairs of channels, each pair times the correlation of its
// noise: the variance of the estimating equations, over lights and camera errors. The diagonal
// blocks of the lights are those of WithErrors.
LightMatrix LightingFitter::Impl::SampleVariance() const {
  const int bases = problem.basis_count;
  const int errors = problem.error_count;
  const int unknowns = problem.UnknownCount();
  LightMatrix variance = LightMatrix::Zero(unknowns + errors, unknowns + errors);
  const auto add = [&](int c, int d, const auto& cross) {
    variance.block(c * bases, d * bases, bases, bases) = cross.topLeftCorner(bases, bases);
    variance.block(c * bases, unknowns, bases, errors) += cross.topRightCorner(bases, errors);
    variance.block(unknowns, d * bases, errors, bases) += cross.bottomLeftCorner(errors, bases);
    variance.bottomRightCorner(errors, errors) += cross.bottomRightCorner(errors, errors);
  };
  for (int c = 0; c < 3; ++c) {
    add(c, c, reweighting.Normal(c));
    for (int d = 0; d < c; ++d) {
      const BasisMatrix cross = reweighting.CrossNormal(c, d);
      add(c, d, cross);
      add(d, c, cross.transpose());
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

// At its bound a light has one side only, and the samples' distribution of it is the tail of a
// normal one. The variance is its second moment about the estimate, for the sun and for the entire
// sky.
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
      picture[c] += weight * problem.InPicture(v);
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
  if (const auto& error = problem.veil; error.place >= 0) {
    fit.veil = error.stddev * camera_errors[error.place];
  }
  LightMatrix normal = with_errors.normal;
  normal.topLeftCorner(unknowns, unknowns) += prior_information + mixture.Information();
  const LightMatrix covariance = InverseOf(normal);
  const auto deviation_of = [&](int error) {
    return std::sqrt(covariance(unknowns + error, unknowns + error));
  };
  if (const auto& error = problem.vignetting; error.place >= 0) {
    fit.vignetting = error.stddev * camera_errors[error.place];
    fit.vignetting_stddev = error.stddev * deviation_of(error.place);
  }
  if (const auto& error = problem.saturation; error.place >= 0) {
    fit.saturation = error.stddev * camera_errors[error.place];
    fit.saturation_stddev = error.stddev * deviation_of(error.place);
  }
  if (camera.exponent_stddev > 0.0) {
    const int last = problem.error_count - 1;
    fit.exponent = problem.removed_exponent + camera.exponent_stddev * camera_errors[last];
    fit.exponent_stddev = camera.exponent_stddev * deviation_of(last);
  }
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

  // Covariance of the mixture: that of each weather, and its distance from the estimate.
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
  fit.inliers.clear();
  for (std::size_t i = 0; i < reweighting.Weights().size(); ++i) {
    if (reweighting.Weights()[i] > 0.0) fit.inliers.push_back(problem.source[i]);
  }
  fit.relative_residual = reweighting.RelativeResidual();
  fit.shared_error = reweighting.SharedError();
  DescribeCamera(prior.camera, with_errors, fit);
  DescribeWeathers(samples.normal + prior_information, fit);
}

// The samples' covariance of sun and sky, the same for all weathers.
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

// As over weathers: the light is between the mean and the likelier one's, and what is stated about
// it is that of the mixture.
void Blend(const LightingFit& other, double share, LightingFit& fit) {
  const double kept = 1.0 - share;
  const double weight = Cube(share) / (Cube(share) + Cube(kept));
  const LightVector apart = other.irradiance_rgb - fit.irradiance_rgb;
  const double about = kept * Square(weight) + share * Square(1.0 - weight);
  fit.irradiance_rgb += weight * apart;
  fit.covariance =
      (kept * fit.covariance + share * other.covariance + about * apart * apart.transpose()).eval();
  SunAndSky sums = SunAndSky::Zero();
  for (Eigen::Index u = 0; u < apart.size(); ++u) {
    sums[u < 3 ? u : 3 + u % 3] += apart[u];
  }
  for (int c = 0; c < 3; ++c) {
    // Where the samples say nothing of the sun if it is hidden, what else is known of it counts.
    fit.sun_stddev_data_rgb[c] =
        std::sqrt(kept * Square(fit.sun_stddev_data_rgb[c]) + share * other.covariance(c, c) +
                  about * Square(apart[c]));
  }
  fit.data_covariance += about * sums * sums.transpose();
  for (std::size_t w = 0; w < fit.weathers.size(); ++w) {
    WeatherFit& weather = fit.weathers[w];
    const WeatherFit& of_other = other.weathers[w];
    if (share * of_other.share > kept * weather.share) weather.light = of_other.light;
    weather.share = kept * weather.share + share * of_other.share;
  }
}

}  // namespace pleinair
