// Cameras: what they offer, and their pictures one by one as their drivers give them.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "datasets/camera/camera_picture.h"
#include "datasets/camera/pixel_format.h"

namespace pleinair {

struct CameraMode {
  PixelFormat format;
  int width_px = 0;
  int height_px = 0;
  std::vector<double> frames_per_second;  // Highest first; empty: not stated.
};

struct CameraControl {
  std::string name;  // As the driver has it.
  double minimum = 0.0;
  double maximum = 0.0;
  double value = 0.0;
  double standard = 0.0;
  std::string unit;  // Empty: the driver's own.
  bool is_read_only = false;
};

struct CameraDescription {
  std::string device;  // What OpenCamera takes: "/dev/video0", "libcamera:ID".
  std::string name;    // Of the product.
  // Stays when the camera is plugged in again under another number; at another port, too, where
  // it has a serial number.
  std::string identity;
  std::string driver;
  std::vector<CameraMode> modes;
  std::vector<CameraControl> controls;
};

// What to ask of a camera; what is unset is the driver's choice.
struct CameraRequest {
  std::optional<PixelFormat> format;  // None: the best that can be decoded.
  std::optional<int> width_px;
  std::optional<int> height_px;
  std::optional<double> frames_per_second;  // None: the highest, up to 30.
  // Locked unless `automatic`: at these, or where they are unset at what they are when the camera
  // is opened.
  std::optional<double> exposure_s;
  std::optional<double> gain;  // In the driver's unit.
  std::optional<double> white_balance_k;
  // Of red and blue against green, as CameraSettings has them: for libcamera.
  std::optional<std::array<double, 2>> colour_gains;
  // What CapturedExposure's gain counts from with V4L2, in the driver's unit. None: the gain at
  // which the camera is locked, or which an automatic one has when it is opened.
  std::optional<double> reference_gain;
  bool automatic = false;  // Exposure, gain and white balance stay automatic, and are read back.
  int control_delay_frames = 2;  // From setting a control to the frame that it applies to.
  std::optional<RawDevelopment> development;  // Of raw pictures; none: as the driver states it.

  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

// The settings that a picture was taken with; what is unset is unknown.
struct CapturedExposure {
  std::optional<double> exposure_s;
  // Linear. Of libcamera's cameras 1 is no amplification. V4L2 does not state the unit of gain: 1
  // at the reference gain, unknown at any other.
  std::optional<double> gain;

  bool operator==(const CapturedExposure&) const = default;
};

// Where a camera's controls are; what is unset is unknown, or automatic.
struct CameraSettings {
  std::optional<double> exposure_s;
  std::optional<double> gain;  // In the driver's unit; of an automatic camera the reference.
  std::optional<double> white_balance_k;
  std::optional<std::array<double, 2>>
      colour_gains;  // Of red and blue: where there are no kelvins.
};

// ISO 100 stands for gain 1.
std::optional<double> IsoOf(const CapturedExposure& exposure);

struct CapturedBuffer {
  std::vector<std::byte> bytes;
  PictureLayout layout;
  std::uint32_t sequence = 0;                  // The driver's count; a jump is a loss.
  std::chrono::nanoseconds monotonic_time{0};  // Of the exposure, on CLOCK_MONOTONIC.
  bool is_damaged = false;                     // The driver reports it.
  CapturedExposure exposure;
  std::optional<RawDevelopment> development;  // Of raw ones.
};

enum class CameraFaultKind {
  kEnded,  // The stream is over: of stand-ins alone.
  kUnplugged,
  kStalled,   // No picture in time.
  kSettling,  // A picture came, and is not to be used: the camera's automatics are not locked yet.
  kFormatChanged,
  kFailed,  // Anything else that the driver refuses.
};

struct CameraFault {
  CameraFaultKind kind = CameraFaultKind::kFailed;
  std::string reason;  // One line: the device, and what happened.
};

// A camera that streams; stops when it is destroyed. One thread at a time.
class CameraStream {
 public:
  virtual ~CameraStream() = default;
  // The next picture, or why there is none. After a fault the stream is over, but for kStalled
  // and kSettling.
  virtual tl::expected<CapturedBuffer, CameraFault> Next(std::chrono::milliseconds timeout) = 0;
  virtual const PictureLayout& Layout() const = 0;
  virtual double FramesPerSecond() const = 0;  // 0: not stated.
  virtual const std::string& Identity() const = 0;
  // What a camera that comes back is to be asked for; empty until the camera is locked.
  virtual CameraSettings Settings() const { return {}; }
  // Since the last call: each control that was refused, clamped or is missing, a line each.
  virtual std::vector<std::string> TakeNotes() = 0;
};

struct CameraList {
  std::vector<CameraDescription> cameras;  // In the order of their devices.
  std::vector<std::string> not_permitted;  // Devices that this user may not open.
  std::string libcamera_failure;           // Why libcamera's were not looked at; else empty.
};

// All that can be opened now. A camera that another program holds is listed, too.
CameraList ListCameras();

// Whether `name` has the form of a camera's name: "/dev/videoN", a link to one such as udev makes
// in /dev/v4l/by-id and /dev/v4l/by-path, "libcamera:ID". It may not be there.
bool IsCameraName(const std::string& name);

// Throws std::runtime_error, one line with the device and what was expected; std::invalid_argument
// as CameraRequest::Validate.
std::unique_ptr<CameraStream> OpenCamera(const std::string& device, const CameraRequest& request);

// The device where the camera of this identity is now; none where it is not there. A camera that
// another program holds is found, too. "card|bus_info" is the first one at that port.
std::optional<std::string> FindCamera(const std::string& identity);

}  // namespace pleinair
