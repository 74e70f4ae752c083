// Whether a list has as many entries as a scene has faces.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace pleinair {

// Throws std::invalid_argument beginning with `what` where it has not.
inline void RequireFaceCount(const std::string& what, std::size_t count, std::size_t expected) {
  if (count == expected) return;
  throw std::invalid_argument(what + " has " + std::to_string(count) +
                              " entries: expected one a face, " + std::to_string(expected));
}

}  // namespace pleinair
