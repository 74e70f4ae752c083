// What a frame knows from its picture alone.
#pragma once

#include <memory>

#include "calib/camera_noise.h"
#include "calib/response.h"
#include "datasets/camera/camera_picture.h"
#include "scene/frame.h"

namespace pleinair {

// Sets `radiance`, `defects`, `clipped` and `unusable` of a linear picture, which is clipped
// nowhere.
void SetRadiance(RgbImage radiance, Frame& frame);
// Whether there is anything in such a picture to go by; `defects` are its own.
bool HasFinitePixel(const RgbImage& radiance, const ImageDefects& defects);

// Sets `codes`, `noise`, `radiance`, `clipped` and `unusable` of an 8-bit picture at
// frame.exposure, 1 where that is unknown. `noise` is that of signals of `response`.
void SetCodes(Rgb8Image codes,
              const ResponseCurve& response,
              std::shared_ptr<const SignalNoise> noise,
              Frame& frame);

// Sets `radiance`, `defects`, `clipped` and `unusable` of a raw picture at frame.exposure, 1 where
// that is unknown.
void SetDeveloped(DevelopedPicture picture, Frame& frame);

}  // namespace pleinair
