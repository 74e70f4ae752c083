// Directions spread evenly over the sphere.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

namespace pleinair::internal {

// `count` (even) unit directions on a golden-angle spiral from the zenith to the nadir, each
// representing 4 pi / count steradians; the first half lies above the horizon. `seed` turns the
// spiral about the vertical.
//
// Source    Hannay and Nye, J. Phys. A 37(48), 2004: Fibonacci numerical integration on a sphere.
// Accuracy  heights are the midpoints of equal slices, so that functions of height only are
//           integrated by the midpoint rule: constants and the linear term without error.
std::vector<glm::vec3> SphereDirections(int count, std::uint64_t seed);

}  // namespace pleinair::internal
