// Keys and what they do; docs/view.md lists them.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>

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
// Before each key `use_pointer` is called with the number of the pointer's edges that came before
// it.
void TakeKeys(const glm::dvec2& pointer_px,
              ViewWindow& window,
              const std::function<void(std::size_t)>& use_pointer,
              ViewModel& model);

}  // namespace pleinair
