#include <array>
#include <utility>

#include <imgui.h>

#include "apps/viewer/panel.h"

namespace pleinair {

void DrawTimingPanel(ViewModel& model) {
  ImGui::Text("window: %.1f pictures a second, %.1f ms each",
              model.times.pictures_per_second,
              model.times.window_ms);
  if (model.site) {
    ImGui::PushTextWrapPos();
    ImGui::TextDisabled("composites by %s", model.site->renderer.c_str());
    ImGui::PopTextWrapPos();
  }
  if (model.times.drag_pictures_per_second > 0.0) {
    ImGui::Text("last drag: %.1f pictures a second,\ncomplete %.2f s after its end",
                model.times.drag_pictures_per_second,
                model.times.completed_after_s);
  }
  const FrameResult* result = model.Result();
  if (result == nullptr) return;
  const StageTimes& times = result->timing_ms;
  const std::array<std::pair<const char*, double>, 7> stages = {{{"read", times.read},
                                                                 {"transport", times.transport},
                                                                 {"estimate", times.estimate},
                                                                 {"relight", times.relight},
                                                                 {"probes", times.probes},
                                                                 {"render", times.render},
                                                                 {"read back", times.readback}}};
  double sum = 0.0;
  for (const auto& [name, ms] : stages) sum += ms;
  for (const auto& [name, ms] : stages) {
    const float share = sum > 0.0 ? static_cast<float>(ms / sum) : 0.0f;
    char text[32];
    std::snprintf(text, sizeof(text), "%.2f ms", ms);
    ImGui::ProgressBar(share, {0.6f * ImGui::GetContentRegionAvail().x, 0.0f}, text);
    ImGui::SameLine();
    ImGui::TextUnformatted(name);
  }
  ImGui::Text("frame %.1f ms; with what the panels show %.1f ms", sum, model.frame->work_ms);
  if (!ImGui::CollapsingHeader("works of this frame")) return;
  for (const PlannedWork& work : result->works) {
    if (!work.is_done) continue;
    ImGui::Text("%7.2f ms  %.*s%s",
                work.ms,
                static_cast<int>(work.name.size()),
                work.name.data(),
                work.is_kept      ? " (kept)"
                : work.is_drawing ? " (drawing)"
                                  : "");
  }
}

}  // namespace pleinair
