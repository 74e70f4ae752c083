// Checks whether mesh, camera and objects of a site are in metres, east, north and up, whether
// cameras and survey map are at places from where the mesh is seen, and whether light gets in.
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

// Checks that the first camera looks at the mesh, and that its sky is above. A warning spoils the
// forecast where another reading of its pose looks at the mesh, or this one hardly does.
SiteWarnings CheckPose(const Sequence& sequence, const RayCaster& caster);

// Checks that the mesh's ground is below and its sky above.
SiteWarnings CheckAxes(const Sequence& sequence, const Mesh& mesh, const RayCaster& caster);

// Checks that the later frames' cameras and the survey map are where the mesh can be seen, and that
// the map is not below the ground.
SiteWarnings CheckPlaces(const Sequence& sequence, const RayCaster& caster);

// Checks that all frames or none have poses of their own.
SiteWarnings CheckFramePoses(const Sequence& sequence);

// Checks that the mesh does not stop light where a window is stated, nor, under a camera that sees
// the sky for a room, all of it: models often have panes, and glass counts as opaque.
SiteWarnings CheckOpenings(const Sequence& sequence, const Mesh& mesh, const RayCaster& caster);

}  // namespace pleinair
