#pragma once

namespace pleinair::estimation_internal {

inline double Square(double value) { return value * value; }
inline double Cube(double value) { return value * value * value; }

}  // namespace pleinair::estimation_internal
