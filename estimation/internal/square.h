#pragma once

namespace pleinair::estimation_internal {

inline double Square(double value) { return value * value; }

}  // namespace pleinair::estimation_internal
