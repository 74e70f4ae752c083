// The same bounded solve by Ceres.
#pragma once

#include <memory>

#include "estimation/lighting_prior.h"

namespace pleinair::estimation_internal {

// One residual block of as many rows as there are unknowns, whatever the number of samples: a block
// per sample would cost ten times as much (bench/estimation_bench.cpp). Kept from call to call
// while the number of unknowns stays the same.
class CeresSolver {
 public:
  CeresSolver();
  ~CeresSolver();

  // argmin over x >= 0 of |root' x - root^-1 gradient|^2, root being the lower Cholesky factor of
  // the positive definite `normal`. Ceres solves for the unknowns that are not held at 0: at first
  // those above 0 in `x`. Those that would leave their bound, or crossed it, then change sides, and
  // it solves again. (Ceres' own bounds bring a line search that does not end at an unknown's
  // bound: 126 steps for one frame.) Returns false where this does not converge; x is then
  // unchanged.
  bool Solve(const LightMatrix& normal, const LightVector& gradient, LightVector& x);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pleinair::estimation_internal
