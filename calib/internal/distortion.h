// OpenCV's five-coefficient distortion (calib/lens.h), for numbers and for Ceres' jets.
#pragma once

#include <array>

namespace pleinair {

template <typename T>
std::array<T, 2> DistortedPoint(const std::array<double, 5>& distortion, const T& x, const T& y) {
  const auto [k1, k2, p1, p2, k3] = distortion;
  const T s = x * x + y * y;
  const T magnification = 1.0 + s * (k1 + s * (k2 + s * k3));
  return {x * magnification + 2.0 * p1 * x * y + p2 * (s + 2.0 * x * x),
          y * magnification + p1 * (s + 2.0 * y * y) + 2.0 * p2 * x * y};
}

}  // namespace pleinair
