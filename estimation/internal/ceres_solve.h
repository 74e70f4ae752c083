// The same bounded solve by Ceres, over the samples themselves.
#pragma once

#include <array>
#include <memory>

#include "estimation/internal/reweighting.h"
#include "estimation/lighting_prior.h"

namespace pleinair::estimation_internal {

// Four residual blocks of a few rows, whatever the number of samples: one per channel, its samples
// turned by QR to as many rows as there are unknowns, and the prior. A block per sample would cost
// ten times as much (bench/estimation_bench.cpp). Kept from call to call while the number of basis
// lights stays the same.
class CeresSolver {
 public:
  CeresSolver();
  ~CeresSolver();

  // argmin over x >= 0 of sum_c |rows_c x_c - target_c|^2 + |prior_root' x - prior_target|^2;
  // prior_root is the lower Cholesky factor of the prior's information. Ceres solves for the
  // unknowns that are not held at 0, which at first are those above 0 in `x`; then those that want
  // to leave their bound, or went past it, change sides, and it solves again. (Ceres' own bounds
  // bring a line search that does not end at an unknown's bound: 126 steps for one frame.)
  // Returns false when that does not settle; x is then as it was.
  bool Solve(const Reweighting& samples,
             const LightMatrix& prior_root,
             const LightVector& prior_target,
             LightVector& x);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pleinair::estimation_internal
