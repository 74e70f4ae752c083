#include "estimation/internal/bounded_quadratic.h"

#include <array>
#include <cmath>
#include <limits>

#include "estimation/internal/symmetric_algebra.h"

namespace pleinair::estimation_internal {
namespace {

using FreeFlags = std::array<bool, kMaxLightUnknowns>;

// Solves for the free unknowns alone; the others are 0.
LightVector SolveFree(const LightMatrix& normal,
                      const LightVector& gradient,
                      const FreeFlags& free) {
  std::array<Eigen::Index, kMaxLightUnknowns> index{};
  Eigen::Index count = 0;
  for (Eigen::Index u = 0; u < gradient.size(); ++u) {
    if (free[static_cast<std::size_t>(u)]) index[static_cast<std::size_t>(count++)] = u;
  }
  LightVector x = LightVector::Zero(gradient.size());
  if (count == 0) return x;
  LightMatrix part(count, count);
  LightVector right(count);
  for (Eigen::Index a = 0; a < count; ++a) {
    right[a] = gradient[index[static_cast<std::size_t>(a)]];
    for (Eigen::Index b = 0; b < count; ++b) {
      part(a, b) = normal(index[static_cast<std::size_t>(a)], index[static_cast<std::size_t>(b)]);
    }
  }
  const LightVector solved = SolvePositive(part, right);
  for (Eigen::Index a = 0; a < count; ++a) x[index[static_cast<std::size_t>(a)]] = solved[a];
  return x;
}

}  // namespace

LightVector MinimiseNonNegative(const LightMatrix& normal, const LightVector& gradient) {
  const Eigen::Index unknowns = gradient.size();
  FreeFlags free{};
  free.fill(true);
  LightVector x = SolveFree(normal, gradient, free);
  if ((x.array() >= 0.0).all()) return x;  // The ordinary case.

  x.setZero();
  free.fill(false);
  // Each round frees one unknown; in exact arithmetic the cost falls every time, so 3 rounds an
  // unknown end only what rounding makes cycle.
  for (Eigen::Index round = 0; round < 3 * unknowns; ++round) {
    const LightVector descent = gradient - normal * x;
    Eigen::Index steepest = -1;
    // Rounding of the products below this is no descent.
    double best = 0.0;
    for (Eigen::Index u = 0; u < unknowns; ++u) {
      if (free[static_cast<std::size_t>(u)]) continue;
      const double rounding =
          1e-13 * (std::abs(gradient[u]) + normal.row(u).cwiseAbs().dot(x.cwiseAbs()));
      const double gain = descent[u] / std::sqrt(normal(u, u));
      if (descent[u] > rounding && gain > best) {
        best = gain;
        steepest = u;
      }
    }
    if (steepest < 0) return x;
    free[static_cast<std::size_t>(steepest)] = true;
    LightVector next = SolveFree(normal, gradient, free);
    for (Eigen::Index inner = 0; inner < unknowns; ++inner) {
      double step = 1.0;
      for (Eigen::Index u = 0; u < unknowns; ++u) {
        if (free[static_cast<std::size_t>(u)] && next[u] < 0.0) {
          step = std::min(step, x[u] / (x[u] - next[u]));
        }
      }
      if (step >= 1.0) break;
      x += step * (next - x);
      for (Eigen::Index u = 0; u < unknowns; ++u) {
        if (free[static_cast<std::size_t>(u)] && next[u] < 0.0 &&
            !(x[u] > std::numeric_limits<double>::epsilon())) {
          free[static_cast<std::size_t>(u)] = false;
          x[u] = 0.0;
        }
      }
      next = SolveFree(normal, gradient, free);
    }
    x = next.cwiseMax(0.0);
  }
  return x;
}

}  // namespace pleinair::estimation_internal
