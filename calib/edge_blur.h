// How soft a camera draws edges, by the edges in its pictures.
#pragma once

#include <vector>

#include "scene/image.h"
#include "scene/surface_view.h"

namespace pleinair {

struct EdgeBlur {
  // Standard deviation of the Gaussian that blurs a picture of light averaged over each pixel; 0
  // where it is negligible, or too few edges show it.
  double sigma_px = 0.0;
  int edges = 0;             // Profiles that the answer is from.
  bool is_measured = false;  // They were enough.
};

// Fits the step of light across edges of the model: where surfaces of another group or facing, or
// far behind, begin. Lines of pixels across them count where they show one step between two even
// sides, no more than 2 px from where the model has it. Each says, by its own noise, how well it
// goes with each width, and no more against one than three deviations: where the mesh is round or
// coarse, things stand in the way or a penumbra lies there, lines show other widths, each another
// one, and the width is taken that most agree on.
//
// Accuracy  some 5 % from 20 edges on that are 30 times the noise high, of the entire width: the
//           pixel's own square and what is returned here.
class EdgeBlurMeter {
 public:
  // Pictures of one camera. `radiance` is linear and has the view's size; where `clipped` is not 0
  // (may be empty), or light not finite, nothing is read. Throws std::invalid_argument for another
  // size.
  void Add(const RgbImage& radiance, const Gray8Image& clipped, const SurfaceView& view);

  // The blur found from all pictures so far.
  EdgeBlur Blur() const;

 private:
  std::vector<double> doubts_;  // Of each width, in variances, over all lines.
  int edges_ = 0;
};

}  // namespace pleinair
