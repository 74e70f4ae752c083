#include "estimation/internal/ceres_solve.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <ceres/ceres.h>

#include "estimation/internal/symmetric_algebra.h"

namespace pleinair::estimation_internal {
namespace {

// residual = root' x - target.
class GaussianCost : public ceres::CostFunction {
 public:
  explicit GaussianCost(int unknowns) {
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
  int count = -1;
  std::array<double, kMaxLightUnknowns> unknowns{};
  LightMatrix root;
  LightVector target;
  std::unique_ptr<ceres::Problem> problem;
  ceres::Solver::Options options;

  Impl() {
    options.num_threads = 1;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = 10;
    // The problem is linear: Gauss-Newton steps are exact.
    options.initial_trust_region_radius = 1e16;
    options.jacobi_scaling = false;  // FitProblem's units give the unknowns similar sizes.
  }

  void Build(int unknown_count) {
    count = unknown_count;
    problem = std::make_unique<ceres::Problem>();
    std::vector<double*> blocks;
    blocks.reserve(static_cast<std::size_t>(count));
    for (int u = 0; u < count; ++u) blocks.push_back(&unknowns[static_cast<std::size_t>(u)]);
    auto* cost = new GaussianCost(count);
    cost->Point(root, target);
    problem->AddResidualBlock(cost, nullptr, blocks);
  }

  // The unknowns that are `held` stay at 0; the others start at one unit each, not where the closed
  // solve ended: there Ceres would agree without having worked.
  bool SolveFree(const std::array<bool, kMaxLightUnknowns>& held) {
    bool any = false;
    for (int u = 0; u < count; ++u) {
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

bool CeresSolver::Solve(const LightMatrix& normal, const LightVector& gradient, LightVector& x) {
  const Eigen::Index count = x.size();
  if (count != impl_->count) impl_->Build(static_cast<int>(count));
  impl_->root = LowerRootOf(normal);
  impl_->target = SolveLower(impl_->root, gradient);

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
