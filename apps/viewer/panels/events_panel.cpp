#include <fmt/chrono.h>
#include <fmt/format.h>
#include <imgui.h>

#include "apps/viewer/panel.h"

namespace pleinair {

void DrawEventsPanel(ViewModel& model) {
  for (const Event& event : model.events) {
    const std::string line = fmt::format(
        "{:%H:%M:%S} {}: {}{}",
        fmt::gmtime(std::chrono::system_clock::to_time_t(
            std::chrono::time_point_cast<std::chrono::system_clock::duration>(event.time))),
        NameOf(event.kind),
        event.text,
        event.count > 1 ? fmt::format(" ({} frames)", event.count) : std::string());
    ImGui::TextWrapped("%s", line.c_str());
  }
  for (const std::string& note : model.notes) ImGui::TextWrapped("- %s", note.c_str());
  if (model.events.empty() && model.notes.empty()) ImGui::TextDisabled("nothing so far");
}

}  // namespace pleinair
