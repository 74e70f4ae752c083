// What virtual objects change of the light on real surfaces, over part of a picture: plain data
// from relight to render.
#pragma once

#include "scene/image.h"

namespace pleinair {

// The sun's direct light left out: its shadows are drawn. Pixels outside the image change by
// nothing.
struct IrradianceChange {
  int x_px = 0;  // Of the image's first pixel in the picture.
  int y_px = 0;
  RgbImage irradiance_rgb;  // To be added: less than 0 where the pixel darkens. May be empty.
};

}  // namespace pleinair
