#include <cstddef>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include "apps/viewer/actions.h"
#include "apps/viewer/panels/tool_parts.h"

namespace pleinair {
namespace {

void DrawRadius(const char* name, double& radius_px) {
  auto value = static_cast<float>(radius_px);
  if (ImGui::SliderFloat(name, &value, 1.0f, 80.0f, "%.1f", ImGuiSliderFlags_AlwaysClamp)) {
    radius_px = value;
  }
}

void DrawSurfaces(ColourPicker& picker) {
  std::optional<std::size_t> deleted;
  for (std::size_t i = 0; i < picker.Surfaces().size(); ++i) {
    const PickedSurface& surface = picker.Surfaces()[i];
    std::string line =
        fmt::format("{}: {:.1f}, {:.1f}", i + 1, surface.camera.at_px.x, surface.camera.at_px.y);
    if (!surface.other) line += "  not yet in the other picture";
    if (const auto residual = picker.ResidualOf(i)) {
      line += fmt::format(
          "  off by {:.1f} %{}", 100.0 * residual->relative, residual->counts ? "" : ", left out");
    }
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::SmallButton("x")) deleted = i;
    ImGui::PopID();
    ImGui::SameLine();
    ImGui::TextUnformatted(line.c_str());
  }
  if (deleted) picker.Delete(*deleted);
}

void DrawPatches(const ColourPicker& picker) {
  if (!picker.Tie() || !*picker.Tie()) return;
  const ColourTie& tie = **picker.Tie();
  // As on the chart: four rows of six.
  constexpr std::size_t kColumns = 6;
  for (std::size_t i = 0; i < tie.residual_relative.size(); ++i) {
    if (i % kColumns != 0) ImGui::SameLine();
    const std::string text =
        fmt::format("{:5.1f} %{}", 100.0 * tie.residual_relative[i], tie.counts[i] ? " " : "!");
    ImGui::TextUnformatted(text.c_str());
  }
}

}  // namespace

void DrawColourTool(ViewModel& model) {
  if (!model.colour) return;
  ColourPicker& picker = *model.colour;
  ImGui::TextWrapped("%s", picker.Describe().c_str());
  if (ImGui::RadioButton("surfaces", picker.Way() == ColourWay::kSurfaces)) {
    picker.SetWay(ColourWay::kSurfaces);
  }
  ImGui::SameLine();
  if (ImGui::RadioButton("ColorChecker", picker.Way() == ColourWay::kChart)) {
    picker.SetWay(ColourWay::kChart);
  }
  ImGui::SameLine();
  if (ImGui::Button("find it")) FindChart(model);
  if (picker.Way() == ColourWay::kSurfaces) {
    DrawRadius("radius, pixels", model.region_radius_px);
    DrawRadius("in the other picture", model.other_region_radius_px);
    DrawSurfaces(picker);
  } else {
    DrawPatches(picker);
  }
  std::string& file = model.typed_other_picture;
  const bool is_entered = ImGui::InputTextWithHint(
      "##other", "path of another picture", &file, ImGuiInputTextFlags_EnterReturnsTrue);
  ImGui::SameLine();
  if ((ImGui::Button("open") || is_entered) && !file.empty()) OpenOtherPicture(file, model);
  if (ImGui::Button("undo")) picker.Undo();
  ImGui::SameLine();
  if (ImGui::Button("save colours")) Save(model);  // Last: it ends the picker.
}

}  // namespace pleinair
