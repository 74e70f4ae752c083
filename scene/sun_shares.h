// The share of the sun's disc that is visible past real and virtual casters together, over parts of
// a picture: plain data from relight to render.
#pragma once

#include "scene/image.h"

namespace pleinair {

// On real surfaces, for each camera pixel. Pixels outside the image lose nothing.
struct RealSunShare {
  int x_px = 0;  // Position of the image's first pixel in the picture.
  int y_px = 0;
  // Share that virtual objects hide of the part of the disc that the pixel sees without them, 0..1:
  // a mean over the pixel's square. May be empty.
  GrayImage hidden;
};

// On virtual objects, over parts of the pixels of the undistorted picture that covers the camera's
// (see UndistortedCover).
struct ObjectSunShare {
  static constexpr int kSamplesPerSide = 2;  // Parts of a pixel.
  int x_px = 0;                              // Position of the image's first pixel in that picture.
  int y_px = 0;
  // Visible share of the disc, 0..1: a mean over the points of each part that the sun may reach.
  // May be empty.
  GrayImage seen;
};

// Both, for one frame.
struct SunShares {
  RealSunShare real;
  ObjectSunShare objects;
};

}  // namespace pleinair
