#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <imgui.h>

#include "apps/viewer/actions.h"
#include "apps/viewer/panels/tool_parts.h"

namespace pleinair {
namespace {

// Light over the code, of red, green and blue.
void DrawCurves(const ResponseTable& table) {
  constexpr float kHeight = 90.0f;
  const ImVec2 origin = ImGui::GetCursorScreenPos();
  const ImVec2 size(std::max(64.0f, ImGui::GetContentRegionAvail().x), kHeight);
  ImGui::Dummy(size);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(origin, {origin.x + size.x, origin.y + size.y}, IM_COL32(20, 20, 24, 255));
  constexpr std::array<ImU32, 3> kColours{
      IM_COL32(240, 90, 80, 255), IM_COL32(90, 220, 110, 255), IM_COL32(100, 150, 255, 255)};
  for (std::size_t c = 0; c < table.size(); ++c) {
    for (std::size_t code = 1; code < table[c].size(); ++code) {
      const auto at = [&](std::size_t which) {
        return ImVec2(origin.x + size.x * static_cast<float>(which) / 255.0f,
                      origin.y + size.y * (1.0f - table[c][which]));
      };
      list.AddLine(at(code - 1), at(code), kColours.at(c));
    }
  }
}

std::string LineOf(const ResponsePicker& picker, std::size_t picture) {
  const TakenPicture& taken = picker.Pictures()[picture];
  std::string line = taken.name;
  if (taken.exposure) line += fmt::format("  exposure {:.4g}", *taken.exposure);
  if (picture >= picker.Residuals().size()) return line;
  const TakenResidual& residual = picker.Residuals()[picture];
  if (!residual.left_out.empty()) return line + "  left out: " + residual.left_out;
  if (!residual.is_compared) return line + "  not compared: too few pictures";
  return line + fmt::format("  off by {:+.1f} %, scatters by {:.1f} %",
                            100.0 * residual.offset_relative,
                            100.0 * residual.scatter_relative);
}

}  // namespace

void DrawResponseTool(ViewModel& model) {
  if (!model.response) return;
  ResponsePicker& picker = *model.response;
  ImGui::TextWrapped("%s", picker.Describe().c_str());
  if (ImGui::RadioButton("bracket", picker.Way() == ResponseWay::kBracket)) {
    picker.SetWay(ResponseWay::kBracket);
  }
  ImGui::SameLine();
  if (ImGui::RadioButton("ColorChecker", picker.Way() == ResponseWay::kChart)) {
    picker.SetWay(ResponseWay::kChart);
  }
  ImGui::SameLine();
  if (ImGui::Button("find it")) FindChart(model);
  std::optional<std::size_t> deleted;
  for (std::size_t i = 0; i < picker.Pictures().size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::SmallButton("x")) deleted = i;
    ImGui::PopID();
    ImGui::SameLine();
    ImGui::TextWrapped("%s", LineOf(picker, i).c_str());
  }
  if (deleted) picker.Delete(*deleted);
  if (picker.Found() && *picker.Found()) DrawCurves((*picker.Found())->table);
  ImGui::InputDouble("exposure (0: its own)", &model.typed_exposure, 0.0, 0.0, "%.6g");
  if (ImGui::Button("take the picture")) TakePicture(model);
  ImGui::SameLine();
  if (ImGui::Button("undo")) picker.Undo();
  ImGui::SameLine();
  if (ImGui::Button("save response")) Save(model);
}

}  // namespace pleinair
