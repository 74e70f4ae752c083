// The decompositions that the estimate needs, in one place: their templates take long to compile.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "estimation/lighting_prior.h"

namespace pleinair::estimation_internal {

// Inverse of a symmetric matrix; not finite where it is singular.
LightMatrix InverseOf(const LightMatrix& symmetric);

// The lower triangular root of a positive definite matrix: root root' = positive.
LightMatrix LowerRootOf(const LightMatrix& positive);
// root^-1 right, for a lower triangular root.
LightVector SolveLower(const LightMatrix& root, const LightVector& right);
LightMatrix SolveLower(const LightMatrix& root, const LightMatrix& right);
// positive^-1 right.
LightVector SolvePositive(const LightMatrix& positive, const LightVector& right);

// Inverse of a symmetric matrix whose eigenvalues below `least` are raised to it.
Eigen::Matrix3d InverseOfAtLeast(const Eigen::Matrix3d& symmetric, double least);

// Eigenvalues of a symmetric matrix, ascending.
LightVector EigenvaluesOf(const LightMatrix& symmetric);
// With the eigenvectors, as columns; none where they are not found.
struct EigenDecomposition {
  LightVector values;
  LightMatrix vectors;
};
std::optional<EigenDecomposition> DecompositionOf(const LightMatrix& symmetric);

}  // namespace pleinair::estimation_internal
