#include <algorithm>
#include <cmath>

#include <imgui.h>

#include "apps/viewer/panel.h"

namespace pleinair {

// The sky from below, the zenith in the middle, north up, west right, as it is seen looking up.
void DrawDaylightPanel(ViewModel& model) {
  if (!model.frame || !model.frame->daylight) {
    ImGui::TextWrapped("Daylight does not come by samples here: the setting daylight decides.");
    return;
  }
  const ViewedDaylight& daylight = *model.frame->daylight;
  ImGui::TextWrapped("%s", daylight.note.c_str());
  const ImVec2 room = ImGui::GetContentRegionAvail();
  const float radius = std::max(20.0f, 0.5f * std::min(room.x, room.y) - 4.0f);
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const ImVec2 middle{corner.x + 0.5f * room.x, corner.y + radius};
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddCircleFilled(middle, radius, IM_COL32(20, 20, 24, 255), 64);
  list.AddCircle(middle, 0.5f * radius, IM_COL32(60, 60, 66, 255), 64);
  float largest = 0.0f;
  for (const DaylightSample& sample : daylight.samples) {
    largest = std::max(largest, sample.irradiance_rgb.y);
  }
  for (const DaylightSample& sample : daylight.samples) {
    // Equal areas for equal solid angles.
    const glm::vec3& to = sample.direction_enu;
    const float from_zenith = std::sqrt(std::max(0.0f, 1.0f - to.z));
    const float across = std::hypot(to.x, to.y);
    if (!(across > 0.0f)) continue;
    const ImVec2 at{middle.x - radius * from_zenith * to.x / across,
                    middle.y - radius * from_zenith * to.y / across};
    const float share = largest > 0.0f ? sample.irradiance_rgb.y / largest : 0.0f;
    list.AddCircleFilled(at, 1.0f + 2.0f * std::sqrt(share), IM_COL32(120, 190, 255, 190), 8);
  }
  ImGui::Dummy({room.x, 2.0f * radius});
}

}  // namespace pleinair
