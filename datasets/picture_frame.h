// Fills the fields of a frame that follow from its picture only.
#pragma once

#include <memory>

#include "calib/camera_noise.h"
#include "calib/response.h"
#include "datasets/camera/camera_picture.h"
#include "scene/frame.h"

namespace pleinair {

// Sets `radiance`, `defects`, `clipped` and `unusable` for a linear picture, which is never
// clipped.
void SetRadiance(RgbImage radiance, Frame& frame);
// Whether such a picture has any finite pixel; `defects` are its own.
bool HasFinitePixel(const RgbImage& radiance, const ImageDefects& defects);

// Sets `codes`, `noise`, `radiance`, `clipped` and `unusable` for an 8-bit picture at
// frame.exposure, 1 where that is unknown. `noise` is for signals of `response`.
void SetCodes(Rgb8Image codes,
              const ResponseCurve& response,
              std::shared_ptr<const SignalNoise> noise,
              Frame& frame);

// Sets `radiance`, `defects`, `clipped` and `unusable` for a raw picture at frame.exposure, 1 where
// that is unknown.
void SetDeveloped(DevelopedPicture picture, Frame& frame);

}  // namespace pleinair
