// Checks whether mesh, camera and objects of a site are in metres, east, north and up, and whether
// cameras and survey map are at places from where the mesh is seen.
#pragma once

#include <span>

#include "datasets/sequence.h"
#include "render/compositor.h"
#include "scene/mesh.h"
#include "scene/ray_caster.h"
#include "session/check/site_warning.h"
#include "session/sequence_site.h"

namespace pleinair {

// Checks sizes: they reveal factors of 100 and 1000. A site in feet looks three times as large,
// which only edges or a known length reveal. `objects`, `motions`: SequenceSite's parts of
// virtual_objects, in world coordinates.
SiteWarnings CheckUnits(const Sequence& sequence,
                        const Mesh& mesh,
                        const RayCaster& caster,
                        std::span<const VirtualObject> objects,
                        std::span<const ObjectMotion> motions);

// Checks that the ground is below and the sky above, for the mesh and for the camera.
SiteWarnings CheckAxes(const Sequence& sequence, const Mesh& mesh, const RayCaster& caster);

// Checks that the later frames' cameras and the survey map are where the mesh can be seen, and that
// the map is not below the ground.
SiteWarnings CheckPlaces(const Sequence& sequence, const RayCaster& caster);

}  // namespace pleinair
