// Checks of the numbers that a caller states: a lens's, an option's.
#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

#include "calib/internal/residual_text.h"

namespace pleinair {

// All throw std::invalid_argument naming field and value.
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

// Of an option whose `value` is `good` or else not as `expected`.
inline void RequireOption(bool good, const char* field, double value, const char* expected) {
  if (good) return;
  throw std::invalid_argument(std::string(field) + ": expected " + expected + ", found " +
                              NumberText("%g", value));
}

}  // namespace pleinair
