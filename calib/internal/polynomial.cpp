#include "calib/internal/polynomial.h"

namespace pleinair {

double EvaluatePolynomial(std::span<const double> coefficients, double x) {
  double value = 0.0;
  for (std::size_t i = coefficients.size(); i-- > 0;) value = value * x + coefficients[i];
  return value;
}

// Between neighbouring sign changes of its derivative a polynomial is monotone, so bisection there
// misses none.
std::vector<double> PolynomialRootsIn(std::span<const double> coefficients, double upper) {
  std::size_t degree = coefficients.size() - 1;
  while (degree > 0 && coefficients[degree] == 0.0) --degree;
  if (degree == 0) return {};
  std::vector<double> derivative(degree);
  for (std::size_t i = 1; i <= degree; ++i) {
    derivative[i - 1] = static_cast<double>(i) * coefficients[i];
  }
  std::vector<double> bounds = PolynomialRootsIn(derivative, upper);
  bounds.insert(bounds.begin(), 0.0);
  bounds.push_back(upper);
  std::vector<double> roots;
  for (std::size_t i = 0; i + 1 < bounds.size(); ++i) {
    double low = bounds[i];
    double high = bounds[i + 1];
    const bool negative_at_low = EvaluatePolynomial(coefficients, low) < 0.0;
    if (negative_at_low == (EvaluatePolynomial(coefficients, high) < 0.0)) continue;
    while (true) {
      const double middle = 0.5 * (low + high);
      if (!(middle > low && middle < high)) break;
      ((EvaluatePolynomial(coefficients, middle) < 0.0) == negative_at_low ? low : high) = middle;
    }
    roots.push_back(low);
  }
  return roots;
}

double PositiveUpTo(std::span<const double> coefficients, double upper) {
  const std::vector<double> roots = PolynomialRootsIn(coefficients, upper);
  return roots.empty() ? upper : roots.front();
}

}  // namespace pleinair
