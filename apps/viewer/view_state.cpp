#include "apps/viewer/view_state.h"

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <fstream>

#include <nlohmann/json.hpp>

#include "scene/whole_file.h"

namespace pleinair {
namespace {

constexpr const char* kFile = "view.json";

}  // namespace

std::filesystem::path ViewStateFolder() {
  const char* config = std::getenv("XDG_CONFIG_HOME");
  if (config != nullptr && *config != '\0') return std::filesystem::path(config) / "pleinair";
  const char* home = std::getenv("HOME");
  if (home == nullptr || *home == '\0') return {};
  return std::filesystem::path(home) / ".config" / "pleinair";
}

std::optional<ViewState> ReadViewState(const std::filesystem::path& folder) {
  try {
    const nlohmann::json json = nlohmann::json::parse(std::ifstream(folder / kFile));
    ViewState state;
    const nlohmann::json& window = json.at("window");
    constexpr int kLeastPx = 320;
    constexpr int kMostPx = 16384;
    state.window.width = std::clamp(window.at("width").get<int>(), kLeastPx, kMostPx);
    state.window.height = std::clamp(window.at("height").get<int>(), kLeastPx, kMostPx);
    state.window.is_maximised = window.at("maximised").get<bool>();
    state.open_panels = json.at("open_panels").get<std::vector<std::string>>();
    state.overlay = json.at("overlay").get<std::string>();
    state.exposure_stops = std::clamp(json.at("exposure_stops").get<double>(), -6.0, 6.0);
    state.frames_per_second = std::clamp(json.at("frames_per_second").get<double>(), 0.1, 240.0);
    state.loops = json.at("loops").get<bool>();
    return state;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

void WriteViewState(const ViewState& state, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const nlohmann::ordered_json json = {{"window",
                                        {{"width", state.window.width},
                                         {"height", state.window.height},
                                         {"maximised", state.window.is_maximised}}},
                                       {"open_panels", state.open_panels},
                                       {"overlay", state.overlay},
                                       {"exposure_stops", state.exposure_stops},
                                       {"frames_per_second", state.frames_per_second},
                                       {"loops", state.loops}};
  WriteWholeText(folder / kFile, json.dump(2) + "\n");
}

}  // namespace pleinair
