// Estimates the sizes of the errors that reweighting uses, from the residuals of a pass.
#include "estimation/internal/reweighting.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimation/internal/square.h"
#include "estimation/internal/symmetric_algebra.h"

namespace pleinair::estimation_internal {
namespace {

// The median of |x| of a Gaussian is 0.6745 standard deviations.
constexpr double kSigmaOfMedian = 1.4826;
// For a distribution cut off at 2.5 standard deviations: 0.6640.
constexpr double kFarOff = 2.5;
constexpr double kSigmaOfMedianWithoutFarOff = 1.5060;
// Weight of the expected errors, as a number of samples, cells or planes.
constexpr double kPriorCount = 1.0;
// Of albedo across a plane. A guessed albedo may be wrong by more, but on all of its plane.
constexpr double kMostTrend = 0.05;

}  // namespace

// Median of deviations, which are reordered.
double Reweighting::ScaleOf(std::vector<double>& deviations,
                            double unknowns,
                            const LightingFitOptions& options) {
  if (deviations.empty()) return options.expected_noise;
  const double samples = static_cast<double>(deviations.size());
  const double lost = std::sqrt(samples / std::max(1.0, samples - unknowns));
  // nth_element leaves nothing before it that is above it, and nothing behind it that is below.
  auto middle = deviations.begin() + static_cast<std::ptrdiff_t>(deviations.size() / 2);
  std::nth_element(deviations.begin(), middle, deviations.end());
  double scale = kSigmaOfMedian * lost * *middle;
  // 40 % of wrong samples double that median. It is computed twice more without the samples that
  // are outliers by it, so that an inflated scale recovers (Rousseeuw and Leroy, Robust Regression
  // and Outlier Detection, chapter 5). All outliers are above the median.
  for (int round = 0; round < 2; ++round) {
    const auto near = static_cast<std::ptrdiff_t>(deviations.size()) -
                      std::count_if(middle, deviations.end(), [&](double deviation) {
                        return deviation > kFarOff * scale;
                      });
    const auto next = deviations.begin() + near / 2;
    if (next < middle) std::nth_element(deviations.begin(), next, middle);
    middle = next;
    scale = kSigmaOfMedianWithoutFarOff * lost * *middle;
  }
  // Few samples are fitted too well for their median to mean anything.
  return std::sqrt(Square(scale) + Square(options.expected_noise) * unknowns / samples);
}

void Reweighting::EstimateScale(const FitProblem& problem, const LightingFitOptions& options) {
  const double shade_from = ShadeFrom();
  scratch_.resize(deviation_.size());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < deviation_.size(); ++i) {
    scratch_[kept] = deviation_[i];
    kept += shade_[i] > shade_from ? 0 : 1;
  }
  scratch_.resize(kept);
  scale_ = ScaleOf(scratch_, problem.basis_count, options);
}

// psi' of the residual vector r of a sample is w I + (dw/dd) / (3 d) r r'.
void Reweighting::EstimateSlope(const LightingFitOptions& options) {
  if (!(mean_weight_ > 0.0)) {  // All are left out.
    inverse_slope_.setIdentity();
    return;
  }
  Eigen::Matrix3d outer = Eigen::Matrix3d::Zero();
  const auto add = [&](const auto& share_of) {
    for (std::size_t i = 0; i < weight_.size(); ++i) {
      const Eigen::Map<const Eigen::Vector3d> r(residual_.data() + i * 3);
      outer += share_of(i) * r * r.transpose();
    }
    outer /= static_cast<double>(weight_.size());
  };
  switch (options.loss) {
    case LightingFitOptions::Loss::kTukey:
      add([&](std::size_t i) { return std::sqrt(weight_[i]); });
      outer *= -(4.0 / 3.0) * Square(1.0 / (options.tukey_width * scale_));
      break;
    case LightingFitOptions::Loss::kHuber:  // dw/dd = -w / d past the bend.
      add([&](std::size_t i) {
        return weight_[i] < 1.0 ? -weight_[i] / (3.0 * Square(deviation_[i])) : 0.0;
      });
      break;
    case LightingFitOptions::Loss::kSquares:
      break;
  }
  const Eigen::Matrix3d slope = mean_weight_ * Eigen::Matrix3d::Identity() + outer;
  // A slope near 0 or below is caused by a handful of samples beside the cut, and would give an
  // infinite variance. The limit of a quarter gives a sixteenfold one.
  inverse_slope_ = InverseOfAtLeast(slope, 0.25 * mean_weight_);
}

void Reweighting::EstimateNoise(const FitProblem& problem, const LightingFitOptions& options) {
  const auto count = weight_.size();
  cell_inliers_.assign(problem.plane_of_cell.size(), 0.0);
  plane_inliers_.assign(static_cast<std::size_t>(problem.plane_count), 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    if (weight_[i] > 0.0) cell_inliers_[static_cast<std::size_t>(problem.cell[i])] += 1.0;
  }
  for (std::size_t cell = 0; cell < cell_inliers_.size(); ++cell) {
    plane_inliers_[static_cast<std::size_t>(problem.plane_of_cell[cell])] += cell_inliers_[cell];
  }
  // Within the planes, where they share an error: their means are no noise then.
  double inliers = 0.0;
  double degrees = 0.0;
  for (const double in_plane : plane_inliers_) {
    inliers += in_plane;
    degrees += std::max(0.0, in_plane - 1.0);
  }
  const bool within = options.shared_error > 0.0 && degrees >= problem.basis_count;
  if (!within) degrees = std::max(0.0, inliers - problem.basis_count);

  Eigen::Matrix3d psi = Eigen::Matrix3d::Zero();
  cell_psi_.assign(cell_inliers_.size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < count; ++i) {
    const double* mean = plane_residual_.data() + problem.plane[i] * 3;
    Eigen::Vector3d r;
    for (std::size_t c = 0; c < 3; ++c) {
      const double of_plane = within && inverse_unit_[i * 3 + c] > 0.0 ? mean[c] : 0.0;
      r[static_cast<Eigen::Index>(c)] = weight_[i] * (residual_[i * 3 + c] - of_plane);
    }
    psi.noalias() += r * r.transpose();
    cell_psi_[static_cast<std::size_t>(problem.cell[i])] += r;
  }
  const double mean_square = degrees > 0.0 ? psi.trace() / degrees : 0.0;
  // mean(psi psi') over all samples; lost degrees of freedom are those of the inliers.
  if (degrees > 0.0) psi *= inliers / (degrees * static_cast<double>(count));
  const Eigen::Matrix3d from_data = mean_weight_ * inverse_slope_ * psi * inverse_slope_;
  noise_ = (degrees * from_data +
            kPriorCount * Square(options.expected_noise) * Eigen::Matrix3d::Identity()) /
           (degrees + kPriorCount);
  own_variance_ = noise_.trace() / 3.0;
  if (within) noise_ *= DesignEffect(problem, mean_square);
  const Eigen::Vector3d inverse_sigma = noise_.diagonal().cwiseSqrt().cwiseInverse();
  correlation_ = inverse_sigma.asDiagonal() * noise_ * inverse_sigma.asDiagonal();
}

// From the sums of psi over cells of neighbours. With independent errors, the expected square of
// such a sum is `mean_square` (m - m^2 / M). Here m and M are the inliers of the cell and of its
// plane, whose mean is subtracted.
double Reweighting::DesignEffect(const FitProblem& problem, double mean_square) const {
  double squares = 0.0;
  double expected = 0.0;
  double degrees = 0.0;
  for (const double in_plane : plane_inliers_) degrees -= in_plane > 0.0 ? 1.0 : 0.0;
  for (std::size_t cell = 0; cell < cell_psi_.size(); ++cell) {
    const double in_cell = cell_inliers_[cell];
    if (!(in_cell > 0.0)) continue;
    const auto plane = static_cast<std::size_t>(problem.plane_of_cell[cell]);
    squares += cell_psi_[cell].squaredNorm();
    expected += mean_square * (in_cell - Square(in_cell) / plane_inliers_[plane]);
    degrees += 1.0;
  }
  if (!(degrees > 0.0) || !(expected > 0.0)) return 1.0;
  return std::max(1.0, (kPriorCount + degrees * squares / expected) / (kPriorCount + degrees));
}

// One-way analysis of variance over the planes. One picture cannot distinguish albedo from the
// sky's shape: both errors are e times the expected ones. The residual r of a plane's mean has a
// variance of (1 - h) (n / W + e^2 (t^2 + s^2 (v^2 + u^2))). Here h is the part that the fitted
// lights remove, known from the last pass.
void Reweighting::EstimateSharedErrors(const FitProblem& problem,
                                       const LightMatrix& prior_information,
                                       const LightingFitOptions& options) {
  double error_squared = 1.0;
  if (KnowsSharedErrors(problem)) {
    const Eigen::Index bases = problem.basis_count;
    std::array<BasisMatrix, 3> covariance;
    for (std::size_t c = 0; c < 3; ++c) {
      const Eigen::Index first = static_cast<Eigen::Index>(c) * bases;
      covariance[c] = InverseOf(last_normal_[c].topLeftCorner(bases, bases) +
                                prior_information.block(first, first, bases, bases));
    }
    // Where another light than the samples' is held by the prior, all planes are off by a factor:
    // no word on their errors.
    witnesses_.clear();
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();
    Eigen::Vector3d weights = Eigen::Vector3d::Zero();
    for (int plane = 0; plane < problem.plane_count; ++plane) {
      const Witness& witness = witnesses_.emplace_back(WitnessOf(plane, covariance, options));
      shift += witness.weight.cwiseProduct(witness.shift);
      weights += witness.weight;
    }
    shift = shift.cwiseQuotient(weights.cwiseMax(std::numeric_limits<double>::min()));
    double excess = 0.0;
    double degrees = 0.0;
    for (const Witness& witness : witnesses_) {
      int channels = 0;
      double of_excess = 0.0;
      double of_degrees = 0.0;
      for (int c = 0; c < 3; ++c) {
        if (!(witness.weight[c] > 0.0)) continue;
        const double kept = 1.0 - witness.weight[c] / weights[c];
        of_excess +=
            witness.weight[c] * (Square(witness.shift[c] - shift[c]) - kept * witness.alone[c]);
        of_degrees += kept * witness.degrees[c];
        ++channels;
      }
      if (channels == 0) continue;
      excess += of_excess / channels;
      degrees += of_degrees / channels;
    }
    error_squared = std::max(0.0, (kPriorCount + excess) / (kPriorCount + degrees));
  }
  error_ = std::sqrt(error_squared);
  shared_error_ = error_ * options.shared_error;
  trend_error_ = std::min(shared_error_, kMostTrend);
  sky_shape_error_ = error_ * options.sky_shape_error;
}

// One value for all channels: the error of an albedo is mostly common to them.
Reweighting::Witness Reweighting::WitnessOf(int plane,
                                            const std::array<BasisMatrix, 3>& covariance,
                                            const LightingFitOptions& options) const {
  const Eigen::Index bases = covariance[0].rows();
  const auto first = static_cast<std::size_t>(plane) * 3;
  // A shift of the whole plane moves its weighted mean less than that: its far samples lose weight.
  const Eigen::Vector3d shift =
      mean_weight_ * inverse_slope_ * Eigen::Map<const Eigen::Vector3d>(&plane_residual_[first]);
  Witness witness;
  witness.shift = shift;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t i = first + c;
    const auto ci = static_cast<Eigen::Index>(c);
    const auto columns = static_cast<std::size_t>(normal_[0].rows());
    const Eigen::Map<const BasisVector> row(plane_row_.data() + i * columns, bases);
    const double expected =
        Square(options.shared_error) +
        Square(options.sky_shape_error) * (Square(sky_mean_[i]) + Square(sky_per_sun_[i] * row[0]));
    // Below the weight of one sample a mean says more about the weights than about the plane.
    if (!(plane_weight_[i] >= 1.0) || !(expected > 0.0)) continue;
    const double alone = noise_(ci, ci) / plane_weight_[i];
    // Where the samples' own errors are the larger a mean says little of the shared one.
    const double determined = Square(expected / (expected + alone));
    const double taken =
        std::min(1.0, row.dot(covariance[c] * row) / (alone + Square(error_) * expected));
    witness.weight[ci] = determined / expected;
    witness.alone[ci] = (1.0 - taken) * alone;
    witness.degrees[ci] = determined * (1.0 - taken);
  }
  return witness;
}

}  // namespace pleinair::estimation_internal
