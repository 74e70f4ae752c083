// Virtual objects as noisy and as soft as the camera's own picture.
#pragma once

#include <optional>

#include "calib/camera_noise.h"
#include "calib/edge_blur.h"
#include "render/compositor.h"
#include "scene/frame.h"
#include "scene/surface_view.h"

namespace pleinair {

struct CameraMatchingOptions {
  bool noise = true;  // Of frames that came as code values; linear light is left clean.
  bool blur = true;   // Of any: a linear frame came through the same lens.
  // The camera's shot and read noise. None: each frame's own, measured.
  std::optional<CameraNoise> camera_noise;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

class CameraMatching {
 public:
  explicit CameraMatching(const CameraMatchingOptions& options);

  // Blur for CompositeInput::camera_blur_px. Measured in the first frames together, each of them
  // used once, and then kept: a lens does not change.
  double BlurPx(const Frame& frame, const SurfaceView& view);

  // Adds noise to the pixels that the composite has changed, and to no other: all of a pixel's that
  // an object covers (its rim, where the camera's own shines through, gets some too much), what is
  // missing where real light was scaled and its noise with it, and nothing to light from white on,
  // which the camera clips. The same for the same frame's index,
  // place and light; another one in each frame, pixel and channel. Codes come of it by rounding.
  // `response` is that of frame.codes.
  void AddNoise(const Frame& frame, const ResponseCurve& response, Composite& composite) const;

 private:
  CameraMatchingOptions options_;
  EdgeBlurMeter edge_blur_;
  int frames_seen_ = 0;
  std::optional<int> last_seen_;  // Its index.
};

}  // namespace pleinair
