// Radiosity for many lights at once: one pass over the form factors serves a block of them.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

namespace pleinair::internal {

// Row i: the entries [begin[i], begin[i + 1]) of `face` and `share`.
struct FormFactorRows {
  std::span<const std::uint64_t> begin;
  std::span<const std::int32_t> face;
  std::span<const float> share;
  std::size_t Count() const { return begin.empty() ? 0 : begin.size() - 1; }
};

// Direct irradiance of all lights, [face * count + light], of which [first, first + solved) are
// solved together; solved <= kLightsPerBlock.
struct LightBlock {
  std::span<const glm::vec3> direct;
  std::size_t count = 0;
  std::size_t first = 0;
  std::size_t solved = 0;
};

// After `reflections` >= 1 reflections, or, where that is -1, when what is missing of each light is
// below `tolerance` of its largest radiosity.
struct SolveEnd {
  int reflections = -1;
  double tolerance = 0.0;
};

struct BlockSolution {
  int iterations = 0;
  double residual = 0.0;
};

// Lights that are solved together: 32 of them are 384 bytes a face, so that a row's sums stay in
// the first-level cache and the radiosities of some thousand faces in the second.
inline constexpr std::size_t kLightsPerBlock = 32;

// Iterates radiosity = albedo (direct + F radiosity) for the block's lights, and writes those
// lights of `radiosity`.
//
// Shape   radiosity: as the block's direct; albedo: one a face.
// Threads spreads over threads without a change of any bit.
BlockSolution SolveBlock(const FormFactorRows& rows,
                         std::span<const glm::vec3> albedo,
                         const LightBlock& block,
                         const SolveEnd& end,
                         std::span<glm::vec3> radiosity);

}  // namespace pleinair::internal
