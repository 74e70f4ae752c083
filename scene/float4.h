// Four floats as one register of every x86-64 and ARM64, for loops that the compiler packs badly.
#pragma once

#include <cstring>

namespace pleinair {

using Float4 = float __attribute__((vector_size(16)));

// `values` need not be aligned.
inline Float4 LoadFour(const float* values) {
  Float4 four;
  std::memcpy(&four, values, sizeof(four));
  return four;
}

}  // namespace pleinair
