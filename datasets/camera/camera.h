// Cameras: their formats and controls, and their pictures as the drivers deliver them.
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

// A format and size that a camera offers.
struct CameraMode {
  PixelFormat format;
  int width_px = 0;
  int height_px = 0;
  std::vector<double> frames_per_second;  // Highest first; empty: not stated.
};

// A control and its range, in `unit`.
struct CameraControl {
  std::string name;  // As the driver states it.
  double minimum = 0.0;
  double maximum = 0.0;
  double value = 0.0;
  double standard = 0.0;
  std::string unit;  // Empty: the driver's own.
  bool is_read_only = false;
};

// A camera that can be opened.
struct CameraDescription {
  std::string device;  // A name for OpenCamera: "/dev/video0", "libcamera:ID".
  std::string name;    // Name of the product.
  // Is kept when the camera is plugged in again under another number; with a serial number, also at
  // another port.
  std::string identity;
  std::string driver;
  std::vector<CameraMode> modes;
  std::vector<CameraControl> controls;
};

// A request to a camera; unset values are the driver's choice.
struct CameraRequest {
  std::optional<PixelFormat> format;  // None: the best that can be decoded.
  std::optional<int> width_px;
  std::optional<int> height_px;
  std::optional<double> frames_per_second;  // None: the highest, up to 30.
  // Locked unless `automatic`: at these values, or where unset at the camera's values when it is
  // opened.
  std::optional<double> exposure_s;
  std::optional<double> gain;  // In the driver's unit.
  std::optional<double> white_balance_k;
  // Gains of red and blue against green, as in CameraSettings: for libcamera.
  std::optional<std::array<double, 2>> colour_gains;
  // The reference of CapturedExposure's gain with V4L2, in the driver's unit. None: the gain at
  // which the camera is locked, or that of an automatic one when it is opened.
  std::optional<double> reference_gain;
  bool automatic = false;  // Exposure, gain and white balance stay automatic, and are read back.
  // From setting a control to the frame that it applies to: of V4L2 cameras whose settings are read
  // back frame by frame. None: 2.
  std::optional<int> control_delay_frames;
  int ControlDelayFrames() const { return control_delay_frames.value_or(2); }
  std::optional<RawDevelopment> development;  // For raw pictures; none: as the driver states it.

  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

// The settings that a picture was taken with; what is unset is unknown.
struct CapturedExposure {
  std::optional<double> exposure_s;
  // Linear. With libcamera 1 is no amplification. V4L2 does not state the unit of gain: it is 1 at
  // the reference gain, unknown at any other.
  std::optional<double> gain;

  bool operator==(const CapturedExposure&) const = default;
};

// The values of a camera's controls; unset ones are unknown, or automatic.
struct CameraSettings {
  std::optional<double> exposure_s;
  std::optional<double> gain;  // In the driver's unit; of an automatic camera the reference.
  std::optional<double> white_balance_k;
  std::optional<std::array<double, 2>>
      colour_gains;  // Gains of red and blue, where there are no kelvins.
};

// The ISO value of gain 1.
std::optional<double> IsoOf(const CapturedExposure& exposure);

// One picture in the driver's own bytes.
struct CapturedBuffer {
  std::vector<std::byte> bytes;
  PictureLayout layout;
  // The driver's count; a jump is a loss. None where the driver has not counted the picture.
  std::optional<std::uint32_t> sequence;
  std::chrono::nanoseconds monotonic_time{0};  // Time of the exposure, on CLOCK_MONOTONIC.
  bool is_damaged = false;                     // The driver reports it.
  CapturedExposure exposure;
  std::optional<RawDevelopment> development;  // Levels of raw pictures.
};

// Why a picture is missing.
enum class CameraFaultKind {
  kEnded,  // The stream is over: only from stand-ins.
  kUnplugged,
  kStalled,   // No picture in time.
  kSettling,  // A picture that must not be used: the camera's automatics are not locked yet.
  kFormatChanged,
  kFailed,  // Anything else that the driver refuses.
};

// A fault of the camera, for events and reports.
struct CameraFault {
  CameraFaultKind kind = CameraFaultKind::kFailed;
  std::string reason;  // One line: the device, and what happened.
};

// A camera that streams; stops when it is destroyed. One thread at a time.
class CameraStream {
 public:
  virtual ~CameraStream() = default;
  // Returns the next picture, or why there is none. After a fault the stream is over, except for
  // kStalled and kSettling.
  virtual tl::expected<CapturedBuffer, CameraFault> Next(std::chrono::milliseconds timeout) = 0;
  virtual const PictureLayout& Layout() const = 0;
  virtual double FramesPerSecond() const = 0;  // 0: not stated.
  virtual const std::string& Identity() const = 0;
  // The request for a camera that comes back; empty until the camera is locked.
  virtual CameraSettings Settings() const { return {}; }
  // One line for each control that was refused, clamped or is missing, since the last call.
  virtual std::vector<std::string> TakeNotes() = 0;
};

// The result of ListCameras.
struct CameraList {
  std::vector<CameraDescription> cameras;  // In the order of their devices.
  std::vector<std::string> not_permitted;  // Devices that this user may not open.
  std::string libcamera_failure;           // Why libcamera's were not listed; else empty.
};

// All that can be opened now. A camera that another program holds is listed, too.
CameraList ListCameras();

// Whether `name` has the form of a camera's name; the camera may be absent: "/dev/videoN", a link
// to one such as udev makes in /dev/v4l/by-id and /dev/v4l/by-path, "libcamera:ID".
bool IsCameraName(const std::string& name);

// Throws std::runtime_error, one line with the device and what was expected; std::invalid_argument
// as CameraRequest::Validate.
std::unique_ptr<CameraStream> OpenCamera(const std::string& device, const CameraRequest& request);

// Returns the present device of the camera of this identity; none where it is absent. A camera that
// another program holds is found, too. "card|bus_info" is the first one at that port.
std::optional<std::string> FindCamera(const std::string& identity);

}  // namespace pleinair
