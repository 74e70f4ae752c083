// Vectors as sequences and their truth write them.
#pragma once

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "calib/json_cursor.h"

namespace pleinair {

inline glm::dvec3 ReadVector3(const JsonCursor& at) {
  const auto entries = at.List(3, 3);
  return {entries[0].Number(), entries[1].Number(), entries[2].Number()};
}

// A vector of length 1, to the accuracy of the decimals.
inline glm::dvec3 ReadDirection(const JsonCursor& at) {
  constexpr double kUnitTolerance = 1e-3;
  const glm::dvec3 direction = ReadVector3(at);
  const double length = glm::length(direction);
  if (!(std::abs(length - 1.0) <= kUnitTolerance)) at.Fail("a direction of length 1");
  return direction / length;
}

}  // namespace pleinair
