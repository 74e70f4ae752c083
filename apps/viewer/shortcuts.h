// Keys and what they do; docs/view.md lists them.
#pragma once

#include <glm/vec2.hpp>

#include "apps/viewer/view_model.h"

namespace pleinair {

// For the help: keys, and what they do.
struct Shortcut {
  const char* keys;
  const char* help;
};
std::span<const Shortcut> Shortcuts();
// The key that opens and closes panel `index`; empty: none.
std::string KeyOfPanel(std::size_t index);

// Once a picture of the window, while Dear ImGui's frame is open. `pointer_px`: in the picture.
void TakeKeys(const glm::dvec2& pointer_px, ViewWindow& window, ViewModel& model);

}  // namespace pleinair
