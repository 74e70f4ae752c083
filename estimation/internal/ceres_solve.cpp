#include "estimation/internal/ceres_solve.h"

#include <algorithm>
#include <cmath>
#include <vector>

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

// residual = r x - target: all samples of one channel, whose unknowns are a block each.
class ChannelCost : public ceres::CostFunction {
 public:
  explicit ChannelCost(int bases) {
    set_num_residuals(bases);
    mutable_parameter_block_sizes()->assign(static_cast<std::size_t>(bases), 1);
  }
  void Point(const ReducedChannel& channel) { channel_ = &channel; }

  bool Evaluate(const double* const* parameters,
                double* residuals,
                double** jacobians) const override {
    Eigen::Map<Eigen::VectorXd> residual(residuals, num_residuals());
    residual = -channel_->target;
    for (int j = 0; j < num_residuals(); ++j) {
      residual += parameters[j][0] * channel_->r.col(j);
      if (jacobians != nullptr && jacobians[j] != nullptr) {
        Eigen::Map<Eigen::VectorXd>(jacobians[j], num_residuals()) = channel_->r.col(j);
      }
    }
    return true;
  }

 private:
  const ReducedChannel* channel_ = nullptr;
};

// residual = root' x - target over the three channels' unknowns.
class PriorCost : public ceres::CostFunction {
 public:
  explicit PriorCost(int unknowns) {
    set_num_residuals(unknowns);
    mutable_parameter_block_sizes()->assign(static_cast<std::size_t>(unknowns), 1);
  }
  void Point(const LightMatrix& root, const LightVector& target) {
    root_ = &root;
    target_ = &target;
  }

  bool Evaluate(const double* const* parameters,
                double* residuals,
                double** jacobians) const override {
    Eigen::Map<Eigen::VectorXd> residual(residuals, num_residuals());
    residual = -*target_;
    for (int u = 0; u < num_residuals(); ++u) {
      residual += parameters[u][0] * root_->row(u).transpose();
      if (jacobians != nullptr && jacobians[u] != nullptr) {
        Eigen::Map<Eigen::VectorXd>(jacobians[u], num_residuals()) = root_->row(u).transpose();
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
  std::array<double, kMaxLightUnknowns> unknowns{};
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
    options.max_num_iterations = 10;
    // The problem is linear: Gauss-Newton steps are exact.
    options.initial_trust_region_radius = 1e16;
    options.jacobi_scaling = false;  // FitProblem's units make the unknowns alike.
  }

  void Reduce(const WhitenedChannel& channel, ReducedChannel& reduced) {
    const auto count = static_cast<Eigen::Index>(channel.target.size());
    rows_and_target.resize(count, bases + 1);
    rows_and_target.leftCols(bases) = Eigen::Map<const RowMajor>(channel.rows.data(), count, bases);
    rows_and_target.col(bases) = Eigen::Map<const Eigen::VectorXd>(channel.target.data(), count);
    reduced.r = BasisMatrix::Zero(bases, bases);
    reduced.target = BasisVector::Zero(bases);
    if (count == 0) return;
    const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(rows_and_target);
    const Eigen::Index kept = std::min<Eigen::Index>(count, bases);
    reduced.r.topRows(kept) =
        rows_and_target.topLeftCorner(kept, bases).triangularView<Eigen::Upper>();
    reduced.target.head(kept) = rows_and_target.col(bases).head(kept);
  }

  void Build(int basis_count) {
    bases = basis_count;
    problem = std::make_unique<ceres::Problem>();
    std::vector<double*> blocks;
    blocks.reserve(static_cast<std::size_t>(3 * bases));
    for (int u = 0; u < 3 * bases; ++u) blocks.push_back(&unknowns[static_cast<std::size_t>(u)]);
    prior_cost = new PriorCost(3 * bases);
    problem->AddResidualBlock(prior_cost, nullptr, blocks);
    for (int c = 0; c < 3; ++c) {
      auto& cost = channel_costs[static_cast<std::size_t>(c)];
      cost = new ChannelCost(bases);
      const auto first = blocks.begin() + c * bases;
      problem->AddResidualBlock(cost, nullptr, std::vector<double*>(first, first + bases));
    }
  }

  // The unknowns that are `held` stay at 0; the others start at one unit each, not where the closed
  // solve ended: there Ceres would agree without having worked.
  bool SolveFree(const std::array<bool, kMaxLightUnknowns>& held) {
    bool any = false;
    for (int u = 0; u < 3 * bases; ++u) {
      const auto index = static_cast<std::size_t>(u);
      unknowns[index] = held[index] ? 0.0 : 1.0;
      any = any || !held[index];
      if (held[index]) {
        problem->SetParameterBlockConstant(&unknowns[index]);
      } else {
        problem->SetParameterBlockVariable(&unknowns[index]);
      }
    }
    if (!any) return true;
    ceres::Solver::Summary summary;
    ceres::Solve(options, problem.get(), &summary);
    return summary.IsSolutionUsable();
  }
};

CeresSolver::CeresSolver() : impl_(std::make_unique<Impl>()) {}
CeresSolver::~CeresSolver() = default;

bool CeresSolver::Solve(const Reweighting& samples,
                        const LightMatrix& prior_root,
                        const LightVector& prior_target,
                        LightVector& x) {
  const Eigen::Index count = x.size();
  const int bases = static_cast<int>(count) / 3;
  if (bases != impl_->bases) impl_->Build(bases);
  impl_->prior_cost->Point(prior_root, prior_target);
  LightMatrix normal = prior_root * prior_root.transpose();
  LightVector gradient = prior_root * prior_target;
  for (int c = 0; c < 3; ++c) {
    ReducedChannel& channel = impl_->channels[static_cast<std::size_t>(c)];
    impl_->Reduce(samples.Channel(c), channel);
    impl_->channel_costs[static_cast<std::size_t>(c)]->Point(channel);
    normal.block(c * bases, c * bases, bases, bases) += channel.r.transpose() * channel.r;
    gradient.segment(c * bases, bases) += channel.r.transpose() * channel.target;
  }

  std::array<bool, kMaxLightUnknowns> held{};
  for (Eigen::Index u = 0; u < count; ++u) held[static_cast<std::size_t>(u)] = !(x[u] > 0.0);
  // One round where the active set of `x` is right.
  for (Eigen::Index round = 0; round < 2 * count; ++round) {
    if (!impl_->SolveFree(held)) return false;
    const Eigen::Map<const Eigen::VectorXd> solved(impl_->unknowns.data(), count);
    if (!solved.allFinite()) return false;
    const LightVector descent = gradient - normal * solved;
    bool settled = true;
    for (Eigen::Index u = 0; u < count; ++u) {
      bool& is_held = held[static_cast<std::size_t>(u)];
      const double rounding = 1e-12 * std::sqrt(normal(u, u)) * gradient.norm();
      if (is_held ? descent[u] > rounding : solved[u] < 0.0) {
        is_held = !is_held;
        settled = false;
      }
    }
    if (settled) {
      x = solved;
      return true;
    }
  }
  return false;
}

}  // namespace pleinair::estimation_internal
