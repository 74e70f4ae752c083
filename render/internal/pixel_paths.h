// Straight paths in a picture over an exposure, and values along them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <glm/vector_relational.hpp>

#include "scene/pixel_rect.h"

namespace pleinair {

// From a pixel to where its content lies at the frame's instant, at the beginning (x, y) and at the
// end (z, w) of its exposure.
struct PixelPaths {
  PixelRect rect;
  std::vector<glm::vec4> ends;  // Over rect.

  const glm::vec4& At(const glm::ivec2& pixel) const { return ends[rect.Index(pixel)]; }
};

// At a share of the exposure.
inline glm::vec2 Along(const glm::vec4& ends, float time) {
  return (1.0f - time) * glm::vec2(ends.x, ends.y) + time * glm::vec2(ends.z, ends.w);
}

// Steps of at most so many pixels; one where nothing moves.
inline int StepsFor(const glm::vec4& ends, float px_per_step = 1.0f) {
  const float length = glm::distance(glm::vec2(ends.x, ends.y), glm::vec2(ends.z, ends.w));
  const int steps = static_cast<int>(std::ceil(length / px_per_step));
  constexpr int kMostSteps = 64;
  return std::clamp(steps, length > 0.0f ? 2 : 1, kMostSteps);
}

// The middle of one of so many parts of the exposure.
inline float TimeOf(int step, int steps) {
  return (static_cast<float>(step) + 0.5f) / static_cast<float>(steps);
}

inline PixelRect ClippedTo(const PixelRect& rect, int width, int height) {
  return {glm::max(rect.lower, glm::ivec2(0)), glm::min(rect.upper, glm::ivec2(width, height))};
}

template <typename Visit>
void ForPixels(const PixelRect& rect, const Visit& visit) {
  if (rect.Empty()) return;
  tbb::parallel_for(rect.lower.y, rect.upper.y, [&](int y) {
    for (int x = rect.lower.x; x < rect.upper.x; ++x) visit(glm::ivec2(x, y));
  });
}

inline glm::ivec2 NearestPixel(const glm::vec2& at) { return glm::ivec2(glm::floor(at + 0.5f)); }

// Weights of four pixels around a place between the second and the third: Keys' cubic
// (IEEE Trans. ASSP 29(6), 1981), which widens no edge where linear ones do.
inline std::array<float, 4> CubicWeights(float f) {
  return {f * (-0.5f + f * (1.0f - 0.5f * f)),
          1.0f + f * f * (-2.5f + 1.5f * f),
          f * (0.5f + f * (2.0f - 1.5f * f)),
          f * f * (-0.5f + 0.5f * f)};
}

// Between pixels' centres; `texel` gives the value of one.
template <typename Texel>
auto Linear(const glm::vec2& at, const Texel& texel) {
  const glm::vec2 lower = glm::floor(at);
  const glm::vec2 weight = at - lower;
  const glm::ivec2 first(lower);
  return (1.0f - weight.y) *
             ((1.0f - weight.x) * texel(first) + weight.x * texel(first + glm::ivec2(1, 0))) +
         weight.y * ((1.0f - weight.x) * texel(first + glm::ivec2(0, 1)) +
                     weight.x * texel(first + glm::ivec2(1, 1)));
}

// The same by cubics, within the range of the four pixels around the place: beside the sun's glint
// the cubics' negative weights would leave nothing.
template <typename Texel>
auto Cubic(const glm::vec2& at, const Texel& texel) {
  const glm::vec2 lower = glm::floor(at);
  const glm::vec2 weight = at - lower;
  const glm::ivec2 first(lower);
  // At a pixel's own place the result is exactly its value.
  if (weight == glm::vec2(0.0f)) return texel(first);
  const std::array<float, 4> across = CubicWeights(weight.x);
  const std::array<float, 4> down = CubicWeights(weight.y);
  auto least = texel(first);
  auto most = least;
  auto sum = 0.0f * least;
  for (int y = 0; y < 4; ++y) {
    if (down[static_cast<std::size_t>(y)] == 0.0f) continue;
    for (int x = 0; x < 4; ++x) {
      const float both = down[static_cast<std::size_t>(y)] * across[static_cast<std::size_t>(x)];
      if (both == 0.0f) continue;
      const auto value = texel(first + glm::ivec2(x - 1, y - 1));
      sum += both * value;
      if (x % 3 == 0 || y % 3 == 0) continue;  // Not around the place.
      least = glm::min(least, value);
      most = glm::max(most, value);
    }
  }
  return glm::clamp(sum, least, most);
}

}  // namespace pleinair
