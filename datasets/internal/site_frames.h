// Pictures that come without a sequence of their own, as frames at a site.
#pragma once

#include <memory>

#include "calib/camera_noise.h"
#include "calib/response.h"
#include "datasets/camera/camera.h"
#include "datasets/camera/camera_picture.h"
#include "datasets/internal/sampling_mask.h"
#include "datasets/sequence.h"
#include "scene/frame.h"

namespace pleinair {

// A camera's own settings as metadata of a frame: ISO 100 at gain 1, and f/1, as
// the aperture is fixed. Relative light does not depend on these values.
void SetExposure(const CapturedExposure& exposure, FrameEntry& entry);

class SiteFrames {
 public:
  // `site` as ReadSite gives it; copied. Throws as MakeRecordedFrameSource, for response and mask.
  SiteFrames(const Sequence& site, const CameraNoise& noise);
  SiteFrames(const SiteFrames&) = delete;
  SiteFrames& operator=(const SiteFrames&) = delete;

  const Sequence& Site() const { return site_; }

  // `taken` has time and exposure. Light is relative: where the exposure is not known, per frame.
  // Throws std::runtime_error as ScaledTo.
  Frame Make(int index, const FrameEntry& taken, Rgb8Image codes) const;
  Frame Make(int index, const FrameEntry& taken, DevelopedPicture picture) const;

 private:
  Frame At(int index, const FrameEntry& taken, int width_px, int height_px) const;

  const Sequence site_;
  ResponseCurve response_;
  std::shared_ptr<const SignalNoise> noise_;
  SamplingMask mask_;
};

}  // namespace pleinair
