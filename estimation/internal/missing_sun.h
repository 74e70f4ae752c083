// Assumptions about shadows that the mesh does not cast: of trees, cars, houses outside it.
#pragma once

namespace pleinair::estimation_internal {

// Share of the planes or samples in the model's sun that something outside the mesh shades: an
// assumption.
inline constexpr double kShadeTheMeshLacks = 0.05;
// Least share of the sun in the predicted light: shadows of weaker suns look like stains.
inline constexpr double kLitFrom = 0.4;

}  // namespace pleinair::estimation_internal
