// Exposure, gain and white balance of a camera of libcamera: locked, or read request by request.
#pragma once

#include <libcamera/controls.h>

#include <string>
#include <utility>
#include <vector>

#include "datasets/camera/camera.h"

namespace pleinair {

// The settings of a completed request's picture, as libcamera states them, so that no delay needs
// to be considered. Gain is that of sensor and processor together.
CapturedExposure ExposureOf(const libcamera::ControlList& metadata);

// Levels of a raw picture of so many bits: black level and white balance as stated, else the usual
// ones.
RawDevelopment DevelopmentOf(const libcamera::ControlList& metadata, int bits);

class LibcameraLock {
 public:
  // `known` are the camera's controls and outlive the lock; `queued_requests` were sent before one
  // that is sent now.
  LibcameraLock(std::string device,
                const libcamera::ControlInfoMap& known,
                const CameraRequest& request,
                int queued_requests);

  // To start the camera with.
  libcamera::ControlList StartControls() const;

  // Takes a completed request, in order. Returns whether its picture may be delivered: not while
  // the camera's automatics settle, nor before the locked values apply.
  bool Take(const libcamera::ControlList& metadata);
  // To send with the next request.
  libcamera::ControlList TakeControls();
  // The exposure of the last request that was given to Take.
  const CapturedExposure& Exposure() const { return exposure_; }
  // The locked values of the automatics; empty where nothing had to settle.
  const CameraSettings& Settings() const { return settings_; }
  // Since the last call: what was refused, clamped or is missing, a line each.
  std::vector<std::string> TakeNotes() { return std::exchange(notes_, {}); }

 private:
  bool Knows(const libcamera::ControlId& control) const;
  void AddValues(libcamera::ControlList& controls, const libcamera::ControlList& found) const;
  void Lock(const libcamera::ControlList& found);
  void Check(const CapturedExposure& found);
  void NoteMissing(const libcamera::ControlId& control, const char* name, bool is_stated);

  std::string device_;
  const libcamera::ControlInfoMap& known_;
  CameraRequest request_;
  int queued_requests_;
  int frames_to_settle_ = 0;
  int frames_to_pass_ = 0;
  bool is_checked_ = false;
  libcamera::ControlList controls_;
  CapturedExposure exposure_;
  CapturedExposure wanted_;
  CameraSettings settings_;
  std::vector<std::string> notes_;
};

}  // namespace pleinair
