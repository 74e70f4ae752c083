// What is around the picture: menu, bar of playback, panels, help.
#pragma once

#include <glm/vec2.hpp>

#include "apps/viewer/view_model.h"

namespace pleinair {

// What is left for the picture, in screen units.
struct FreeArea {
  glm::dvec2 origin{0.0};
  glm::dvec2 size{0.0};
};

// Once a picture of the window, while Dear ImGui's frame is open.
FreeArea DrawChrome(ViewWindow& window, ViewModel& model);

}  // namespace pleinair
