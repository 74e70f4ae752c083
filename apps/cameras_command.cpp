#include "apps/cameras_command.h"

#include <algorithm>
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

// A line for each list of sizes and rates, with all formats that have it.
std::string ModesText(const std::vector<CameraMode>& modes) {
  struct Sizes {
    std::string text;
    std::string rates;
  };
  std::vector<std::pair<std::string, std::vector<Sizes>>> formats;
  for (const CameraMode& mode : modes) {
    const std::string format = NameOf(mode.format);
    if (formats.empty() || formats.back().first != format) formats.push_back({format, {}});
    std::vector<Sizes>& sizes = formats.back().second;
    const std::string size = fmt::format("{}x{}", mode.width_px, mode.height_px);
    const std::string rates = RatesText(mode.frames_per_second);
    if (!sizes.empty() && sizes.back().rates == rates) {
      sizes.back().text += ", " + size;
    } else {
      sizes.push_back({size, rates});
    }
  }
  std::vector<std::pair<std::string, std::string>> lines;  // Formats, sizes with rates.
  for (const auto& [format, sizes] : formats) {
    std::string text;
    for (const Sizes& entry : sizes) {
      text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", entry.text, entry.rates);
    }
    const auto same = std::find_if(
        lines.begin(), lines.end(), [&](const auto& line) { return line.second == text; });
    if (same == lines.end()) {
      lines.emplace_back(format, text);
    } else {
      same->first += ", " + format;
    }
  }
  std::string text;
  for (const auto& [names, sizes] : lines) {
    text += fmt::format("  format    {}\n            {}\n", names, sizes);
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

// Where cameras may be that were not looked at, a line each.
std::vector<std::string> PassedOver(const CameraList& list) {
  std::vector<std::string> lines;
  for (const std::string& device : list.not_permitted) {
    lines.push_back(device +
                    ": this user may not open it: join the group video (adduser $USER video, then "
                    "log in again)");
  }
  if (!list.libcamera_failure.empty()) lines.push_back("libcamera: " + list.libcamera_failure);
  return lines;
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
  for (const std::string& line : PassedOver(list)) passed_over += "; " + MessageText(line);
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
      {"cameras", std::move(cameras)}, {"looked_at", kLookedAt}, {"passed_over", PassedOver(list)}};
  // Names of products are foreign text: what is not UTF-8 in them is replaced.
  return report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

}  // namespace pleinair
