// Virtual objects as noisy and as soft as the camera's own picture.
#pragma once

#include <optional>

#include "calib/camera_noise.h"
#include "datasets/frame_source.h"
#include "render/compositor.h"
#include "scene/surface_view.h"

namespace pleinair {

// For frames that came as code values; what came as linear light is left as it is.
struct CameraMatchingOptions {
  bool noise = true;
  bool blur = true;
  // The camera's shot and read noise. None: each frame's own, measured.
  std::optional<CameraNoise> camera_noise;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

class CameraMatching {
 public:
  explicit CameraMatching(const CameraMatchingOptions& options);

  // For CompositeInput::object_blur_px. Measured in the first frame whose edges tell it, and kept:
  // a lens stays as it is.
  float ObjectBlurPx(const Frame& frame, const SurfaceView& view);

  // Adds noise to the pixels that the composite has changed, and to no other: all of a pixel's that
  // an object covers, what is missing where real light was scaled and its noise with it. The same
  // for the same frame's index, place and light; another one in each frame, pixel and channel.
  // Codes come of it by rounding. `response` is that of frame.codes.
  void AddNoise(const Frame& frame, const ResponseCurve& response, Composite& composite) const;

 private:
  CameraMatchingOptions options_;
  std::optional<float> blur_px_;
};

}  // namespace pleinair
