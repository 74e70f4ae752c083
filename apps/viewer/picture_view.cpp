#include "apps/viewer/picture_view.h"

#include <algorithm>
#include <array>
#include <utility>

#include <imgui.h>

#include "calib/lens.h"

namespace pleinair {
namespace {

ImVec2 ToIm(const glm::dvec2& v) { return {static_cast<float>(v.x), static_cast<float>(v.y)}; }

std::optional<glm::dvec2> PixelOf(const Camera& camera, const glm::dvec3& point_world_m) {
  const glm::dvec3 point_camera(camera.camera_from_world * glm::dvec4(point_world_m, 1.0));
  if (!(point_camera.z > 0.0)) return std::nullopt;
  return ProjectToPixel(camera.intrinsics, point_camera);
}

// One below the other; all are of one size.
Rgba8Image Stacked(const std::vector<ShadedBall>& balls) {
  Rgba8Image stacked = balls.front().picture;
  for (std::size_t i = 1; i < balls.size(); ++i) {
    const std::vector<glm::u8vec4>& pixels = balls[i].picture.pixels;
    stacked.pixels.insert(stacked.pixels.end(), pixels.begin(), pixels.end());
    stacked.height += balls[i].picture.height;
  }
  return stacked;
}

}  // namespace

void PictureView::Draw(ViewModel& model,
                       ViewWindow& window,
                       const glm::dvec2& area_origin,
                       const glm::dvec2& area_size) {
  if (!model.frame || model.frame->shown.Empty()) return;
  const ViewedFrame& frame = *model.frame;
  if (frame.number != number_) {
    // Tools for what is real show it as it is.
    shown_.Upload(frame.input ? *frame.input : frame.shown);
    has_overlay_ = !frame.overlay.Empty();
    if (has_overlay_) overlay_.Upload(frame.overlay);
    if (!frame.balls.empty()) balls_.Upload(Stacked(frame.balls));
    number_ = frame.number;
  }
  const glm::dvec2 size(shown_.Width(), shown_.Height());
  place_.scale = std::min(area_size.x / size.x, area_size.y / size.y);
  place_.origin = area_origin;
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const ImVec2 low = ToIm(place_.origin);
  const ImVec2 high = ToIm(place_.origin + place_.scale * size);
  window.ShowBehind(shown_, place_.origin, place_.origin + place_.scale * size);
  if (has_overlay_) list.AddImage(overlay_.Id(), low, high);
  list.PushClipRect(low, high, true);
  DrawBalls(model);
  DrawWindows(model);
  switch (model.tool) {
    case Tool::kObjects:
      DrawSelection(model);
      break;
    case Tool::kMask:
      DrawMask(model, place_.origin, place_.origin + place_.scale * size);
      break;
    case Tool::kPose:
      DrawPose(model);
      break;
  }
  list.PopClipRect();
}

// The edges of the selected object's box.
void PictureView::DrawSelection(const ViewModel& model) {
  if (!model.editor || !model.editor->Selected() || !model.frame->step.frame) return;
  const Camera& camera = model.frame->step.frame->camera;
  const auto corners = model.editor->BoxOf(*model.editor->Selected());
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (const std::size_t axis : {1u, 2u, 4u}) {
      if ((i & axis) != 0) continue;
      const auto from = PixelOf(camera, corners[i]);
      const auto to = PixelOf(camera, corners[i | axis]);
      if (!from || !to) continue;
      list.AddLine(ToIm(place_.ToScreen(*from)),
                   ToIm(place_.ToScreen(*to)),
                   IM_COL32(255, 160, 40, 170),
                   1.5f);
    }
  }
}

void PictureView::DrawBalls(const ViewModel& model) {
  const ViewedFrame& frame = *model.frame;
  if (frame.balls.empty()) return;
  const Camera& camera = frame.step.frame->camera;
  const auto count = static_cast<float>(frame.balls.size());
  for (std::size_t i = 0; i < frame.balls.size(); ++i) {
    const ShadedBall& ball = frame.balls[i];
    const auto centre = PixelOf(camera, ball.centre_world_m);
    if (!centre) continue;
    const double depth_m = (camera.camera_from_world * glm::dvec4(ball.centre_world_m, 1.0)).z;
    const double radius = place_.scale * camera.intrinsics.fx_px * ball.radius_m / depth_m;
    const glm::dvec2 at = place_.ToScreen(*centre);
    ImGui::GetBackgroundDrawList()->AddImage(balls_.Id(),
                                             ToIm(at - radius),
                                             ToIm(at + radius),
                                             {0.0f, static_cast<float>(i) / count},
                                             {1.0f, static_cast<float>(i + 1) / count});
  }
}

void PictureView::DrawWindows(const ViewModel& model) {
  if (!model.frame->daylight) return;
  const Camera& camera = model.frame->step.frame->camera;
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  for (const Window& window : model.frame->daylight->windows) {
    for (std::size_t i = 0; i < window.polygon_m.size(); ++i) {
      const auto from = PixelOf(camera, window.polygon_m[i]);
      const auto to = PixelOf(camera, window.polygon_m[(i + 1) % window.polygon_m.size()]);
      if (!from || !to) continue;
      list.AddLine(ToIm(place_.ToScreen(*from)),
                   ToIm(place_.ToScreen(*to)),
                   IM_COL32(80, 170, 255, 230),
                   2.0f);
    }
  }
}

// Red where no samples are taken, and the brush.
void PictureView::DrawMask(const ViewModel& model, const glm::dvec2& low, const glm::dvec2& high) {
  if (!model.mask) return;
  const MaskPainter& painter = *model.mask;
  if (mask_version_ != painter.Version()) {
    const Gray8Image& mask = painter.Mask();
    Rgba8Image tint(mask.width, mask.height, kNoColour);
    for (std::size_t i = 0; i < tint.pixels.size(); ++i) {
      if (mask.pixels[i] != 255) tint.pixels[i] = {220, 30, 30, 130};
    }
    mask_.Upload(tint);
    mask_version_ = painter.Version();
  }
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.AddImage(mask_.Id(), ToIm(low), ToIm(high));
  if (ImGui::GetIO().WantCaptureMouse || model.brush_takes_surfaces) return;
  const float radius = static_cast<float>(model.brush_radius_px * place_.scale);
  list.AddCircle(ImGui::GetIO().MousePos, radius, IM_COL32(255, 255, 255, 200), 48);
}

// The mesh's edges as the pose has them, and each pick with its residual.
void PictureView::DrawPose(const ViewModel& model) {
  if (!model.pose) return;
  const PosePicker& picker = *model.pose;
  const Camera& camera = picker.Shown();
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  for (const MeshEdge& edge : picker.Edges()) {
    if (!edge.is_sharp && !edge.IsOutlineFrom(camera.CentreWorldM())) continue;
    const auto from = PixelOf(camera, edge.from_m);
    const auto to = PixelOf(camera, edge.to_m);
    if (!from || !to) continue;
    list.AddLine(
        ToIm(place_.ToScreen(*from)), ToIm(place_.ToScreen(*to)), IM_COL32(60, 230, 120, 140));
  }
  const auto& found = picker.Found();
  for (std::size_t i = 0; i < picker.Picks().size(); ++i) {
    const PointMatch& pick = picker.Picks()[i];
    const bool is_wrong = found && *found && !(*found)->counts[i];
    const ImU32 colour = is_wrong ? IM_COL32(255, 60, 60, 255) : IM_COL32(255, 210, 60, 255);
    const ImVec2 at = ToIm(place_.ToScreen(pick.pixel));
    constexpr float kArm = 6.0f;
    list.AddLine({at.x - kArm, at.y}, {at.x + kArm, at.y}, colour, 1.5f);
    list.AddLine({at.x, at.y - kArm}, {at.x, at.y + kArm}, colour, 1.5f);
    if (const auto corner = PixelOf(camera, pick.point_world_m)) {
      list.AddLine(at, ToIm(place_.ToScreen(*corner)), colour, 1.5f);
    }
  }
  if (ImGui::GetIO().WantCaptureMouse) return;
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  DrawLoupe(place_.ToPixel({mouse.x, mouse.y}));
}

void PictureView::DrawLoupe(const glm::dvec2& pixel) {
  constexpr double kShownPx = 12.0;  // To each side of the pointer.
  constexpr double kMagnified = 7.0;
  const glm::dvec2 size(shown_.Width(), shown_.Height());
  if (!(pixel.x >= 0.0 && pixel.y >= 0.0 && pixel.x < size.x && pixel.y < size.y)) return;
  const glm::dvec2 uv_low = (pixel + 0.5 - kShownPx) / size;
  const glm::dvec2 uv_high = (pixel + 0.5 + kShownPx) / size;
  const double side = 2.0 * kShownPx * kMagnified;
  // In the corner that the pointer is far from.
  const bool is_left = pixel.x > 0.5 * size.x;
  const glm::dvec2 corner =
      place_.origin + glm::dvec2(is_left ? 8.0 : place_.scale * size.x - side - 8.0, 8.0);
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.AddImage(shown_.Id(), ToIm(corner), ToIm(corner + side), ToIm(uv_low), ToIm(uv_high));
  list.AddRect(ToIm(corner), ToIm(corner + side), IM_COL32(255, 255, 255, 200));
  const ImVec2 middle = ToIm(corner + 0.5 * side);
  const auto arm = static_cast<float>(0.5 * side);
  list.AddLine(
      {middle.x - arm, middle.y}, {middle.x + arm, middle.y}, IM_COL32(255, 255, 255, 110));
  list.AddLine(
      {middle.x, middle.y - arm}, {middle.x, middle.y + arm}, IM_COL32(255, 255, 255, 110));
}

}  // namespace pleinair
