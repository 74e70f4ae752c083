#include "apps/input_refusals.h"

#include <filesystem>
#include <stdexcept>
#include <utility>

#include "datasets/picture_source.h"

namespace pleinair {
namespace {

[[noreturn]] void Refuse(const std::string& option,
                         const std::string& expected,
                         const std::string& found) {
  throw std::invalid_argument(option + ": expected " + expected + ", found " + found);
}

void RefuseTimes(const PictureTimes& times, const std::string& found) {
  const std::pair<bool, const char*> given[] = {{times.start.has_value(), "--start-time"},
                                                {times.interval.has_value(), "--every"},
                                                {!times.utc_offset.empty(), "--time-zone"}};
  for (const auto& [is_given, option] : given) {
    if (is_given) Refuse(option, "a video or pictures", found);
  }
}

// A video states when each of its pictures is shown.
void RefuseTimesOfVideo(const PictureTimes& times) {
  if (times.interval) Refuse("--every", "pictures", "a video");
  if (!times.utc_offset.empty()) Refuse("--time-zone", "pictures", "a video");
}

void RefuseCameraOptions(const CameraRequest& camera) {
  RefuseWithoutCamera(camera.format.has_value(), "--format");
  RefuseWithoutCamera(camera.width_px.has_value(), "--size");
  RefuseWithoutCamera(camera.frames_per_second.has_value(), "--rate");
  RefuseWithoutCamera(camera.exposure_s.has_value(), "--exposure");
  RefuseWithoutCamera(camera.gain.has_value(), "--gain");
  RefuseWithoutCamera(camera.white_balance_k.has_value(), "--white-balance");
  RefuseWithoutCamera(camera.automatic, "--auto");
  RefuseWithoutCamera(camera.control_delay_frames.has_value(), "--control-delay");
}

}  // namespace

bool PlayedInput::IsCamera() const { return !name.empty() && IsCameraName(name); }

void RefuseWithoutCamera(bool is_given, const std::string& option) {
  if (is_given) Refuse(option, "a camera", "recorded frames");
}

void RefuseContradictions(const SessionOptions& options) {
  if (!options.markers.empty() && !options.poses.empty()) {
    throw std::invalid_argument("--markers and --poses exclude each other");
  }
  if (!options.lighting.empty() && options.source) {
    throw std::invalid_argument("--lighting and --source exclude each other");
  }
}

void RefuseOtherInputs(const PlayedInput& input, const SessionOptions& options) {
  const std::string recorded = "a recorded sequence";
  const bool is_self_calibrated = options.albedo == AlbedoSource::kSelfCalibrated;
  if (input.IsCamera()) {
    RefuseTimes(input.times, "a camera");
    if (options.source == SourceKind::kFisheye) Refuse("--source fisheye", recorded, "a camera");
    if (is_self_calibrated) Refuse("the setting albedo", recorded, "a camera");
    return;
  }
  RefuseCameraOptions(input.camera);
  if (input.name.empty()) {
    RefuseTimes(input.times, "a sequence, which states its own");
    return;
  }
  if (is_self_calibrated) Refuse("albedo=self-calibrated", recorded, "a video or pictures");
  if (std::filesystem::is_regular_file(input.name) && !IsPictureOrFolder(input.name)) {
    RefuseTimesOfVideo(input.times);
  }
}

}  // namespace pleinair
