// Shade that the camera sees and the mesh does not cast, on virtual objects: of trees, eaves, or a
// house behind the camera.
#pragma once

#include "objects/shadow_places.h"
#include "pipeline/effects/frame_effect.h"
#include "scene/image.h"
#include "scene/sun_shares.h"

namespace pleinair {

// Share of the sun that is left on the objects, 0..1, by what the pixels show where the objects'
// shadows fall: a pixel that the mesh has in the sun, but that has the radiance of its surface in
// shade (real_sun.h), says that something real stands before the sun, and before the object with
// it. What is too dark for that is another thing than the surface, and says nothing. A mean over
// neighbours, whose ends are cut off: single dark pixels are stains, and shadows are as sharp as
// that on the object. Places whose shadow is not in the picture have the mean of the nearest ones
// on the same object that have one.
//
// Shape    as `places`; 1 beside the objects. Empty where no shade is seen.
// Not      distinguished from shade: a thing between object and surface that shades the surface
// alone.
GrayImage SunPastSeenShade(const EffectFrame& frame, const ShadowPlaces& places);

// Takes the rest of the sun from what the objects see of it; `left` is not empty.
void TakeSun(const GrayImage& left, ObjectSunShare& share);

}  // namespace pleinair
