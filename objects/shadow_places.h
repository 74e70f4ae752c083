// The places in a picture where the visible parts of virtual objects cast their shadows. A place of
// an object and the place of its shadow lie on one ray of the sun. So where the camera sees the
// second in the sun, nothing real hides the sun from the first.
#pragma once

#include <cstddef>
#include <cstdint>

#include <glm/vec3.hpp>

#include "objects/object_view.h"
#include "relight/transport/patch_scene.h"
#include "scene/image.h"
#include "scene/ray_caster.h"
#include "scene/surface_view.h"

namespace pleinair {

struct ShadowPlaces {
  static constexpr std::int32_t kNothing = -1;  // No object there, or turned away from the sun.
  static constexpr std::int32_t kNotSeen = -2;  // The place of the shadow is not in the picture.
  // Shape  a value a pixel of the ObjectView: its shadow's pixel in the SurfaceView, or one of
  // these.
  Image<std::int32_t> pixel;
  // Shape  the same: the object that is seen, its group in the objects' mesh.
  Image<std::uint32_t> object;
};

// By one ray a pixel, from the first of its samples that faces the sun. `real` is the mesh that
// `view` shows, `to_sun` is unit. Threads  The result does not depend on their number.
ShadowPlaces ShadowPlacesOf(const ObjectView& objects_in_view,
                            const PatchScene& objects,
                            const RayCaster& real,
                            const SurfaceView& view,
                            const glm::vec3& to_sun);

}  // namespace pleinair
