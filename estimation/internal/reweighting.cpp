#include "estimation/internal/reweighting.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "estimation/internal/median.h"

namespace pleinair::estimation_internal {
namespace {

// The median of |x| of a Gaussian is 0.6745 standard deviations.
constexpr double kSigmaOfMedian = 1.4826;
// Of one cut off at 2.5 standard deviations, 0.6640.
constexpr double kFarOff = 2.5;
constexpr double kSigmaOfMedianWithoutFarOff = 1.5060;
// What is expected before the data have spoken counts as so many samples, or strata.
constexpr double kNoisePriorCount = 1.0;
constexpr double kSharedPriorCount = 4.0;

double Square(double value) { return value * value; }

}  // namespace

void Reweighting::Update(const FitProblem& problem,
                         const LightVector& x,
                         const LightingFitOptions& options,
                         bool rescale) {
  Standardise(problem, x, options);
  Weigh(problem, options, rescale);
  AverageStrata(problem);
  if (rescale) {
    EstimateNoise(problem, options);
    EstimateSharedError(problem, options);
  }
  Whiten(problem);
}

void Reweighting::Standardise(const FitProblem& problem,
                              const LightVector& x,
                              const LightingFitOptions& options) {
  const NoiseUnits noise(options);
  const int bases = problem.basis_count;
  const auto count = static_cast<std::size_t>(problem.sample_count);
  inverse_unit_.resize(count * 3);
  residual_.resize(count * 3);
  deviation_.resize(count);
  const double* row = problem.transport.data();
  for (std::size_t i = 0; i < count; ++i) {
    double sum = 0.0;
    int channels = 0;
    for (int c = 0; c < 3; ++c, row += bases) {
      const std::size_t v = i * 3 + static_cast<std::size_t>(c);
      inverse_unit_[v] = 0.0;
      residual_[v] = 0.0;
      if (!(problem.weight[v] > 0.0)) continue;
      double predicted = 0.0;
      for (int j = 0; j < bases; ++j) predicted += row[j] * x[c * bases + j];
      inverse_unit_[v] = 1.0 / noise.Unit(predicted, problem.noise[v], problem.weight[v]);
      residual_[v] = (problem.radiance[v] - predicted) * inverse_unit_[v];
      sum += Square(residual_[v]);
      ++channels;
    }
    deviation_[i] = std::sqrt(sum / channels);
  }
}

void Reweighting::EstimateScale(const FitProblem& problem, const LightingFitOptions& options) {
  const double samples = static_cast<double>(deviation_.size());
  const double unknowns = problem.basis_count;
  const double lost = std::sqrt(samples / std::max(1.0, samples - unknowns));
  scratch_.assign(deviation_.begin(), deviation_.end());
  double scale = kSigmaOfMedian * lost * UpperMedian(scratch_);
  // 40 % of wrong samples double that median. Once more without what is far off by it (Rousseeuw
  // and Leroy, Robust Regression and Outlier Detection, chapter 5), twice, so that a scale that was
  // drawn out lets go.
  for (int round = 0; round < 2; ++round) {
    std::erase_if(scratch_, [&](double deviation) { return deviation > kFarOff * scale; });
    if (scratch_.empty()) break;
    scale = kSigmaOfMedianWithoutFarOff * lost * UpperMedian(scratch_);
  }
  // Few samples are fitted too well for their median to mean anything.
  scale_ = std::sqrt(Square(scale) + Square(options.expected_noise) * unknowns / samples);
}

void Reweighting::Weigh(const FitProblem& problem,
                        const LightingFitOptions& options,
                        bool rescale) {
  const auto count = static_cast<std::size_t>(problem.sample_count);
  if (rescale && count > 0) {
    EstimateScale(problem, options);
  }
  weight_.resize(count);
  const double inverse_cut = 1.0 / (options.tukey_width * scale_);
  for (std::size_t i = 0; i < count; ++i) {
    weight_[i] = Square(std::max(0.0, 1.0 - Square(deviation_[i] * inverse_cut)));
  }
  if (!rescale || count == 0) return;

  // psi' of the residual vector of a sample: w I + (dw/dd) / (3 d) r r'.
  Eigen::Matrix3d slope = Eigen::Matrix3d::Zero();
  double mean_weight = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Map<const Eigen::Vector3d> r(residual_.data() + i * 3);
    mean_weight += weight_[i];
    slope.diagonal().array() += weight_[i];
    slope -= (4.0 / 3.0) * std::sqrt(weight_[i]) * Square(inverse_cut) * r * r.transpose();
  }
  mean_weight /= static_cast<double>(count);
  slope /= static_cast<double>(count);
  // A slope near 0 or below comes from a handful of samples beside the cut; it would claim an
  // infinite variance, a quarter claims a sixteenfold one.
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(slope);
  const Eigen::Vector3d values = eigen.eigenvalues().cwiseMax(0.25 * mean_weight);
  const Eigen::Matrix3d inverse =
      eigen.eigenvectors() * values.cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose();
  noise_of_psi_ = std::sqrt(mean_weight) * inverse;
}

void Reweighting::AverageStrata(const FitProblem& problem) {
  const int bases = problem.basis_count;
  const auto cells = static_cast<std::size_t>(problem.stratum_count) * 3;
  stratum_weight_.assign(cells, 0.0);
  stratum_residual_.assign(cells, 0.0);
  stratum_target_.assign(cells, 0.0);
  stratum_row_.assign(cells * static_cast<std::size_t>(bases), 0.0);
  const double* row = problem.transport.data();
  for (std::size_t i = 0; i < weight_.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c, row += bases) {
      const std::size_t v = i * 3 + c;
      const double weight = inverse_unit_[v] > 0.0 ? weight_[i] : 0.0;
      if (!(weight > 0.0)) continue;
      const std::size_t cell = static_cast<std::size_t>(problem.stratum[i]) * 3 + c;
      stratum_weight_[cell] += weight;
      stratum_residual_[cell] += weight * residual_[v];
      stratum_target_[cell] += weight * inverse_unit_[v] * problem.radiance[v];
      double* mean_row = stratum_row_.data() + cell * static_cast<std::size_t>(bases);
      for (int j = 0; j < bases; ++j) mean_row[j] += weight * inverse_unit_[v] * row[j];
    }
  }
  for (std::size_t cell = 0; cell < cells; ++cell) {
    if (!(stratum_weight_[cell] > 0.0)) continue;
    const double inverse = 1.0 / stratum_weight_[cell];
    stratum_residual_[cell] *= inverse;
    stratum_target_[cell] *= inverse;
    double* mean_row = stratum_row_.data() + cell * static_cast<std::size_t>(bases);
    for (int j = 0; j < bases; ++j) mean_row[j] *= inverse;
  }
}

void Reweighting::EstimateNoise(const FitProblem& problem, const LightingFitOptions& options) {
  const auto count = weight_.size();
  // Within the strata, where they share an error: their means are no noise then.
  scratch_.assign(static_cast<std::size_t>(problem.stratum_count), 0.0);
  double inliers = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    if (!(weight_[i] > 0.0)) continue;
    inliers += 1.0;
    scratch_[static_cast<std::size_t>(problem.stratum[i])] += 1.0;
  }
  double degrees = 0.0;
  for (const double in_stratum : scratch_) degrees += std::max(0.0, in_stratum - 1.0);
  const bool within = options.shared_error > 0.0 && degrees >= problem.basis_count;
  if (!within) degrees = std::max(0.0, inliers - problem.basis_count);

  Eigen::Matrix3d psi = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    if (!(weight_[i] > 0.0)) continue;
    Eigen::Vector3d r(residual_[i * 3], residual_[i * 3 + 1], residual_[i * 3 + 2]);
    if (within) {
      const double* mean = stratum_residual_.data() + problem.stratum[i] * 3;
      for (int c = 0; c < 3; ++c) {
        if (inverse_unit_[i * 3 + static_cast<std::size_t>(c)] > 0.0) r[c] -= mean[c];
      }
    }
    psi += Square(weight_[i]) * r * r.transpose();
  }
  // mean(psi psi') over all samples; lost degrees of freedom are those of the inliers.
  if (degrees > 0.0) psi *= inliers / (degrees * static_cast<double>(count));
  const Eigen::Matrix3d from_data = noise_of_psi_ * psi * noise_of_psi_.transpose();
  noise_ = (degrees * from_data +
            kNoisePriorCount * Square(options.expected_noise) * Eigen::Matrix3d::Identity()) /
           (degrees + kNoisePriorCount);
  const Eigen::Vector3d inverse_sigma = noise_.diagonal().cwiseSqrt().cwiseInverse();
  correlation_ = inverse_sigma.asDiagonal() * noise_ * inverse_sigma.asDiagonal();
}

void Reweighting::EstimateSharedError(const FitProblem& problem,
                                      const LightingFitOptions& options) {
  shared_error_ = 0.0;
  if (!(options.shared_error > 0.0)) return;
  double excess = 0.0;
  double strata = 0.0;
  for (int g = 0; g < problem.stratum_count; ++g) {
    double sum = 0.0;
    int channels = 0;
    for (int c = 0; c < 3; ++c) {
      const auto cell = static_cast<std::size_t>(g * 3 + c);
      // Below the weight of one sample a mean says more about the weights than about the stratum.
      if (!(stratum_weight_[cell] >= 1.0)) continue;
      sum += Square(stratum_residual_[cell]) - noise_(c, c) / stratum_weight_[cell];
      ++channels;
    }
    if (channels == 0) continue;
    excess += sum / channels;
    strata += 1.0;
  }
  // The fitted lights took as many means away.
  const double degrees = std::max(0.0, strata - problem.basis_count);
  const double variance =
      (kSharedPriorCount * Square(options.shared_error) + excess) / (kSharedPriorCount + degrees);
  shared_error_ = std::sqrt(std::max(0.0, variance));
}

void Reweighting::Whiten(const FitProblem& problem) {
  const int bases = problem.basis_count;
  const auto count = weight_.size();
  scratch_.resize(static_cast<std::size_t>(problem.stratum_count) * 3);
  for (std::size_t cell = 0; cell < scratch_.size(); ++cell) {
    const auto c = static_cast<Eigen::Index>(cell % 3);
    scratch_[cell] =
        1.0 - 1.0 / std::sqrt(1.0 + Square(shared_error_) * stratum_weight_[cell] / noise_(c, c));
  }
  for (std::size_t c = 0; c < 3; ++c) {
    WhitenedChannel& channel = channels_[c];
    channel.rows.resize(count * static_cast<std::size_t>(bases));
    channel.target.resize(count);
    const auto ci = static_cast<Eigen::Index>(c);
    const double inverse_sigma = 1.0 / std::sqrt(noise_(ci, ci));
    double* out = channel.rows.data();
    for (std::size_t i = 0; i < count; ++i, out += bases) {
      const std::size_t v = i * 3 + c;
      const double factor = inverse_unit_[v] > 0.0 ? std::sqrt(weight_[i]) * inverse_sigma : 0.0;
      const std::size_t cell = static_cast<std::size_t>(problem.stratum[i]) * 3 + c;
      const double* row = problem.transport.data() + v * static_cast<std::size_t>(bases);
      const double* mean_row = stratum_row_.data() + cell * static_cast<std::size_t>(bases);
      for (int j = 0; j < bases; ++j) {
        out[j] = factor * (inverse_unit_[v] * row[j] - scratch_[cell] * mean_row[j]);
      }
      channel.target[i] = factor * (inverse_unit_[v] * problem.radiance[v] -
                                    scratch_[cell] * stratum_target_[cell]);
    }
  }
}

double Reweighting::InlierFraction() const {
  if (weight_.empty()) return 0.0;
  const auto inliers =
      std::count_if(weight_.begin(), weight_.end(), [](double w) { return w > 0.0; });
  return static_cast<double>(inliers) / static_cast<double>(weight_.size());
}

double Reweighting::RelativeResidual() const {
  double weights = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < weight_.size(); ++i) {
    weights += weight_[i];
    squares += weight_[i] * Square(deviation_[i]);
  }
  return weights > 0.0 ? std::sqrt(squares / weights) : 0.0;
}

}  // namespace pleinair::estimation_internal
