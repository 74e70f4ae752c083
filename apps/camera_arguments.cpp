#include "apps/camera_arguments.h"

#include <array>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include <CLI/CLI.hpp>

#include "apps/cameras_command.h"
#include "apps/number_pair.h"

namespace pleinair {
namespace {

PixelFormat ParseFormat(const std::string& text) {
  const std::optional<PixelFormat> format = PixelFormatNamed(text);
  if (!format) {
    throw std::invalid_argument("--format '" + text +
                                "': expected a pixel format such as YUYV, MJPEG or SRGGB10");
  }
  return *format;
}

// Seconds, or a fraction of one as photographers write it: 1/250.
double ParseExposure(const std::string& text) {
  if (text.find('/') != std::string::npos) {
    const auto [seconds, parts] = ParsePair<double>(text, '/', "--exposure");
    return seconds / parts;
  }
  double seconds = 0.0;
  if (!CLI::detail::lexical_cast(text, seconds)) {
    throw std::invalid_argument("--exposure '" + text +
                                "': expected seconds, such as 0.004 or 1/250");
  }
  return seconds;
}

}  // namespace

void AddCameraOptions(CLI::App& command, CameraRequest& request) {
  command
      .add_option_function<std::string>(
          "--format",
          [&request](const std::string& text) { request.format = ParseFormat(text); },
          "pixel format, as `pleinair cameras` lists it (default: the best that can be decoded)")
      ->type_name("NAME")
      ->group(kCameraOptions);
  command
      .add_option_function<std::string>(
          "--size",
          [&request](const std::string& text) {
            const std::array<int, 2> size = ParsePair<int>(text, 'x', "--size");
            request.width_px = size[0];
            request.height_px = size[1];
          },
          "width and height in pixels (default: the camera's mode closest to 640x480)")
      ->type_name("WxH")
      ->group(kCameraOptions);
  command
      .add_option("--rate",
                  request.frames_per_second,
                  "frames a second (default: the camera's highest, up to 30)")
      ->check(Positive().description(""))
      ->type_name("HZ")
      ->group(kCameraOptions);
  command
      .add_option_function<std::string>(
          "--exposure",
          [&request](const std::string& text) { request.exposure_s = ParseExposure(text); },
          "exposure time in seconds, such as 0.004 or 1/250 (default: locked at the camera's "
          "current one)")
      ->type_name("SECONDS")
      ->group(kCameraOptions);
  command
      .add_option("--gain",
                  request.gain,
                  "gain in the driver's unit (default: locked at the camera's current one)")
      ->check(NotNegative().description(""))
      ->type_name("GAIN")
      ->group(kCameraOptions);
  command
      .add_option("--white-balance",
                  request.white_balance_k,
                  "colour temperature in kelvins (default: locked at the camera's current one)")
      ->check(Positive().description(""))
      ->type_name("KELVINS")
      ->group(kCameraOptions);
  command
      .add_flag("--auto",
                request.automatic,
                "exposure, gain and white balance stay automatic, and are read back for each frame")
      ->group(kCameraOptions);
  command
      .add_option("--control-delay",
                  request.control_delay_frames,
                  "with --auto, of V4L2: frames from setting exposure or gain to the first one "
                  "that shows it (default: 2)")
      ->check(CLI::Range(0, 16))
      ->type_name("FRAMES")
      ->default_str("")
      ->group(kCameraOptions);
}

void AddCameras(CLI::App& app, Work& work) {
  auto json = std::make_shared<bool>(false);
  CLI::App& cameras = *app.add_subcommand(
      "cameras", "Cameras that are plugged in: identity, formats, sizes, rates and controls");
  cameras.footer("Example: pleinair cameras");
  cameras.add_flag("--json", *json, "print JSON");
  cameras.callback([json, &work] {
    work = [json] {
      const CameraList list = ListCameras();
      return Print(*json ? CamerasJson(list) : CamerasText(list));
    };
  });
}

}  // namespace pleinair
