#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include <imgui.h>
#include <imgui_stdlib.h>

#include "apps/viewer/actions.h"
#include "apps/viewer/panels/tool_parts.h"
#include "calib/marker_detection.h"

namespace pleinair {
namespace {

// A number that is typed counts once it is complete.
constexpr ImGuiInputTextFlags kAtEnter = ImGuiInputTextFlags_EnterReturnsTrue;

void DrawModels(LensPicker& picker) {
  const auto choose = [&](const char* name, std::optional<LensModel> model) {
    if (ImGui::RadioButton(name, picker.Boards().model == model)) picker.SetModel(model);
  };
  choose("by fit", std::nullopt);
  ImGui::SameLine();
  choose("pinhole", LensModel::kPinhole);
  ImGui::SameLine();
  choose("fish-eye", LensModel::kFisheye);
}

void DrawBoardSize(LensPicker& picker) {
  bool is_found = !picker.Boards().size;
  const BoardSize now = picker.Board() ? picker.Board()->size : BoardSize{8, 6};
  if (ImGui::Checkbox("board's size as it is seen", &is_found)) {
    picker.SetSize(is_found ? std::nullopt : std::optional(now));
  }
  if (is_found) return;
  std::array<int, 2> typed{picker.Boards().size->columns, picker.Boards().size->rows};
  if (ImGui::InputInt2("inner corners (Enter)", typed.data(), kAtEnter)) {
    picker.SetSize(BoardSize{typed[0], typed[1]});
  }
}

void DrawMarkers(LensPicker& picker) {
  std::optional<CharucoMarkers> markers = picker.Boards().markers;
  bool is_charuco = markers.has_value();
  if (ImGui::Checkbox("ChArUco", &is_charuco)) {
    picker.SetMarkers(is_charuco ? std::optional(CharucoMarkers{}) : std::nullopt);
  }
  if (!markers) return;
  if (ImGui::BeginCombo("markers", markers->dictionary.c_str())) {
    for (const std::string& name : MarkerDictionaryNames()) {
      if (!ImGui::Selectable(name.c_str(), name == markers->dictionary)) continue;
      markers->dictionary = name;
      picker.SetMarkers(markers);
    }
    ImGui::EndCombo();
  }
  if (ImGui::InputDouble(
          "side over square's (Enter)", &markers->side_share, 0.0, 0.0, "%.3f", kAtEnter)) {
    picker.SetMarkers(markers);
  }
}

void DrawPictures(ViewModel& model) {
  LensPicker& picker = *model.lens;
  std::optional<std::size_t> deleted;
  std::optional<std::size_t> toggled;
  for (std::size_t i = 0; i < picker.Boards().pictures.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::SmallButton("x")) deleted = i;
    ImGui::SameLine();
    const BoardResult* result = picker.ResultOf(i);
    bool is_used = result != nullptr && result->left_out.empty();
    if (ImGui::Checkbox("##used", &is_used)) toggled = i;
    ImGui::SameLine();
    const std::string line = picker.DescribePicture(i);
    if (ImGui::Selectable(line.c_str(), picker.Selected() == i)) model.status = picker.Select(i);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", line.c_str());
    ImGui::PopID();
  }
  if (toggled) model.status = picker.ToggleUse(*toggled);
  if (deleted) picker.Delete(*deleted);
}

}  // namespace

void DrawLensTool(ViewModel& model) {
  if (!model.lens) return;
  LensPicker& picker = *model.lens;
  ImGui::TextWrapped("%s", picker.Describe().c_str());
  DrawModels(picker);
  DrawBoardSize(picker);
  DrawMarkers(picker);
  const bool is_entered = ImGui::InputTextWithHint(
      "##boards", "path of a picture or folder", &model.typed_boards, kAtEnter);
  ImGui::SameLine();
  if ((ImGui::Button("open") || is_entered) && !model.typed_boards.empty()) {
    OpenBoards(model.typed_boards, model);
  }
  if (ImGui::Button("take the picture")) TakePicture(model);
  ImGui::SameLine();
  if (ImGui::Button("undo")) picker.Undo();
  ImGui::SameLine();
  if (ImGui::Button("redo")) picker.Redo();
  ImGui::SameLine();
  if (ImGui::Button("save lens")) Save(model);
  ImGui::Checkbox("save it in doubt, too", &model.saves_lens_in_doubt);
  auto magnified = static_cast<float>(model.residuals_magnified);
  if (ImGui::SliderFloat("residuals x",
                         &magnified,
                         static_cast<float>(kLeastMagnification),
                         static_cast<float>(kLargestMagnification),
                         "%.0f",
                         ImGuiSliderFlags_AlwaysClamp)) {
    model.residuals_magnified = magnified;
  }
  if (ImGui::Selectable("the camera's picture", !picker.Selected())) {
    model.status = picker.Select(std::nullopt);
  }
  DrawPictures(model);
}

}  // namespace pleinair
