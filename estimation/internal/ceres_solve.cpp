#include "estimation/internal/ceres_solve.h"

#include <algorithm>

#include <ceres/ceres.h>
#include <Eigen/QR>

namespace pleinair::estimation_internal {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A channel's rows and target, turned by their QR decomposition: |rows x - target|^2 is
// |r x - target|^2 and a constant, with as many rows as there are unknowns. So an iteration does
// not read all samples again.
struct ReducedChannel {
  BasisMatrix r;
  BasisVector target;
};

// residual = r x - target, Jacobian = r: all samples of one channel.
class ChannelCost : public ceres::CostFunction {
 public:
  explicit ChannelCost(int bases) {
    set_num_residuals(bases);
    mutable_parameter_block_sizes()->push_back(bases);
  }
  void Point(const ReducedChannel& channel) { channel_ = &channel; }

  bool Evaluate(const double* const* parameters,
                double* residuals,
                double** jacobians) const override {
    const int bases = parameter_block_sizes()[0];
    Eigen::Map<Eigen::VectorXd>(residuals, bases) =
        channel_->r * Eigen::Map<const Eigen::VectorXd>(parameters[0], bases) - channel_->target;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<RowMajor>(jacobians[0], bases, bases) = channel_->r;
    }
    return true;
  }

 private:
  const ReducedChannel* channel_ = nullptr;
};

// residual = root' x - target over the three channels' unknowns.
class PriorCost : public ceres::CostFunction {
 public:
  explicit PriorCost(int bases) {
    set_num_residuals(3 * bases);
    mutable_parameter_block_sizes()->assign(3, bases);
  }
  void Point(const LightMatrix& root, const LightVector& target) {
    root_ = &root;
    target_ = &target;
  }

  bool Evaluate(const double* const* parameters,
                double* residuals,
                double** jacobians) const override {
    const int bases = parameter_block_sizes()[0];
    Eigen::Map<Eigen::VectorXd> residual(residuals, num_residuals());
    residual = -*target_;
    for (int c = 0; c < 3; ++c) {
      const auto block = root_->middleRows(c * bases, bases).transpose();
      residual += block * Eigen::Map<const Eigen::VectorXd>(parameters[c], bases);
      if (jacobians != nullptr && jacobians[c] != nullptr) {
        Eigen::Map<RowMajor>(jacobians[c], num_residuals(), bases) = block;
      }
    }
    return true;
  }

 private:
  const LightMatrix* root_ = nullptr;
  const LightVector* target_ = nullptr;
};

}  // namespace

struct CeresSolver::Impl {
  int bases = -1;
  std::array<std::array<double, kMaxBasis>, 3> unknowns{};
  std::array<ReducedChannel, 3> channels;
  Eigen::MatrixXd rows_and_target;              // Of one channel, in the making.
  std::array<ChannelCost*, 3> channel_costs{};  // Owned by the problem.
  PriorCost* prior_cost = nullptr;              // Likewise.
  std::unique_ptr<ceres::Problem> problem;
  ceres::Solver::Options options;

  Impl() {
    options.num_threads = 1;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = 50;
    // The problem is linear but for its bounds: Gauss-Newton steps are exact.
    options.initial_trust_region_radius = 1e16;
    options.function_tolerance = 1e-14;
    options.gradient_tolerance = 1e-12;
    options.parameter_tolerance = 1e-12;
    options.jacobi_scaling = false;  // FitProblem's units make the unknowns alike.
  }

  void Reduce(const WhitenedChannel& channel, int basis_count, ReducedChannel& reduced) {
    const auto count = static_cast<Eigen::Index>(channel.target.size());
    rows_and_target.resize(count, basis_count + 1);
    rows_and_target.leftCols(basis_count) =
        Eigen::Map<const RowMajor>(channel.rows.data(), count, basis_count);
    rows_and_target.col(basis_count) =
        Eigen::Map<const Eigen::VectorXd>(channel.target.data(), count);
    reduced.r = BasisMatrix::Zero(basis_count, basis_count);
    reduced.target = BasisVector::Zero(basis_count);
    if (count == 0) return;
    const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(rows_and_target);
    const Eigen::Index kept = std::min<Eigen::Index>(count, basis_count);
    reduced.r.topRows(kept) =
        rows_and_target.topLeftCorner(kept, basis_count).triangularView<Eigen::Upper>();
    reduced.target.head(kept) = rows_and_target.col(basis_count).head(kept);
  }

  void Build(int basis_count) {
    bases = basis_count;
    problem = std::make_unique<ceres::Problem>();
    prior_cost = new PriorCost(bases);
    problem->AddResidualBlock(
        prior_cost, nullptr, unknowns[0].data(), unknowns[1].data(), unknowns[2].data());
    for (std::size_t c = 0; c < 3; ++c) {
      channel_costs[c] = new ChannelCost(bases);
      problem->AddResidualBlock(channel_costs[c], nullptr, unknowns[c].data());
      for (int j = 0; j < bases; ++j) {
        problem->SetParameterLowerBound(unknowns[c].data(), j, 0.0);
      }
    }
  }
};

CeresSolver::CeresSolver() : impl_(std::make_unique<Impl>()) {}
CeresSolver::~CeresSolver() = default;

bool CeresSolver::Solve(const Reweighting& samples,
                        const LightMatrix& prior_root,
                        const LightVector& prior_target,
                        LightVector& x) {
  const int basis_count = static_cast<int>(x.size()) / 3;
  if (basis_count != impl_->bases) impl_->Build(basis_count);
  impl_->prior_cost->Point(prior_root, prior_target);
  for (int c = 0; c < 3; ++c) {
    const auto channel = static_cast<std::size_t>(c);
    impl_->Reduce(samples.Channel(c), basis_count, impl_->channels[channel]);
    impl_->channel_costs[channel]->Point(impl_->channels[channel]);
    for (int j = 0; j < basis_count; ++j) {
      impl_->unknowns[channel][static_cast<std::size_t>(j)] = std::max(0.0, x[c * basis_count + j]);
    }
  }
  ceres::Solver::Summary summary;
  ceres::Solve(impl_->options, impl_->problem.get(), &summary);
  if (!summary.IsSolutionUsable()) return false;
  LightVector solved(x.size());
  for (int c = 0; c < 3; ++c) {
    for (int j = 0; j < basis_count; ++j) {
      solved[c * basis_count + j] =
          impl_->unknowns[static_cast<std::size_t>(c)][static_cast<std::size_t>(j)];
    }
  }
  if (!solved.allFinite()) return false;
  x = solved;
  return true;
}

}  // namespace pleinair::estimation_internal
