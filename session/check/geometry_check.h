// Whether mesh, camera and objects of a site are in metres, east, north and up.
#pragma once

#include <span>

#include "datasets/sequence.h"
#include "render/compositor.h"
#include "scene/mesh.h"
#include "scene/ray_caster.h"
#include "session/check/site_warning.h"
#include "session/sequence_site.h"

namespace pleinair {

// What sizes can show: factors of 100 and 1000. Feet look like a site three times as large, which
// only edges or a known length show.
// `objects`, `motions`: SequenceSite's parts of virtual_objects, in world coordinates.
SiteWarnings CheckUnits(const Sequence& sequence,
                        const Mesh& mesh,
                        const RayCaster& caster,
                        std::span<const VirtualObject> objects,
                        std::span<const ObjectMotion> motions);

// That the ground is below and the sky above: of the mesh, and of the camera.
SiteWarnings CheckAxes(const Sequence& sequence, const Mesh& mesh, const RayCaster& caster);

}  // namespace pleinair
