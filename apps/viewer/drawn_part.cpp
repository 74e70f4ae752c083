#include "apps/viewer/drawn_part.h"

#include <algorithm>
#include <limits>
#include <span>

#include <imgui.h>

namespace pleinair {
namespace {

struct Box {
  ImVec2 low{std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity()};
  ImVec2 high{-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};

  void Add(const ImVec2& from, const ImVec2& to) {
    low = {std::min(low.x, from.x), std::min(low.y, from.y)};
    high = {std::max(high.x, to.x), std::max(high.y, to.y)};
  }
};

// What a list draws: within its clip rectangles, which can be larger than it.
Box BoxOf(const ImDrawList& list) {
  Box vertices;
  for (const ImDrawVert& vertex : list.VtxBuffer) vertices.Add(vertex.pos, vertex.pos);
  Box drawn;
  for (const ImDrawCmd& command : list.CmdBuffer) {
    const ImVec4& clip = command.ClipRect;
    if (command.ElemCount == 0) continue;
    drawn.Add({std::max(clip.x, vertices.low.x), std::max(clip.y, vertices.low.y)},
              {std::min(clip.z, vertices.high.x), std::min(clip.w, vertices.high.y)});
  }
  return drawn;
}

}  // namespace

bool CutsAWindow(const ImDrawData& data, const glm::dvec2& low, const glm::dvec2& high) {
  const std::span lists(data.CmdLists, static_cast<std::size_t>(data.CmdListsCount));
  return std::any_of(lists.begin(), lists.end(), [&](const ImDrawList* list) {
    if (list == ImGui::GetBackgroundDrawList()) return false;
    Box box = BoxOf(*list);
    // Smoothed borders reach a little further than their window.
    constexpr float kBorder = 2.0f;
    box.low = {box.low.x + kBorder, box.low.y + kBorder};
    box.high = {box.high.x - kBorder, box.high.y - kBorder};
    const bool meets =
        box.low.x < high.x && box.low.y < high.y && box.high.x > low.x && box.high.y > low.y;
    const bool is_within =
        box.low.x >= low.x && box.low.y >= low.y && box.high.x <= high.x && box.high.y <= high.y;
    return meets && !is_within;
  });
}

}  // namespace pleinair
