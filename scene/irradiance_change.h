// The change of the light on real surfaces by virtual objects, over part of a picture: plain data
// from relight to render.
#pragma once

#include "scene/image.h"

namespace pleinair {

// Without the sun's direct light, whose shadows are drawn. Pixels outside the image do not change.
struct IrradianceChange {
  int x_px = 0;  // Position of the image's first pixel in the picture.
  int y_px = 0;
  RgbImage irradiance_rgb;  // To be added: less than 0 where the pixel darkens. May be empty.
};

}  // namespace pleinair
