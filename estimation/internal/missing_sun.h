// What is assumed of shadows that the mesh does not cast: of trees, cars, houses outside it.
#pragma once

namespace pleinair::estimation_internal {

// Of what the model has in the sun, planes or samples, the share that something else shades: an
// assumption.
inline constexpr double kShadeTheMeshLacks = 0.05;
// Of the sun in the predicted light, at least: weaker suns cast shadows like stains.
inline constexpr double kLitFrom = 0.4;

}  // namespace pleinair::estimation_internal
