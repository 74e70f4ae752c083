#include "estimation/internal/symmetric_algebra.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace pleinair::estimation_internal {

LightMatrix InverseOf(const LightMatrix& symmetric) {
  return symmetric.ldlt().solve(LightMatrix::Identity(symmetric.rows(), symmetric.cols()));
}

LightMatrix LowerRootOf(const LightMatrix& positive) { return positive.llt().matrixL(); }

LightVector SolveLower(const LightMatrix& root, const LightVector& right) {
  return root.triangularView<Eigen::Lower>().solve(right);
}

LightMatrix SolveLower(const LightMatrix& root, const LightMatrix& right) {
  return root.triangularView<Eigen::Lower>().solve(right);
}

LightVector SolvePositive(const LightMatrix& positive, const LightVector& right) {
  return positive.llt().solve(right);
}

Eigen::Matrix3d InverseOfAtLeast(const Eigen::Matrix3d& symmetric, double least) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(symmetric);
  const Eigen::Vector3d values = eigen.eigenvalues().cwiseMax(least);
  return eigen.eigenvectors() * values.cwiseInverse().asDiagonal() *
         eigen.eigenvectors().transpose();
}

LightVector EigenvaluesOf(const LightMatrix& symmetric) {
  return Eigen::SelfAdjointEigenSolver<LightMatrix>(symmetric, Eigen::EigenvaluesOnly)
      .eigenvalues();
}

std::optional<EigenDecomposition> DecompositionOf(const LightMatrix& symmetric) {
  const Eigen::SelfAdjointEigenSolver<LightMatrix> eigen(symmetric);
  if (eigen.info() != Eigen::Success) return std::nullopt;
  return EigenDecomposition{eigen.eigenvalues(), eigen.eigenvectors()};
}

}  // namespace pleinair::estimation_internal
