// Checks the layout of a survey map against the mesh: not upside down, mirrored, or turned.
#pragma once

#include <glm/vec3.hpp>

#include "scene/image.h"
#include "scene/mesh.h"
#include "scene/ray_caster.h"

namespace pleinair {

enum class MapLayout { kAsStated, kUpsideDown, kHalfTurned, kMirrored };

// The layout that fits best, compared with that of the map as given.
struct MapLayoutFit {
  // The layout in which the mesh's surfaces, as seen from the map's place, explain the map best.
  MapLayout best = MapLayout::kAsStated;
  // The turn of the map after that, clockwise seen from above, [-pi, pi).
  double turn_rad = 0.0;
  double explained = 0.0;            // With the best layout: see ExplainedShare.
  double explained_as_stated = 0.0;  // With the map as given.

  // By more than symmetric surroundings and imprecise meshes explain.
  bool ContradictsTheMap() const;
};

// `map`: lat-long. kUpsideDown: its rows reversed; kHalfTurned: rows and columns, as a picture held
// the wrong way round; kMirrored: columns, as seen from outside the sphere.
MapLayoutFit FitMapLayout(const RgbImage& map,
                          const glm::dvec3& position_m,
                          const Mesh& mesh,
                          const RayCaster& caster);

}  // namespace pleinair
