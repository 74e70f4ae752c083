#include "apps/viewer/pointer_tools.h"

#include <cmath>
#include <numbers>

#include <imgui.h>
#include <glm/geometric.hpp>

namespace pleinair {
namespace {

glm::dvec2 PixelAtPointer(const PicturePlace& place) {
  const ImVec2 at = ImGui::GetIO().MousePos;
  return place.ToPixel({at.x, at.y});
}

void TurnByWheel(double notches, ObjectEditor& editor) {
  if (ImGui::GetIO().KeyCtrl) {
    editor.Scale(std::pow(1.05, notches));
  } else if (ImGui::GetIO().KeyShift) {
    editor.Lift(0.02 * notches);
  } else {
    editor.Turn(std::numbers::pi / 36.0 * notches);
  }
}

}  // namespace

void PointerTools::Take(const PicturePlace& place, const ViewWindow& window, ViewModel& model) {
  if (!model.editor || model.ShownCamera() == nullptr) return;
  if (tool_ != model.tool) EndGestures(model);
  constexpr double kReach = 14.0;  // On the screen.
  switch (model.tool) {
    case Tool::kObjects:
      return MoveObjects(place, window, model);
    case Tool::kMask:
      return PaintMask(PixelAtPointer(place), model);
    case Tool::kPose:
      return PickPose(PixelAtPointer(place), kReach / place.scale, model);
  }
}

void PointerTools::EndGestures(ViewModel& model) {
  tool_ = model.tool;
  pressed_at_.reset();
  painted_.reset();
  corner_.reset();
  model.request.is_dragging = false;
  model.editor->EndDrag();
}

void PointerTools::MoveObjects(const PicturePlace& place,
                               const ViewWindow& window,
                               ViewModel& model) {
  ObjectEditor& editor = *model.editor;
  const ImGuiIO& io = ImGui::GetIO();
  const glm::dvec2 pixel = PixelAtPointer(place);
  if (ImGui::IsMouseClicked(ImGuiMouseButton_Left) && !io.WantCaptureMouse) {
    const glm::dvec2 pressed_at = place.ToPixel(window.PressedAt());
    if (const auto object = editor.ObjectAt(*model.ShownCamera(), pressed_at)) {
      editor.Select(object);
      editor.BeginDrag();
      pressed_at_ = pressed_at;
      model.request.is_dragging = false;
    }
  }
  const auto is_drag_to = [&](const glm::dvec2& at) {
    constexpr double kLeastDragPx = 2.0;
    return model.request.is_dragging || glm::distance(at, *pressed_at_) > kLeastDragPx;
  };
  if (pressed_at_ && ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
    if (is_drag_to(pixel)) {
      model.request.is_dragging = true;
      DragTo(pixel, model);
    }
  } else if (pressed_at_) {
    // All of a drag may lie between two pictures.
    const glm::dvec2 released_at = place.ToPixel(window.ReleasedAt());
    if (is_drag_to(released_at)) DragTo(released_at, model);
    pressed_at_.reset();
    editor.EndDrag();
    model.request.is_dragging = false;
  }
  if (io.MouseWheel != 0.0f && !io.WantCaptureMouse) TurnByWheel(io.MouseWheel, editor);
}

void PointerTools::DragTo(const glm::dvec2& pixel, ViewModel& model) {
  if (pixel != dragged_to_) model.status = model.editor->RestAt(*model.ShownCamera(), pixel);
  dragged_to_ = pixel;
}

void PointerTools::PaintMask(const glm::dvec2& pixel_of_picture, ViewModel& model) {
  if (!model.mask) model.mask.emplace(model.site);
  MaskPainter& mask = *model.mask;
  const ImGuiIO& io = ImGui::GetIO();
  if (!mask.WhyNot().empty() || io.WantCaptureMouse) return;
  const bool gives_back = model.brush_gives_back || io.KeyShift;
  // The mask has the site's size; a camera's picture may have another one.
  const double scale =
      static_cast<double>(mask.Mask().width) / model.ShownCamera()->intrinsics.width_px;
  const glm::dvec2 pixel = (pixel_of_picture + 0.5) * scale - 0.5;
  if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
    mask.BeginStroke();
    if (model.brush_takes_surfaces) mask.PaintSurface(pixel, gives_back);
  }
  if (ImGui::IsMouseDown(ImGuiMouseButton_Left) && !model.brush_takes_surfaces) {
    mask.Paint(painted_.value_or(pixel), pixel, model.brush_radius_px * scale, gives_back);
    painted_ = pixel;
  } else {
    painted_.reset();
  }
}

void PointerTools::PickPose(const glm::dvec2& pixel, double reach_px, ViewModel& model) {
  if (!model.pose) model.pose.emplace(model.site, *model.ShownCamera());
  const ImGuiIO& io = ImGui::GetIO();
  if (ImGui::IsMouseClicked(ImGuiMouseButton_Left) && !io.WantCaptureMouse) {
    corner_ = model.pose->CornerAt(pixel, reach_px);
    if (!corner_) model.status = "no corner of the mesh there";
  }
  if (corner_ && ImGui::IsMouseReleased(ImGuiMouseButton_Left)) {
    model.pose->Pick(*corner_, pixel);
    model.status = model.pose->Describe();
    corner_.reset();
  }
}

}  // namespace pleinair
