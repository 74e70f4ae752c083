// Shade on virtual objects that is visible in the picture but that the mesh does not cast: of
// trees, eaves, or a house behind the camera.
#pragma once

#include "objects/shadow_places.h"
#include "pipeline/effects/frame_effect.h"
#include "scene/image.h"
#include "scene/sun_shares.h"

namespace pleinair {

// Returns the share of the sun that remains on the objects, 0..1, from the pixels where the
// objects' shadows fall. A pixel may have the radiance of its surface in shade (real_sun.h) though
// the mesh has it in the sun. Then something real hides the sun there, and so on the object. A
// pixel that is too dark for that shows something other than the surface, and is no evidence.
//
// The share is a trimmed mean over neighbours, as single dark pixels are stains; this sets the
// sharpness of shadows on the object. Places whose shadow is not in the picture have the mean of
// the nearest ones on the same object.
//
// Shape    as `places`; 1 beside the objects. Empty where no shade is seen.
// Not      distinguished from shade: a thing between object and surface that shades the surface
// alone.
GrayImage SunPastSeenShade(const EffectFrame& frame, const ShadowPlaces& places);

// Reduces the objects' visible share of the sun to `left`, which is not empty.
void TakeSun(const GrayImage& left, ObjectSunShare& share);

}  // namespace pleinair
