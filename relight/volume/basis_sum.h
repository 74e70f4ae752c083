// Sums over basis lights: the one loop that every frame's map and probes go through.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/lighting.h"

namespace pleinair::internal {

// Intensities of the basis lights, sun first, then the sky's components in order.
// Throws std::invalid_argument, beginning with `what`, when `lighting` has not `count` lights or an
// intensity is not finite.
std::vector<glm::vec3> BasisWeights(const Lighting& lighting,
                                    std::size_t count,
                                    std::string_view what);

// Writes sum_k weights[k] * terms[k], channel by channel, into `sum`. An empty term is black.
//
// Shape    terms and weights: one entry a basis light; each term empty or as long as `sum`.
// Cost     bound by memory; large sums are spread over threads, which changes no bit of them.
// Throws   std::invalid_argument, beginning with `what`, for a term of another length.
void WeightedSum(std::span<const std::span<const glm::vec3>> terms,
                 std::span<const glm::vec3> weights,
                 std::span<glm::vec3> sum,
                 std::string_view what);

}  // namespace pleinair::internal
