// A recorded frame at another size.
#pragma once

#include "scene/frame.h"

namespace pleinair {

// A frame resized by nearest pixels, with nothing clipped or unusable; the lens covers the recorded
// width, without distortion.
inline void Resize(int width_px, int height_px, Frame& frame) {
  CameraIntrinsics& lens = frame.camera.intrinsics;
  const double scale = static_cast<double>(width_px) / lens.width_px;
  lens = {.width_px = width_px,
          .height_px = height_px,
          .fx_px = lens.fx_px * scale,
          .fy_px = lens.fy_px * scale,
          .cx_px = 0.5 * (width_px - 1),
          .cy_px = 0.5 * (height_px - 1)};
  const RgbImage recorded = frame.radiance;
  frame.radiance = RgbImage(width_px, height_px);
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x) {
      frame.radiance.At(x, y) =
          recorded.At(x * recorded.width / width_px, y * recorded.height / height_px);
    }
  }
  frame.clipped = Gray8Image(width_px, height_px, 0);
  frame.unusable = Gray8Image(width_px, height_px, 0);
}

}  // namespace pleinair
