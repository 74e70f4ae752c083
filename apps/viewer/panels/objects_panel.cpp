#include <numbers>
#include <string>

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include "apps/viewer/actions.h"
#include "apps/viewer/panel.h"

namespace pleinair {

void DrawObjectsPanel(ViewModel& model) {
  if (!model.editor) {
    ImGui::TextDisabled("no site yet");
    return;
  }
  ObjectEditor& editor = *model.editor;
  for (std::size_t i = 0; i < editor.Objects().size(); ++i) {
    const std::string label =
        fmt::format("{}: {}", i, editor.Objects()[i].mesh.filename().string());
    if (ImGui::Selectable(label.c_str(), editor.Selected() == i)) editor.Select(i);
  }
  if (editor.Objects().empty()) ImGui::TextDisabled("none: drop a glTF or OBJ file on the picture");
  std::string& file = model.typed_mesh;
  ImGui::SetNextItemWidth(-4.0f * ImGui::GetFontSize());
  const bool is_entered = ImGui::InputTextWithHint(
      "##file", "path of a mesh file", &file, ImGuiInputTextFlags_EnterReturnsTrue);
  ImGui::SameLine();
  if ((ImGui::Button("load") || is_entered) && !file.empty() && model.ShownCamera() != nullptr) {
    // In the middle of the picture.
    const CameraIntrinsics& camera = model.ShownCamera()->intrinsics;
    AddObject(file, 0.5 * glm::dvec2(camera.width_px - 1, camera.height_px - 1), model);
  }
  if (!editor.Selected()) return;
  const glm::dmat4& pose = editor.Objects()[*editor.Selected()].world_from_object;
  const glm::dvec3 axis = AxisOf(pose);
  ImGui::Separator();
  ImGui::Text("place %.3f east, %.3f north, %.3f up (m)", pose[3].x, pose[3].y, pose[3].z);
  ImGui::Text("axis %.3f, %.3f, %.3f; scale %.3f",
              axis.x,
              axis.y,
              axis.z,
              glm::length(glm::dvec3(pose[0])));
  constexpr double kTurnRad = std::numbers::pi / 12.0;
  if (ImGui::Button("turn -15")) editor.Turn(-kTurnRad);
  ImGui::SameLine();
  if (ImGui::Button("turn +15")) editor.Turn(kTurnRad);
  ImGui::SameLine();
  if (ImGui::Button("lift")) editor.Lift(0.05);
  ImGui::SameLine();
  if (ImGui::Button("lower")) editor.Lift(-0.05);
  if (ImGui::Button("larger")) editor.Scale(1.1);
  ImGui::SameLine();
  if (ImGui::Button("smaller")) editor.Scale(1.0 / 1.1);
  ImGui::SameLine();
  if (ImGui::Button("duplicate")) editor.Duplicate();
  ImGui::SameLine();
  if (ImGui::Button("delete")) editor.Delete();
}

}  // namespace pleinair
