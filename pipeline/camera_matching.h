// Gives virtual objects the noise and the blur of the camera's own picture.
#pragma once

#include <optional>

#include "calib/camera_noise.h"
#include "calib/edge_blur.h"
#include "render/compositor.h"
#include "scene/frame.h"
#include "scene/surface_view.h"

namespace pleinair {

// Which of the camera's imperfections virtual objects get.
struct CameraMatchingOptions {
  bool noise = true;  // For frames of code values; linear frames stay clean.
  bool blur = true;   // For all frames: a linear frame came through the same lens.
  // The camera's shot and read noise. None: measured in each frame.
  std::optional<CameraNoise> camera_noise;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// Keeps the measured blur from frame to frame. One thread at a time.
class CameraMatching {
 public:
  explicit CameraMatching(const CameraMatchingOptions& options);

  // Returns the blur for CompositeInput::camera_blur_px, as a Gaussian's standard deviation. It is
  // measured in the first frames together, each of them used once, and then kept: a lens does not
  // change.
  double BlurPx(const Frame& frame, const SurfaceView& view);

  // The blur, where BlurPx no longer looks at frames.
  std::optional<double> KnownBlurPx() const;

  // Adds noise to the pixels that the composite has changed, and to no other. A pixel that an
  // object covers gets all of the camera's noise; at its rim, where the camera's own pixel is
  // visible too, that is a little too much. Where real light was scaled together with its noise,
  // the missing part is added. Light from white on gets none, as the camera clips it. The noise
  // depends only on the frame's index, the pixel, the channel and the light. Rounding to codes is
  // left to the caller. `response` is that of frame.codes.
  void AddNoise(const Frame& frame, const ResponseCurve& response, Composite& composite) const;

 private:
  static constexpr int kFrames = 12;  // In which the blur is measured.

  CameraMatchingOptions options_;
  EdgeBlurMeter edge_blur_;
  int frames_seen_ = 0;
  std::optional<int> last_seen_;  // Its index.
};

}  // namespace pleinair
