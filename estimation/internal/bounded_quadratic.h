// The least-squares solve with unknowns >= 0, in closed form.
#pragma once

#include "estimation/lighting_prior.h"

namespace pleinair::estimation_internal {

// argmin over x >= 0 of x' H x - 2 g' x for a positive definite H, by an active set of unknowns
// held at 0. Source: Lawson and Hanson, Solving Least Squares Problems, chapter 23, on normal
// equations.
LightVector MinimiseNonNegative(const LightMatrix& normal, const LightVector& gradient);

}  // namespace pleinair::estimation_internal
