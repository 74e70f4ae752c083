#include "apps/cameras_command.h"

#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/message_text.h"

namespace pleinair {
namespace {

constexpr const char* kLookedAt = "/dev/video0 to /dev/video255 (V4L2), libcamera";

std::string RatesText(const std::vector<double>& rates) {
  if (rates.empty()) return "rate not stated";
  std::string text;
  for (const double rate : rates) text += fmt::format("{}{:.4g}", text.empty() ? "" : ", ", rate);
  return text + " Hz";
}

// Modes of one format; those that share their rates share a line.
std::string ModesText(const std::vector<CameraMode>& modes) {
  struct Line {
    std::string format;
    std::string sizes;
    std::string rates;
  };
  std::vector<Line> lines;
  for (const CameraMode& mode : modes) {
    Line line{NameOf(mode.format),
              fmt::format("{}x{}", mode.width_px, mode.height_px),
              RatesText(mode.frames_per_second)};
    if (!lines.empty() && lines.back().format == line.format && lines.back().rates == line.rates) {
      lines.back().sizes += ", " + line.sizes;
    } else {
      lines.push_back(std::move(line));
    }
  }
  std::string text;
  for (const Line& line : lines) {
    text += fmt::format("  format    {:<9} {}: {}\n", line.format, line.sizes, line.rates);
  }
  return text;
}

std::string ControlText(const CameraControl& control) {
  return fmt::format("  control   {}{}: {}, {} to {}, default {}{}\n",
                     MessageText(control.name),
                     control.unit.empty() ? "" : fmt::format(" [{}]", control.unit),
                     control.value,
                     control.minimum,
                     control.maximum,
                     control.standard,
                     control.is_read_only ? ", read only" : "");
}

nlohmann::json ModeJson(const CameraMode& mode) {
  return {{"format", NameOf(mode.format)},
          {"width", mode.width_px},
          {"height", mode.height_px},
          {"frames_per_second", mode.frames_per_second}};
}

nlohmann::json ControlJson(const CameraControl& control) {
  return {{"name", control.name},
          {"minimum", control.minimum},
          {"maximum", control.maximum},
          {"value", control.value},
          {"default", control.standard},
          {"unit", control.unit},
          {"read_only", control.is_read_only}};
}

nlohmann::json CameraJson(const CameraDescription& camera) {
  nlohmann::json modes = nlohmann::json::array();
  for (const CameraMode& mode : camera.modes) modes.push_back(ModeJson(mode));
  nlohmann::json controls = nlohmann::json::array();
  for (const CameraControl& control : camera.controls) controls.push_back(ControlJson(control));
  return {{"device", camera.device},
          {"name", camera.name},
          {"identity", camera.identity},
          {"driver", camera.driver},
          {"modes", std::move(modes)},
          {"controls", std::move(controls)}};
}

}  // namespace

std::string CamerasText(const CameraList& list) {
  std::string text;
  for (const CameraDescription& camera : list.cameras) {
    text += fmt::format("{}\n  name      {}\n  identity  {}\n  driver    {}\n",
                        MessageText(camera.device),
                        MessageText(camera.name),
                        MessageText(camera.identity),
                        MessageText(camera.driver));
    text += ModesText(camera.modes);
    if (camera.modes.empty()) text += "  format    none that can be decoded\n";
    for (const CameraControl& control : camera.controls) text += ControlText(control);
  }
  std::string passed_over;
  for (const std::string& line : list.passed_over) passed_over += "; " + MessageText(line);
  if (list.cameras.empty()) {
    return fmt::format("no camera; looked at {}{}\n", kLookedAt, passed_over);
  }
  if (!passed_over.empty()) text += "passed over: " + passed_over.substr(2) + "\n";
  return text;
}

std::string CamerasJson(const CameraList& list) {
  nlohmann::json cameras = nlohmann::json::array();
  for (const CameraDescription& camera : list.cameras) cameras.push_back(CameraJson(camera));
  const nlohmann::json report = {
      {"cameras", std::move(cameras)}, {"looked_at", kLookedAt}, {"passed_over", list.passed_over}};
  // Names of products are foreign text: what is not UTF-8 in them is replaced.
  return report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

}  // namespace pleinair
