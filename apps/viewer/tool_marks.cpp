#include "apps/viewer/tool_marks.h"

#include <array>
#include <optional>
#include <string>

#include <imgui.h>

#include "apps/viewer/to_im.h"
#include "calib/lens.h"

namespace pleinair {
namespace {

constexpr ImU32 kGood = IM_COL32(255, 210, 60, 255);
constexpr ImU32 kLeftOut = IM_COL32(255, 60, 60, 255);

void DrawCross(const ImVec2& at, ImU32 colour) {
  constexpr float kArm = 6.0f;
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.AddLine({at.x - kArm, at.y}, {at.x + kArm, at.y}, colour, 1.5f);
  list.AddLine({at.x, at.y - kArm}, {at.x, at.y + kArm}, colour, 1.5f);
}

// Its field, as far as it is set, and the corner that is dark skin's.
void DrawChart(const PicturePlace& place, const ChartMarks& chart) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const std::vector<glm::dvec2>& corners = chart.Corners();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const ImVec2 at = ToIm(place.ToScreen(corners[i]));
    DrawCross(at, kGood);
    if (i == 0) list.AddCircle(at, 9.0f, kGood, 24, 1.5f);
    const bool has_next = i + 1 < corners.size() || chart.Complete().has_value();
    if (!has_next) continue;
    list.AddLine(at, ToIm(place.ToScreen(corners[(i + 1) % corners.size()])), kGood);
  }
}

}  // namespace

void DrawColourMarks(const PicturePlace& place, PictureSide side, const ColourPicker& picker) {
  if (picker.Way() == ColourWay::kChart) return DrawChart(place, picker.Chart(side));
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  for (std::size_t i = 0; i < picker.Surfaces().size(); ++i) {
    const PickedSurface& surface = picker.Surfaces()[i];
    if (side == PictureSide::kOther && !surface.other) continue;
    const PickedDisc& disc = side == PictureSide::kCamera ? surface.camera : *surface.other;
    const auto residual = picker.ResidualOf(i);
    const ImU32 colour = residual && !residual->counts ? kLeftOut : kGood;
    const ImVec2 at = ToIm(place.ToScreen(disc.at_px));
    const auto radius = static_cast<float>(place.scale * disc.radius_px);
    list.AddCircle(at, radius, colour, 32, 1.5f);
    const std::string number = std::to_string(i + 1);
    list.AddText({at.x + radius + 2.0f, at.y - 7.0f}, colour, number.c_str());
  }
}

void DrawResponseMarks(const PicturePlace& place, const ResponsePicker& picker) {
  if (picker.Way() == ResponseWay::kChart) DrawChart(place, picker.Chart());
}

void DrawLensMarks(const PicturePlace& place, const ViewModel& model) {
  const LensPicker& picker = *model.lens;
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const auto selected = picker.Selected();
  if (!selected) {
    for (std::size_t i = 0; i < picker.Boards().pictures.size(); ++i) {
      const BoardResult* result = picker.ResultOf(i);
      if (result == nullptr || !result->rms_px) continue;
      for (const BoardCorner& corner : result->board->corners) {
        list.AddCircleFilled(ToIm(place.ToScreen(corner.pixel)), 2.0f, kGood);
      }
    }
    return;
  }
  const BoardResult* result = picker.ResultOf(*selected);
  if (result == nullptr || !result->board) return;
  const ImU32 colour = result->left_out.empty() ? kGood : kLeftOut;
  const std::vector<BoardCorner>& corners = result->board->corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const ImVec2 at = ToIm(place.ToScreen(corners[i].pixel));
    list.AddCircle(at, 4.0f, colour);
    // Corners on the wrong squares are seen by lines that cross.
    if (i + 1 < corners.size() && corners[i + 1].place_squares.y == corners[i].place_squares.y) {
      list.AddLine(at, ToIm(place.ToScreen(corners[i + 1].pixel)), IM_COL32(60, 230, 120, 140));
    }
    if (!result->fit) continue;
    const glm::dvec2 off_px = model.residuals_magnified * result->fit->residual_px[i];
    list.AddLine(at, ToIm(place.ToScreen(corners[i].pixel + off_px)), colour, 2.0f);
  }
}

void DrawPoseMarks(const PicturePlace& place, const ViewModel& model, const glm::dvec2& hand_px) {
  const PosePicker& picker = *model.pose;
  const Camera& camera = picker.Shown();
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  for (const MeshEdge& edge : picker.Edges()) {
    if (!edge.is_sharp && !edge.IsOutlineFrom(camera.CentreWorldM())) continue;
    const auto from = ProjectToPixel(camera, edge.from_m);
    const auto to = ProjectToPixel(camera, edge.to_m);
    if (!from || !to) continue;
    list.AddLine(
        ToIm(place.ToScreen(*from)), ToIm(place.ToScreen(*to)), IM_COL32(60, 230, 120, 140));
  }
  const auto& found = picker.Found();
  for (std::size_t i = 0; i < picker.Picks().size(); ++i) {
    const PointMatch& pick = picker.Picks()[i];
    const bool is_wrong = found && *found && !(*found)->counts[i];
    const ImU32 colour = is_wrong ? kLeftOut : kGood;
    const ImVec2 at = ToIm(place.ToScreen(pick.pixel));
    DrawCross(at, colour);
    if (const auto corner = ProjectToPixel(camera, pick.point_world_m)) {
      list.AddLine(at, ToIm(place.ToScreen(*corner)), colour, 1.5f);
    }
  }
  const auto& held = model.hand.HeldCorner();
  const auto from = held ? ProjectToPixel(camera, *held) : std::nullopt;
  if (from) {
    list.AddLine(ToIm(place.ToScreen(*from)), ToIm(place.ToScreen(hand_px)), kGood, 1.5f);
  }
}

void DrawCursor(const PicturePlace& place, const PictureCursor& cursor) {
  const ImVec2 at = ToIm(place.ToScreen(cursor.pixel));
  constexpr float kGap = 3.0f;
  constexpr float kArm = 12.0f;
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  // Dark below light: seen on any picture.
  for (const auto& [colour, width] :
       {std::pair{IM_COL32(0, 0, 0, 255), 3.0f}, std::pair{IM_COL32(255, 255, 255, 255), 1.0f}}) {
    list.AddLine({at.x - kArm, at.y}, {at.x - kGap, at.y}, colour, width);
    list.AddLine({at.x + kGap, at.y}, {at.x + kArm, at.y}, colour, width);
    list.AddLine({at.x, at.y - kArm}, {at.x, at.y - kGap}, colour, width);
    list.AddLine({at.x, at.y + kGap}, {at.x, at.y + kArm}, colour, width);
  }
}

}  // namespace pleinair
