// Polynomials as lists of coefficients, lowest power first.
#pragma once

#include <optional>
#include <span>
#include <vector>

namespace pleinair {

double EvaluatePolynomial(std::span<const double> coefficients, double x);

// Where the polynomial changes sign in (0, upper), ascending: none is missed.
std::vector<double> PolynomialRootsIn(std::span<const double> coefficients, double upper);

// Where a polynomial that is positive at 0 first stops being so, at most `upper`.
double PositiveUpTo(std::span<const double> coefficients, double upper);

}  // namespace pleinair
