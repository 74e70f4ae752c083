// What hides a site's sky though its mesh lacks it: trees, masts, far houses.
#pragma once

#include <memory>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/sky_shape.h"

namespace pleinair {

// A function of direction, as seen from one place: correct for far objects, and an approximation at
// other places for near ones. Per cell of SkyTable; both empty where nothing hides the sky.
struct Skyline {
  std::vector<float> hidden;  // Share of the cell's sky, 0..1.
  // Radiance of what hides it, per unit of the sky's irradiance on an unoccluded horizontal plane,
  // averaged over the cell (0 where nothing hides).
  std::vector<glm::vec3> reflected;
  // Lat-long over a surface's normal, what an even sky of radiance 1 would bring it if only what is
  // hidden shone; the same in all channels.
  RgbImage irradiance_of_hidden;

  bool Empty() const { return hidden.empty(); }
};

// Empty where nothing is hidden.
// Throws std::invalid_argument for tables that are not of SkyTable's cells.
Skyline MakeSkyline(std::vector<float> hidden, std::vector<glm::vec3> reflected);

// `shape` as it is seen past the skyline: what hides the sky reflects a share of the sky's light.
// A unit is still the irradiance of an unoccluded plane under `shape` itself, so that an intensity
// means the same with a skyline and without. Has the name of `shape`; is `shape` where the skyline
// is empty.
std::shared_ptr<const SkyShape> SeenPast(const Skyline& skyline,
                                         std::shared_ptr<const SkyShape> shape);

}  // namespace pleinair
