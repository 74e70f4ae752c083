// Where virtual objects can matter in a picture: bounds from their boxes and spheres, worked out
// before, and for a small part of what, the light that they change costs.
#pragma once

#include <cstdint>
#include <vector>

#include "objects/object_influence.h"
#include "relight/transport/patch_scene.h"
#include "scene/camera.h"
#include "scene/lighting.h"
#include "scene/surface_view.h"

namespace pleinair {

// False only where no part of any object's bounding box lies in the picture; what stands before it
// is not minded. Each object is a group of `objects`.
bool MayBeInView(const PatchScene& objects, const Camera& camera);

// The real surfaces of a view whose light objects can change beside the sun's shadow.
struct InfluenceReach {
  // Bound of the share of the (cosine-weighted) view of any of them that objects fill, 0..1.
  float largest_share = 0.0f;
  // Where some share is above kDecisive all are not looked for, and this is empty.
  std::vector<std::uint32_t> pixels;

  static constexpr float kDecisive = 0.05f;
};

// The reach over the pixels where ObjectInfluence has or may blend receivers.
// Cost     a sixteenth of the picture's pixels are asked first; where one is decisive that is all.
// Threads  the result does not depend on their number.
InfluenceReach ReachOfInfluence(const PatchScene& objects,
                                const SurfaceView& view,
                                const ObjectInfluenceOptions& options = {});

// Whether some of the sun's disc is seen, past `real` alone, from a vertex of the objects (five
// rays, to the disc's centre and rim) or the middle of a face of theirs (one), whichever way it
// faces. What reaches an object between those is missed; a sun below the horizon is not seen.
bool AnySeesSun(const PatchScene& objects, const RayCaster& real, const DirectionalLight& sun);

}  // namespace pleinair
