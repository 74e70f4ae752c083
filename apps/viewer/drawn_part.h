// Which of Dear ImGui's windows a part of the screen cuts.
#pragma once

#include <glm/vec2.hpp>

struct ImDrawData;

namespace pleinair {

// Whether a window is partly within the corners, and partly not: where that part alone was drawn
// again, the window would be seen at two ages. In points; before anything has changed `data`. What
// lies behind all windows does not count.
bool CutsAWindow(const ImDrawData& data, const glm::dvec2& low, const glm::dvec2& high);

}  // namespace pleinair
