// How soft a camera draws edges, by the edges in its picture.
#pragma once

#include "scene/image.h"
#include "scene/surface_view.h"

namespace pleinair {

struct EdgeBlur {
  // Standard deviation of the Gaussian that blurs a picture of light averaged over each pixel; 0
  // where there is none to speak of, or too few edges tell.
  double sigma_px = 0.0;
  int edges = 0;             // Profiles that the answer is from.
  bool is_measured = false;  // They were enough.
};

// Fits the step of light across edges of the model: where surfaces of another group or facing, or
// far behind, begin. Lines of pixels across them count where they show one step between two even
// sides, no more than 2 px from where the model has it; where the mesh is round or coarse, things
// stand in the way or a penumbra lies there, the step is too wide, never too narrow, so that the
// narrowest quarter is believed. `radiance` is linear and has the view's size; where `clipped` is
// not 0 (may be empty), or light not finite, nothing is read.
//
// Accuracy  some 5 % from 20 edges on that are 30 times the noise high.
// Throws    std::invalid_argument for another size.
EdgeBlur MeasureEdgeBlur(const RgbImage& radiance,
                         const Gray8Image& clipped,
                         const SurfaceView& view);

}  // namespace pleinair
