// The fish-eye lens that tests see boards with.
#pragma once

#include "calib/fisheye_lens.h"
#include "sunmodel/angles.h"

namespace pleinair {

inline FisheyeIntrinsics TrueFisheye() {
  FisheyeIntrinsics lens;
  lens.model = FisheyeModel::kOpenCv;
  lens.width_px = 1000;
  lens.height_px = 800;
  lens.fx_px = 320.0;
  lens.fy_px = 322.0;
  lens.cx_px = 505.0;
  lens.cy_px = 390.0;
  lens.distortion = {-0.02, 0.004, -0.002, 0.0003};
  lens.max_angle_rad = RadFromDeg(110.0);
  return lens;
}

}  // namespace pleinair
