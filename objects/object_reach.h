// Where virtual objects can matter in a picture: bounds from their boxes and spheres. They are
// computed before the light that objects change, and cost a small part of it.
#pragma once

#include <cstdint>
#include <vector>

#include "objects/object_influence.h"
#include "relight/transport/patch_scene.h"
#include "scene/camera.h"
#include "scene/lighting.h"
#include "scene/surface_view.h"

namespace pleinair {

// False only where no part of any object's bounding box lies in the picture; occlusion is not
// considered. Each object is a group of `objects`.
bool MayBeInView(const PatchScene& objects, const Camera& camera);

// The real surfaces of a view whose light objects can change beside the sun's shadow.
struct InfluenceReach {
  // Bound of the share of the (cosine-weighted) view of any of them that objects fill, 0..1.
  float largest_share = 0.0f;
  // Empty where some share is above kDecisive: the search then ends early.
  std::vector<std::uint32_t> pixels;

  static constexpr float kDecisive = 0.05f;
};

// The reach over the pixels where ObjectInfluence has or may blend receivers.
// Cost     a sixteenth of the picture's pixels are tested first; where one is decisive the search
//          ends.
// Threads  the result does not depend on their number.
InfluenceReach ReachOfInfluence(const PatchScene& objects,
                                const SurfaceView& view,
                                const ObjectInfluenceOptions& options = {});

// Whether some of the sun's disc is seen, past `real` alone, from the objects, whichever way they
// face. Tested from their vertices (five rays, to the disc's centre and rim) and the middles of
// their faces (one). What reaches an object between those is missed; a sun below the horizon is not
// seen.
bool AnySeesSun(const PatchScene& objects, const RayCaster& real, const DirectionalLight& sun);

}  // namespace pleinair
