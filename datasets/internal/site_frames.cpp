#include "datasets/internal/site_frames.h"

#include <utility>

#include "datasets/camera/live_frame_source.h"
#include "datasets/frame_source.h"
#include "datasets/internal/sequence_folder.h"
#include "datasets/picture_frame.h"

namespace pleinair {

void SetExposure(const CapturedExposure& exposure, FrameEntry& entry) {
  entry.exposure_s = exposure.exposure_s;
  entry.iso = IsoOf(exposure);
  if (entry.iso) entry.f_number = 1.0;
}

SiteFrames::SiteFrames(const Sequence& site, const CameraNoise& noise)
    : site_(site),
      response_(ResponseOf(site)),
      noise_(std::make_shared<SignalNoise>(response_, noise)),
      mask_(site_) {}

Frame SiteFrames::At(int index, const FrameEntry& taken, int width_px, int height_px) const {
  Frame frame;
  frame.index = index;
  frame.time = taken.time;
  frame.camera = site_.CameraOfFrame(0);
  frame.camera.intrinsics = ScaledTo(frame.camera.intrinsics, width_px, height_px);
  frame.sun_direction_enu = site_.StatedSunDirectionEnu(0);
  frame.weather = site_.WeatherOfFrame(0);
  frame.exposure = taken.EffectiveExposure();
  frame.exposure_s = taken.exposure_s;
  frame.units = frame.exposure ? LightUnits::kRelative : LightUnits::kRelativePerFrame;
  return frame;
}

Frame SiteFrames::Make(int index, const FrameEntry& taken, Rgb8Image codes) const {
  Frame frame = At(index, taken, codes.width, codes.height);
  SetCodes(std::move(codes), response_, noise_, frame);
  mask_.ApplyTo(frame);
  return frame;
}

Frame SiteFrames::Make(int index, const FrameEntry& taken, DevelopedPicture picture) const {
  Frame frame = At(index, taken, picture.signal_rgb.width, picture.signal_rgb.height);
  SetDeveloped(std::move(picture), frame);
  mask_.ApplyTo(frame);
  return frame;
}

}  // namespace pleinair
