// Limits for pixels of a surface view that are certainly sunlit.
#pragma once

namespace pleinair::estimation_internal {

// Sun visibilities; between these the disc is neither seen nor hidden as a whole.
inline constexpr float kFullyShaded = 0.02f;
inline constexpr float kFullyLit = 0.98f;
// With less the sun grazes, and a normal's error decides what it gives.
inline constexpr double kLeastSunCosine = 0.1;

}  // namespace pleinair::estimation_internal
