#include "datasets/camera/internal/libcamera_lock.h"

#include <libcamera/control_ids.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>

namespace pleinair {
namespace {

namespace controls = libcamera::controls;
using libcamera::ControlList;

// Pictures that the automatics of a camera get before they are locked.
constexpr int kSettleFrames = 15;
constexpr double kMicrosecondS = 1e-6;

// A sensor exposes by complete rows, and has steps of gain.
constexpr double kExposureStep = 0.02;
constexpr double kExposureRowS = 50e-6;
constexpr double kGainStep = 0.05;

}  // namespace

CapturedExposure ExposureOf(const ControlList& metadata) {
  CapturedExposure exposure;
  if (const auto time = metadata.get(controls::ExposureTime); time && *time > 0) {
    exposure.exposure_s = *time * kMicrosecondS;
  }
  if (const auto gain = metadata.get(controls::AnalogueGain); gain && *gain > 0.0f) {
    exposure.gain = static_cast<double>(*gain) * metadata.get(controls::DigitalGain).value_or(1.0f);
  }
  return exposure;
}

RawDevelopment DevelopmentOf(const ControlList& metadata, int bits) {
  RawDevelopment development = UsualDevelopment(bits);
  // Black levels of red, green, green and blue, at 16 bits.
  if (const auto black = metadata.get(controls::SensorBlackLevels)) {
    double sum = 0.0;
    for (const std::int32_t level : *black) sum += level;
    development.black_level = sum / static_cast<double>(black->size()) / std::exp2(16 - bits);
  }
  if (const auto gains = metadata.get(controls::ColourGains)) {
    const float red = (*gains)[0];
    const float blue = (*gains)[1];
    if (red > 0.0f && blue > 0.0f) development.white_balance_rgb = {red, 1.0, blue};
  }
  return development;
}

LibcameraLock::LibcameraLock(std::string device,
                             const libcamera::ControlInfoMap& known,
                             const CameraRequest& request,
                             int queued_requests)
    : device_(std::move(device)),
      known_(known),
      request_(request),
      queued_requests_(queued_requests),
      controls_(controls::controls) {
  if (request_.automatic) return;
  NoteMissing(controls::ExposureTime, "exposure", request_.exposure_s.has_value());
  NoteMissing(controls::AnalogueGain, "gain", request_.gain.has_value());
  if (request_.white_balance_k) {
    notes_.push_back(
        device_ + ": expected a control of white balance in kelvins, libcamera has none" +
        (Knows(controls::AwbEnable) ? ": it is locked at what the camera has found" : ""));
  }
  const bool exposes_by_itself =
      Knows(controls::AeEnable) && !(request_.exposure_s && request_.gain);
  const bool balances_by_itself =
      Knows(controls::AwbEnable) && !(request_.colour_gains && Knows(controls::ColourGains));
  if (exposes_by_itself || balances_by_itself) {
    frames_to_settle_ = kSettleFrames;
  } else {
    const bool is_anything_set =
        Knows(controls::AeEnable) || request_.exposure_s || request_.gain || request_.colour_gains;
    frames_to_pass_ = is_anything_set ? request_.ControlDelayFrames() : 0;
  }
}

bool LibcameraLock::Knows(const libcamera::ControlId& control) const {
  return known_.find(control.id()) != known_.end();
}

void LibcameraLock::NoteMissing(const libcamera::ControlId& control,
                                const char* name,
                                bool is_stated) {
  if (!is_stated || Knows(control)) return;
  notes_.push_back(fmt::format("{}: expected a control of {}, the camera has none", device_, name));
}

// The stated value, or else the one found; unset where neither is known.
void LibcameraLock::AddValues(ControlList& list, const ControlList& found) const {
  if (Knows(controls::ExposureTime)) {
    if (request_.exposure_s) {
      const double time = std::min(std::round(*request_.exposure_s / kMicrosecondS), 2e9);
      list.set(controls::ExposureTime, static_cast<std::int32_t>(time));
    } else if (const auto time = found.get(controls::ExposureTime)) {
      list.set(controls::ExposureTime, *time);
    }
  }
  if (Knows(controls::AnalogueGain)) {
    if (request_.gain) {
      list.set(controls::AnalogueGain, static_cast<float>(*request_.gain));
    } else if (const auto gain = found.get(controls::AnalogueGain)) {
      list.set(controls::AnalogueGain, *gain);
    }
  }
  if (Knows(controls::ColourGains)) {
    std::optional<std::array<float, 2>> gains;
    if (const auto& asked = request_.colour_gains) {
      gains = {static_cast<float>((*asked)[0]), static_cast<float>((*asked)[1])};
    } else if (const auto now = found.get(controls::ColourGains)) {
      gains = {(*now)[0], (*now)[1]};
    }
    if (gains) list.set(controls::ColourGains, libcamera::Span<const float, 2>(*gains));
  }
}

ControlList LibcameraLock::StartControls() const {
  ControlList list(controls::controls);
  if (request_.automatic) return list;
  AddValues(list, list);
  if (frames_to_settle_ > 0) return list;
  if (Knows(controls::AeEnable)) list.set(controls::AeEnable, false);
  if (Knows(controls::AwbEnable)) list.set(controls::AwbEnable, false);
  return list;
}

void LibcameraLock::Lock(const ControlList& found) {
  AddValues(controls_, found);
  if (Knows(controls::AeEnable)) controls_.set(controls::AeEnable, false);
  if (Knows(controls::AwbEnable)) controls_.set(controls::AwbEnable, false);
  if (const auto time = controls_.get(controls::ExposureTime)) {
    settings_.exposure_s = *time * kMicrosecondS;
  }
  if (const auto gain = controls_.get(controls::AnalogueGain)) settings_.gain = *gain;
  if (const auto gains = controls_.get(controls::ColourGains)) {
    settings_.colour_gains = {(*gains)[0], (*gains)[1]};
  }
  wanted_ = ExposureOf(found);
  frames_to_pass_ = queued_requests_ + request_.ControlDelayFrames();
}

ControlList LibcameraLock::TakeControls() {
  ControlList list = controls_;
  controls_.clear();
  return list;
}

bool LibcameraLock::Take(const ControlList& metadata) {
  exposure_ = ExposureOf(metadata);
  if (request_.automatic) return true;
  if (frames_to_settle_ > 0) {
    if (--frames_to_settle_ == 0) Lock(metadata);
    return false;
  }
  if (frames_to_pass_ > 0) {
    --frames_to_pass_;
    return false;
  }
  if (!is_checked_) Check(exposure_);
  is_checked_ = true;
  // Locked: unknown is only how it compares with other runs.
  if (exposure_.exposure_s && !exposure_.gain) exposure_.gain = 1.0;
  return true;
}

void LibcameraLock::Check(const CapturedExposure& found) {
  if (request_.exposure_s) wanted_.exposure_s = request_.exposure_s;
  if (request_.gain) wanted_.gain = request_.gain;
  if (!found.exposure_s) {
    notes_.push_back(device_ +
                     ": states no exposure time: brightness is compared within a picture only");
  } else if (wanted_.exposure_s && Knows(controls::ExposureTime) &&
             std::abs(*found.exposure_s - *wanted_.exposure_s) >
                 kExposureStep * *wanted_.exposure_s + kExposureRowS) {
    notes_.push_back(fmt::format("{}: exposure: expected {:g} s, the camera set {:g} s",
                                 device_,
                                 *wanted_.exposure_s,
                                 *found.exposure_s));
  }
  if (found.gain && wanted_.gain && Knows(controls::AnalogueGain) &&
      std::abs(*found.gain - *wanted_.gain) > kGainStep * *wanted_.gain) {
    notes_.push_back(fmt::format(
        "{}: gain: expected {:g}, the camera set {:g}", device_, *wanted_.gain, *found.gain));
  }
}

}  // namespace pleinair
