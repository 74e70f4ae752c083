#include "datasets/camera/internal/camera_lock.h"

#include <cmath>
#include <cstring>

#include <fmt/format.h>

namespace pleinair {
namespace {

constexpr double kExposureUnitS = 1e-4;  // Unit of V4L2_CID_EXPOSURE_ABSOLUTE.

struct AutomaticControl {
  std::uint32_t id;
  int off;
  std::uint32_t value_id;  // The control that it drives.
  const char* name;
};

constexpr AutomaticControl kAutomatics[] = {
    {V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL, V4L2_CID_EXPOSURE_ABSOLUTE, "exposure"},
    {V4L2_CID_AUTOGAIN, 0, V4L2_CID_GAIN, "gain"},
    {V4L2_CID_AUTO_WHITE_BALANCE, 0, V4L2_CID_WHITE_BALANCE_TEMPERATURE, "white balance"},
};

std::optional<int> Stated(const CameraRequest& request, std::uint32_t value_id) {
  const auto rounded = [](std::optional<double> value, double unit) -> std::optional<int> {
    if (!value) return std::nullopt;
    return static_cast<int>(std::lround(std::min(*value / unit, 2e9)));
  };
  switch (value_id) {
    case V4L2_CID_EXPOSURE_ABSOLUTE:
      return rounded(request.exposure_s, kExposureUnitS);
    case V4L2_CID_GAIN:
      return rounded(request.gain, 1.0);
    default:
      return rounded(request.white_balance_k, 1.0);
  }
}

}  // namespace

void ExposureTimeline::Add(std::uint32_t sequence, const CapturedExposure& exposure) {
  if (!entries_.empty() && entries_.back().exposure == exposure) return;
  // The first one has been valid before.
  const std::uint32_t delay = entries_.empty() ? 0 : static_cast<std::uint32_t>(delay_frames_);
  entries_.push_back({sequence + delay, exposure});
}

CapturedExposure ExposureTimeline::At(std::uint32_t sequence) {
  while (entries_.size() > 1 && entries_[1].from_sequence <= sequence) entries_.pop_front();
  return entries_.empty() ? CapturedExposure{} : entries_.front().exposure;
}

CameraLock::CameraLock(const V4l2Device& device, const CameraRequest& request)
    : device_(device), request_(request), timeline_(request.ControlDelayFrames()) {
  reference_gain_ = request_.reference_gain ? request_.reference_gain : Gain();
  if (request_.automatic) {
    settings_.gain = reference_gain_;
    return;
  }
  for (const AutomaticControl& automatic : kAutomatics) {
    const std::optional<int> mode = device_.GetControl(automatic.id);
    const bool is_automatic = mode && *mode != automatic.off;
    if (is_automatic && !Stated(request_, automatic.value_id)) has_to_settle_ = true;
  }
  if (!has_to_settle_) Lock();
}

void CameraLock::Settle() {
  Lock();
  has_to_settle_ = false;
}

void CameraLock::Lock() {
  for (const AutomaticControl& automatic : kAutomatics) {
    const std::optional<int> stated = Stated(request_, automatic.value_id);
    // Read before the automatics are off: some cameras fall back to their default then.
    const std::optional<int> found = device_.GetControl(automatic.value_id);
    const std::optional<int> mode = device_.GetControl(automatic.id);
    const bool was_automatic = mode && *mode != automatic.off;
    if (was_automatic) {
      Set(automatic.id, std::string("automatic ") + automatic.name, automatic.off);
    }
    if (stated && !found) {
      notes_.push_back(fmt::format(
          "{}: expected a control of {}, the camera has none", device_.Path(), automatic.name));
    } else if (stated || (was_automatic && found)) {
      Set(automatic.value_id, automatic.name, stated.value_or(found.value_or(0)));
    }
  }
  // A webcam may take longer exposures, and fewer pictures, in the dark.
  if (device_.GetControl(V4L2_CID_EXPOSURE_AUTO_PRIORITY).value_or(0) != 0) {
    Set(V4L2_CID_EXPOSURE_AUTO_PRIORITY, "exposure before rate", 0);
  }
  const std::optional<double> gain = Gain();
  if (!request_.reference_gain) reference_gain_ = gain;
  locked_ = Read();
  if (!locked_.gain) {
    notes_.push_back(fmt::format(
        "{}: gain: expected {:g} as before, it is {}: brightness is compared within a picture only",
        device_.Path(),
        *reference_gain_,
        gain ? fmt::format("{:g}", *gain) : "not stated"));
  }
  // Values that no request can state are left to the camera.
  settings_.exposure_s = locked_.exposure_s;
  if (gain && *gain >= 0.0) settings_.gain = gain;
  if (const auto kelvin = device_.GetControl(V4L2_CID_WHITE_BALANCE_TEMPERATURE);
      kelvin && *kelvin > 0) {
    settings_.white_balance_k = *kelvin;
  }
  if (!locked_.exposure_s) {
    locked_ = {};
    notes_.push_back(device_.Path() +
                     ": states no exposure time: brightness is compared within a picture only");
  }
}

void CameraLock::Set(std::uint32_t id, const std::string& what, int value) {
  const int error = device_.SetControl(id, value);
  const std::optional<int> is = device_.GetControl(id);
  if (is == value) return;
  if (error != 0) {
    notes_.push_back(fmt::format("{}: {}: expected {}, refused: {}{}",
                                 device_.Path(),
                                 what,
                                 value,
                                 std::strerror(error),
                                 is ? fmt::format("; it is {}", *is) : std::string()));
  } else if (is) {
    notes_.push_back(
        fmt::format("{}: {}: expected {}, the camera set {}", device_.Path(), what, value, *is));
  }
}

CapturedExposure CameraLock::Read() const {
  CapturedExposure exposure;
  if (const auto units = device_.GetControl(V4L2_CID_EXPOSURE_ABSOLUTE); units && *units > 0) {
    exposure.exposure_s = *units * kExposureUnitS;
  }
  // Drivers do not state the unit of gain: all that is known is whether it has changed.
  if (Gain() == reference_gain_) exposure.gain = 1.0;
  return exposure;
}

std::optional<double> CameraLock::Gain() const { return device_.GetControl(V4L2_CID_GAIN); }

CapturedExposure CameraLock::Of(std::uint32_t sequence) {
  if (!request_.automatic) return has_to_settle_ ? CapturedExposure{} : locked_;
  timeline_.Add(sequence, Read());
  return timeline_.At(sequence);
}

}  // namespace pleinair
