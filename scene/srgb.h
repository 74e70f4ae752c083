// The transfer function of sRGB.
#pragma once

#include <cmath>

namespace pleinair {

// IEC 61966-2-1 on [0, 1]; linear below 0, so that it can be inverted, and continued beyond 1.
inline double SrgbFromLinear(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

inline double LinearFromSrgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

}  // namespace pleinair
