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

}  // namespace

void PictureView::Draw(ViewModel& model,
                       ViewWindow& window,
                       const glm::dvec2& area_origin,
                       const glm::dvec2& area_size) {
  if (!model.frame || model.frame->shown.Empty()) return;
  const ViewedFrame& frame = *model.frame;
  if (frame.number != number_) {
    shown_.Upload(frame.shown);
    has_overlay_ = !frame.overlay.Empty();
    if (has_overlay_) overlay_.Upload(frame.overlay);
    if (!frame.balls.empty()) ball_.Upload(frame.balls.front().picture);
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
  DrawSelection(model);
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
  for (const ShadedBall& ball : frame.balls) {
    const auto centre = PixelOf(camera, ball.centre_world_m);
    if (!centre) continue;
    const double depth_m = (camera.camera_from_world * glm::dvec4(ball.centre_world_m, 1.0)).z;
    const double radius = place_.scale * camera.intrinsics.fx_px * ball.radius_m / depth_m;
    const glm::dvec2 at = place_.ToScreen(*centre);
    ImGui::GetBackgroundDrawList()->AddImage(ball_.Id(), ToIm(at - radius), ToIm(at + radius));
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

}  // namespace pleinair
