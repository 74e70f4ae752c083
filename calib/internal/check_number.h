// Checks of a lens's numbers.
#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

namespace pleinair {

// Both throw std::invalid_argument naming field and value.
inline void RequirePositive(const char* field, double value) {
  if (value > 0.0 && std::isfinite(value)) return;
  throw std::invalid_argument(std::string(field) + " " + std::to_string(value) +
                              ": expected a positive number");
}

inline void RequireFinite(const char* field, double value) {
  if (std::isfinite(value)) return;
  throw std::invalid_argument(std::string(field) + " " + std::to_string(value) +
                              ": expected a finite number");
}

}  // namespace pleinair
