// Overlays whose colour follows from a pixel's own values.
#pragma once

#include <cstddef>

#include <tbb/parallel_for.h>

#include "apps/viewer/overlay.h"

namespace pleinair {

// `colour_of` gets the index of a pixel that shows a surface; the sky stays without colour.
template <typename ColourOf>
Rgba8Image ColourSurfaces(const SurfaceView& view, const ColourOf& colour_of) {
  Rgba8Image picture(view.Width(), view.Height(), kNoColour);
  tbb::parallel_for(0, view.Height(), [&](int y) {
    for (int x = 0; x < view.Width(); ++x) {
      const std::size_t pixel = picture.Index(x, y);
      if (view.region.pixels[pixel] == SurfaceView::kNoRegion) continue;
      picture.pixels[pixel] = colour_of(pixel);
    }
  });
  return picture;
}

}  // namespace pleinair
