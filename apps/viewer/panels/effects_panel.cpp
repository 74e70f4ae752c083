#include <array>

#include <imgui.h>

#include "apps/viewer/panel.h"
#include "pipeline/effect.h"

namespace pleinair {
namespace {

const char* TextOf(EffectFate fate) {
  switch (fate) {
    case EffectFate::kOff:
      return "off";
    case EffectFate::kLeftOut:
      return "left out";
    case EffectFate::kKept:
      return "kept";
    case EffectFate::kRun:
      return "run";
  }
  return "";
}

}  // namespace

void DrawEffectsPanel(ViewModel& model) {
  const FrameResult* result = model.Result();
  constexpr std::array kSwitches = {"off", "plan", "on"};
  const ImGuiTableFlags flags = ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp;
  if (ImGui::BeginTable("effects", 5, flags)) {
    ImGui::TableSetupColumn("effect", ImGuiTableColumnFlags_WidthStretch, 2.6f);
    ImGui::TableSetupColumn("asked", ImGuiTableColumnFlags_WidthStretch, 1.2f);
    ImGui::TableSetupColumn("fate", ImGuiTableColumnFlags_WidthStretch, 1.4f);
    ImGui::TableSetupColumn("bound", ImGuiTableColumnFlags_WidthStretch, 1.0f);
    ImGui::TableSetupColumn("+ ms", ImGuiTableColumnFlags_WidthStretch, 0.8f);
    ImGui::TableHeadersRow();
    for (const Effect effect : kAllEffects) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(NameOf(effect).data());
      if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", HelpOf(effect).data());
      ImGui::TableNextColumn();
      ImGui::PushID(static_cast<int>(effect));
      int chosen = static_cast<int>(model.request.effects[effect]);
      ImGui::SetNextItemWidth(-1.0f);
      if (ImGui::Combo("##switch", &chosen, kSwitches.data(), static_cast<int>(kSwitches.size()))) {
        model.request.effects[effect] = static_cast<EffectSwitch>(chosen);
      }
      ImGui::PopID();
      if (result == nullptr) continue;
      const PlannedEffect& planned = result->plan.Of(effect);
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(TextOf(planned.fate));
      if (!planned.why.empty() && ImGui::IsItemHovered()) {
        ImGui::SetTooltip("%.*s", static_cast<int>(planned.why.size()), planned.why.data());
      }
      ImGui::TableNextColumn();
      ImGui::Text("%.1f", planned.bound_code_values);
      ImGui::TableNextColumn();
      ImGui::Text("%.1f", planned.expected_ms);
    }
    ImGui::EndTable();
  }
  auto threshold = static_cast<float>(model.request.effects.threshold_code_values);
  ImGui::SetNextItemWidth(0.4f * ImGui::GetContentRegionAvail().x);
  if (ImGui::SliderFloat("may be left out, code values",
                         &threshold,
                         0.0f,
                         20.0f,
                         "%.1f",
                         ImGuiSliderFlags_AlwaysClamp)) {
    model.request.effects.threshold_code_values = threshold;
  }
  if (result == nullptr) return;
  ImGui::TextDisabled("left out: %.2f code values at most; the plan saves %.1f ms of %.1f",
                      result->plan.left_out_code_values,
                      result->plan.SavedMs(),
                      result->plan.all_expected_ms);
}

}  // namespace pleinair
