// Occluders of a site's sky that its mesh lacks: trees, masts, far houses.
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
  // Radiance of the occluder, per unit of the sky's irradiance on an unoccluded horizontal plane,
  // averaged over the cell (0 without an occluder).
  std::vector<glm::vec3> reflected;
  // Lat-long over a surface's normal: its irradiance from the hidden part only, under an even sky
  // of radiance 1; the same in all channels.
  RgbImage irradiance_of_hidden;

  bool Empty() const { return hidden.empty(); }
};

// Empty where nothing is hidden.
// Throws std::invalid_argument for tables that are not of SkyTable's cells.
Skyline MakeSkyline(std::vector<float> hidden, std::vector<glm::vec3> reflected);

// Returns `shape` as seen past the skyline: the occluders reflect a share of the sky's light. A
// unit is still the irradiance of an unoccluded plane under `shape` itself, so that an intensity
// has the same meaning with and without a skyline. The result has the name of `shape`; it is
// `shape` where the skyline is empty.
std::shared_ptr<const SkyShape> SeenPast(const Skyline& skyline,
                                         std::shared_ptr<const SkyShape> shape);

}  // namespace pleinair
