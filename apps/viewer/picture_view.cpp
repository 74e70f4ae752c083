#include "apps/viewer/picture_view.h"

#include <algorithm>
#include <array>
#include <utility>

#include <imgui.h>

#include "apps/viewer/to_im.h"
#include "apps/viewer/tool_marks.h"
#include "calib/lens.h"

namespace pleinair {
namespace {

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
  shows_board_ = TakeBoard(model);
  const glm::dvec2 size(Main().Width(), Main().Height());
  const bool has_other = model.tool == Tool::kColour && model.colour && model.colour->OtherShown();
  const glm::dvec2 area(area_size.x, has_other ? 0.5 * area_size.y : area_size.y);
  place_.scale = std::min(area.x / size.x, area.y / size.y);
  place_.origin = area_origin;
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const ImVec2 low = ToIm(place_.origin);
  const ImVec2 high = ToIm(place_.origin + place_.scale * size);
  window.ShowBehind(Main(), place_.origin, place_.origin + place_.scale * size);
  if (has_overlay_ && !shows_board_) list.AddImage(overlay_.Id(), low, high);
  list.PushClipRect(low, high, true);
  if (!shows_board_) {
    DrawBalls(model);
    DrawWindows(model);
  }
  DrawTool(model, size);
  list.PopClipRect();
  other_place_.reset();
  if (has_other) DrawOther(model, area_origin + glm::dvec2(0.0, area.y), area);
  DrawLoupes(model);
}

bool PictureView::TakeBoard(const ViewModel& model) {
  if (model.tool != Tool::kLens || !model.lens || !model.lens->Shown()) return false;
  if (board_shown_ != model.lens->Shown()) {
    board_shown_ = model.lens->Shown();
    board_.Upload(*board_shown_);
  }
  return true;
}

bool PictureView::IsIn(const Texture& texture,
                       const PicturePlace& place,
                       const glm::dvec2& screen) {
  const glm::dvec2 pixel = place.ToPixel(screen);
  return pixel.x >= -0.5 && pixel.y >= -0.5 && pixel.x < texture.Width() - 0.5 &&
         pixel.y < texture.Height() - 0.5;
}

void PictureView::DrawTool(const ViewModel& model, const glm::dvec2& size) {
  switch (model.tool) {
    case Tool::kObjects:
      return DrawSelection(model);
    case Tool::kMask:
      DrawMask(model, place_.origin, place_.origin + place_.scale * size);
      break;
    case Tool::kPose:
      if (model.pose) DrawPoseMarks(place_, model, HandPixel(model));
      break;
    case Tool::kColour:
      if (model.colour) DrawColourMarks(place_, PictureSide::kCamera, *model.colour);
      break;
    case Tool::kResponse:
      if (model.response) DrawResponseMarks(place_, *model.response);
      break;
    case Tool::kLens:
      if (model.lens) DrawLensMarks(place_, model);
      break;
  }
  if (model.cursor.is_shown && model.cursor.side == PictureSide::kCamera) {
    DrawCursor(place_, model.cursor);
  }
}

void PictureView::DrawOther(const ViewModel& model,
                            const glm::dvec2& origin,
                            const glm::dvec2& size) {
  if (other_shown_ != model.colour->OtherShown()) {
    other_shown_ = model.colour->OtherShown();
    other_.Upload(*other_shown_);
  }
  const glm::dvec2 pixels(other_.Width(), other_.Height());
  other_place_ = PicturePlace{origin, std::min(size.x / pixels.x, size.y / pixels.y)};
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const ImVec2 low = ToIm(origin);
  const ImVec2 high = ToIm(origin + other_place_->scale * pixels);
  list.AddImage(other_.Id(), low, high);
  list.PushClipRect(low, high, true);
  DrawColourMarks(*other_place_, PictureSide::kOther, *model.colour);
  if (model.cursor.is_shown && model.cursor.side == PictureSide::kOther) {
    DrawCursor(*other_place_, model.cursor);
  }
  list.PopClipRect();
}

glm::dvec2 PictureView::HandPixel(const ViewModel& model) const {
  if (model.cursor.is_shown) return model.cursor.pixel;
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  return place_.ToPixel({mouse.x, mouse.y});
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
      const auto from = ProjectToPixel(camera, corners[i]);
      const auto to = ProjectToPixel(camera, corners[i | axis]);
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
    const auto centre = ProjectToPixel(camera, ball.centre_world_m);
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
      const auto from = ProjectToPixel(camera, window.polygon_m[i]);
      const auto to = ProjectToPixel(camera, window.polygon_m[(i + 1) % window.polygon_m.size()]);
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
  if (model.brush_takes_surfaces) return;
  if (ImGui::GetIO().WantCaptureMouse && !model.cursor.is_shown) return;
  const float radius = static_cast<float>(model.brush_radius_px * place_.scale);
  list.AddCircle(ToIm(place_.ToScreen(HandPixel(model))), radius, IM_COL32(255, 255, 255, 200), 48);
}

void PictureView::DrawLoupes(const ViewModel& model) {
  if (model.tool == Tool::kObjects || model.tool == Tool::kMask) return;
  if (model.cursor.is_shown) {
    if (model.cursor.side == PictureSide::kCamera) {
      DrawLoupe(Main(), place_, model.cursor.pixel);
    } else if (other_place_) {
      DrawLoupe(other_, *other_place_, model.cursor.pixel);
    }
    return;
  }
  if (ImGui::GetIO().WantCaptureMouse) return;
  const glm::dvec2 mouse(ImGui::GetIO().MousePos.x, ImGui::GetIO().MousePos.y);
  if (OtherHolds(mouse)) {
    DrawLoupe(other_, *other_place_, other_place_->ToPixel(mouse));
  } else {
    DrawLoupe(Main(), place_, place_.ToPixel(mouse));
  }
}

void PictureView::DrawLoupe(const Texture& texture,
                            const PicturePlace& place,
                            const glm::dvec2& pixel) {
  constexpr double kShownPx = 12.0;  // To each side of the pointer.
  constexpr double kMagnified = 7.0;
  const glm::dvec2 size(texture.Width(), texture.Height());
  if (!(pixel.x >= 0.0 && pixel.y >= 0.0 && pixel.x < size.x && pixel.y < size.y)) return;
  const glm::dvec2 uv_low = (pixel + 0.5 - kShownPx) / size;
  const glm::dvec2 uv_high = (pixel + 0.5 + kShownPx) / size;
  const double side = 2.0 * kShownPx * kMagnified;
  // In the corner that the pointer is far from.
  const bool is_left = pixel.x > 0.5 * size.x;
  const glm::dvec2 corner =
      place.origin + glm::dvec2(is_left ? 8.0 : place.scale * size.x - side - 8.0, 8.0);
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.AddImage(texture.Id(), ToIm(corner), ToIm(corner + side), ToIm(uv_low), ToIm(uv_high));
  list.AddRect(ToIm(corner), ToIm(corner + side), IM_COL32(255, 255, 255, 200));
  const ImVec2 middle = ToIm(corner + 0.5 * side);
  const auto arm = static_cast<float>(0.5 * side);
  list.AddLine(
      {middle.x - arm, middle.y}, {middle.x + arm, middle.y}, IM_COL32(255, 255, 255, 110));
  list.AddLine(
      {middle.x, middle.y - arm}, {middle.x, middle.y + arm}, IM_COL32(255, 255, 255, 110));
}

}  // namespace pleinair
