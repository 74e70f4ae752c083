// Which side of the survey sun's shadow edges a map's pixels are on, with mesh and map not exactly
// in place.
#pragma once

#include <cstdint>

#include "relight/survey/survey.h"
#include "relight/transport/sun_disc.h"
#include "relight/transport/surface_gather.h"
#include "scene/image.h"

namespace pleinair {

enum class ShadowSide : std::uint8_t {
  kUnsure,  // Also: turned from the sun, or in a penumbra.
  kLit,
  kShaded,
};

// kLit or kShaded where the pixel of `view` stays on that side of the shadows' edges under all
// misplacements. These turn the map either way, and move the surface across the sun's rays in four
// directions. kShaded also where the surface is turned from the sun by more than that turns it.
// `view` has its geometry and sun_visibility, made of `rays` and `disc`.
Image<ShadowSide> FindShadowSides(const RayCaster& caster,
                                  const SunDisc& disc,
                                  const ViewRays& rays,
                                  const Misplacement& misplacement,
                                  const SurfaceView& view);

}  // namespace pleinair
