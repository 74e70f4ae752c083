// Mirror images of the surroundings in glossy virtual objects: plain data from relight to render.
#pragma once

#include "scene/image.h"

namespace pleinair {

// Over part of the undistorted picture that covers the camera's (see UndistortedCover). Each pixel
// has the radiance that its glossy part sends to the camera, reflectance included and the sun's
// glint excluded. Glossy pixels outside the image mirror nothing.
struct MirroredLight {
  int x_px = 0;  // Position of the image's first pixel in that picture.
  int y_px = 0;
  RgbImage radiance;  // May be empty.
};

}  // namespace pleinair
