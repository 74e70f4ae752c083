// Points of ours for Dear ImGui.
#pragma once

#include <imgui.h>
#include <glm/vec2.hpp>

namespace pleinair {

inline ImVec2 ToIm(const glm::dvec2& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y)};
}

}  // namespace pleinair
