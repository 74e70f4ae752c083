// What glossy virtual objects mirror of their surroundings: plain data from relight to render.
#pragma once

#include "scene/image.h"

namespace pleinair {

// Over part of the undistorted picture that covers the camera's (see UndistortedCover): per pixel
// the radiance that its glossy part sends to the camera beside the sun's glint, reflectance
// included. Glossy pixels outside the image mirror nothing.
struct MirroredLight {
  int x_px = 0;  // Of the image's first pixel in that picture.
  int y_px = 0;
  RgbImage radiance;  // May be empty.
};

}  // namespace pleinair
