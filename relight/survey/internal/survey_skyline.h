// Things that a survey map shows against the sky and the mesh lacks.
#pragma once

#include <glm/vec3.hpp>

#include "scene/image.h"
#include "scene/skyline.h"

namespace pleinair {

// 255 where `radiance`, a lat-long map, shows a thing before the sky: a tree, a mast, a far house.
// Such a thing stands on the horizon, or 4 deg high on the mesh (an eave is near, and where it
// hides the sky depends on the place). It ends at a sharp edge above which the sky is at least 1.6
// times brighter. It is for the most part dark against that sky down to where it stands, and is not
// bluer than it. Clouds differ: a cloud's edge is soft, its base hangs over bright air, and the
// blue sky under a cloud is bluer. All that is in doubt stays sky, so that a sunlit wall or a thing
// in mist is not found, nor is what the map shows no sky above.
//
// `shows_sky`  of the map's size: not zero where the pixel sees past the mesh, above the horizon.
// Threads      The result does not depend on their number.
Gray8Image FindHiddenSky(const RgbImage& radiance, const Gray8Image& shows_sky);

// The skyline of a map of `radiance` under a sky of `sky_irradiance_rgb`, `hidden` as above. Empty
// where none is. Lamps on what hides the sky count as white surfaces in the sun.
Skyline SkylineOf(const RgbImage& radiance,
                  const Gray8Image& hidden,
                  const glm::dvec3& sky_irradiance_rgb);

}  // namespace pleinair
