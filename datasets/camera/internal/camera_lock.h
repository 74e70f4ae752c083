// Exposure, gain and white balance of a V4L2 camera: locked, or read picture by picture.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "datasets/camera/camera.h"
#include "datasets/camera/internal/v4l2_device.h"

namespace pleinair {

// Settings by the count of the picture that they apply to.
class ExposureTimeline {
 public:
  explicit ExposureTimeline(int delay_frames) : delay_frames_(delay_frames) {}
  // Valid from `delay_frames` after this picture on.
  void Add(std::uint32_t sequence, const CapturedExposure& exposure);
  CapturedExposure At(std::uint32_t sequence);

 private:
  struct Entry {
    std::uint32_t from_sequence = 0;
    CapturedExposure exposure;
  };
  int delay_frames_;
  std::deque<Entry> entries_;
};

class CameraLock {
 public:
  // Sets the values of `request`. Automatic controls without a value stay automatic until Settle.
  CameraLock(const V4l2Device& device, const CameraRequest& request);

  static constexpr int kLongestDelayFrames = 4;
  // Pictures that the camera's automatics get before they are locked.
  static constexpr int kSettleFrames = 15;
  bool HasToSettle() const { return has_to_settle_; }
  // Locks at what the automatics have found.
  void Settle();

  // As in CameraStream.
  const CameraSettings& Settings() const { return settings_; }
  // The exposure of this picture, as it is dequeued.
  CapturedExposure Of(std::uint32_t sequence);
  // Pictures after a change of controls that may still be of the old ones: no fewer than any sensor
  // in use takes.
  int DelayFrames() const { return std::max(request_.ControlDelayFrames(), kLongestDelayFrames); }
  // Since the last call: what was refused, clamped or is missing, a line each.
  std::vector<std::string> TakeNotes() { return std::exchange(notes_, {}); }

 private:
  void Lock();
  void Set(std::uint32_t id, const std::string& what, int value);
  CapturedExposure Read() const;
  std::optional<double> Gain() const;

  const V4l2Device& device_;
  CameraRequest request_;
  bool has_to_settle_ = false;
  std::vector<std::string> notes_;
  std::optional<double> reference_gain_;
  CameraSettings settings_;
  CapturedExposure locked_;
  ExposureTimeline timeline_;
};

}  // namespace pleinair
