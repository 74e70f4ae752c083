#include <string>

#include <fmt/format.h>
#include <imgui.h>

#include "apps/viewer/actions.h"
#include "apps/viewer/panel.h"
#include "apps/viewer/panels/tool_parts.h"

namespace pleinair {
namespace {

void DrawMaskTool(ViewModel& model) {
  if (!model.mask) return;
  MaskPainter& mask = *model.mask;
  if (!mask.WhyNot().empty()) {
    ImGui::TextWrapped("%s", mask.WhyNot().c_str());
    return;
  }
  ImGui::TextWrapped("Paint over windows, plants, cars and people: no samples are taken there.");
  auto radius = static_cast<float>(model.brush_radius_px);
  if (ImGui::SliderFloat(
          "brush, pixels", &radius, 1.0f, 80.0f, "%.0f", ImGuiSliderFlags_AlwaysClamp)) {
    model.brush_radius_px = radius;
  }
  ImGui::Checkbox("give back (or hold Shift)", &model.brush_gives_back);
  ImGui::Checkbox("entire surfaces", &model.brush_takes_surfaces);
  ImGui::Text("%.1f %% of the picture is left out%s",
              100.0 * mask.MaskedShare(),
              mask.HasUnsavedStrokes() ? " * not saved" : "");
  if (ImGui::Button("undo stroke")) mask.Undo();
  ImGui::SameLine();
  if (ImGui::Button("save mask")) Save(model);
}

void DrawPoseTool(ViewModel& model) {
  if (!model.pose) return;
  PosePicker& pose = *model.pose;
  ImGui::TextWrapped("%s", pose.Describe().c_str());
  const auto& found = pose.Found();
  for (std::size_t i = 0; i < pose.Picks().size(); ++i) {
    const PointMatch& pick = pose.Picks()[i];
    std::string line = fmt::format("{}: {:.1f}, {:.1f}", i, pick.pixel.x, pick.pixel.y);
    if (found && *found) {
      line += fmt::format("  off by {:.2f} px{}",
                          (*found)->residual_px[i],
                          (*found)->counts[i] ? "" : ", left out");
    }
    ImGui::TextUnformatted(line.c_str());
  }
  if (ImGui::Button("undo")) pose.Undo();
  ImGui::SameLine();
  if (ImGui::Button("clear")) pose.Clear();
  ImGui::SameLine();
  if (ImGui::Button("refine by edges")) RefinePose(model);
  ImGui::SameLine();
  if (ImGui::Button("save pose")) Save(model);
}

}  // namespace

void DrawToolsPanel(ViewModel& model) {
  const auto choose = [&](const char* name, Tool tool) {
    if (ImGui::RadioButton(name, model.tool == tool)) TakeTool(tool, model);
  };
  choose("objects", Tool::kObjects);
  ImGui::SameLine();
  choose("mask", Tool::kMask);
  ImGui::SameLine();
  choose("camera's pose", Tool::kPose);
  choose("colours", Tool::kColour);
  ImGui::SameLine();
  choose("response", Tool::kResponse);
  ImGui::SameLine();
  choose("lens", Tool::kLens);
  ImGui::Separator();
  switch (model.tool) {
    case Tool::kObjects:
      ImGui::TextWrapped("Drag objects along surfaces; the panel Objects has more.");
      return;
    case Tool::kMask:
      return DrawMaskTool(model);
    case Tool::kPose:
      return DrawPoseTool(model);
    case Tool::kColour:
      return DrawColourTool(model);
    case Tool::kResponse:
      return DrawResponseTool(model);
    case Tool::kLens:
      return DrawLensTool(model);
  }
}

}  // namespace pleinair
