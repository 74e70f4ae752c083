// What the window remembers from one start to the next.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/viewer/window.h"

namespace pleinair {

struct ViewState {
  ScreenPlace window;
  std::vector<std::string> open_panels;  // Their names.
  std::string overlay;                   // Its name; empty: none.
  double exposure_stops = 0.0;
  double frames_per_second = 10.0;
  bool loops = true;
};

// $XDG_CONFIG_HOME/pleinair, or ~/.config/pleinair; empty where neither is known.
std::filesystem::path ViewStateFolder();

// `folder`/view.json; none where it is absent or does not hold: a window opens as at first.
std::optional<ViewState> ReadViewState(const std::filesystem::path& folder);

// Throws std::runtime_error, one line, where it cannot be written.
void WriteViewState(const ViewState& state, const std::filesystem::path& folder);

}  // namespace pleinair
