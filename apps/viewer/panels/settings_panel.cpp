#include <exception>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include "apps/viewer/panel.h"
#include "session/settings.h"

namespace pleinair {
namespace {

bool Matches(const Setting& setting, const std::string& filter) {
  return filter.empty() || setting.name.find(filter) != std::string::npos ||
         setting.meaning.find(filter) != std::string::npos;
}

}  // namespace

void DrawSettingsPanel(ViewModel& model) {
  constexpr float kValueWidth = 0.38f;  // Of the panel's; names are beside it.
  ImGui::SetNextItemWidth(-1.0f);
  ImGui::InputTextWithHint("##filter", "search", &model.settings_filter);
  auto exposure = static_cast<float>(model.request.exposure_stops);
  ImGui::SetNextItemWidth(kValueWidth * ImGui::GetContentRegionAvail().x);
  if (ImGui::SliderFloat(
          "exposure shown, stops", &exposure, -6.0f, 6.0f, "%.1f", ImGuiSliderFlags_AlwaysClamp)) {
    model.request.exposure_stops = exposure;
  }
  ImGui::PushTextWrapPos();
  ImGui::TextDisabled("Enter applies; what depends on a changed setting is computed again");
  ImGui::PopTextWrapPos();
  ImGui::BeginChild("list");
  bool is_changed = false;
  for (const Setting& setting : Settings()) {
    if (!Matches(setting, model.settings_filter)) continue;
    ImGui::PushID(setting.name.c_str());
    std::string& text = model.typed_settings[setting.name];
    ImGui::SetNextItemWidth(kValueWidth * ImGui::GetContentRegionAvail().x);
    const auto stated = model.stated_settings.find(setting.name);
    const std::string& at_start =
        stated == model.stated_settings.end() ? setting.standard : stated->second;
    is_changed |= ImGui::InputTextWithHint(
        "##value", at_start.c_str(), &text, ImGuiInputTextFlags_EnterReturnsTrue);
    ImGui::SameLine();
    ImGui::TextUnformatted(setting.name.c_str());
    if (ImGui::IsItemHovered()) {
      ImGui::SetTooltip("%s\nvalues: %s\ndefault: %s",
                        setting.meaning.c_str(),
                        setting.values.c_str(),
                        setting.standard.c_str());
    }
    ImGui::PopID();
  }
  ImGui::EndChild();
  if (!is_changed) return;
  std::vector<std::string> settings;
  for (const auto& [name, text] : model.typed_settings) {
    if (!text.empty()) settings.push_back(fmt::format("{}={}", name, text));
  }
  // A value that does not hold changes nothing.
  try {
    SessionOptions tried;
    for (const std::string& assignment : settings) ApplySetting(assignment, tried);
  } catch (const std::exception& error) {
    model.status = error.what();
    return;
  }
  model.request.settings = std::move(settings);
  ++model.request.settings_changes;
}

}  // namespace pleinair
