// A picture of light as a screen would show it.
#pragma once

#include "scene/image.h"

namespace pleinair {

// Returns `radiance` as shown where its exposure is unknown: its brightest hundredth, which may be
// lamps, is white. For people, and for finders of edges and charts, which work on 8 bit.
Rgb8Image Shown(RgbImage radiance);

}  // namespace pleinair
