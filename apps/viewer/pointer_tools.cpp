#include "apps/viewer/pointer_tools.h"

#include <algorithm>
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

void PointerTools::Take(const PictureView& picture, ViewWindow& window, ViewModel& model) {
  edges_ = window.TakeEdges();
  used_edges_ = 0;
  if (!model.editor || model.ShownCamera() == nullptr) return;
  if (tool_ != model.tool) EndGestures(model);
  if (model.tool == Tool::kObjects) {
    MoveObjects(picture.Place(), window, model);
  } else {
    TakeUpTool(model);
  }
}

void PointerTools::EndGestures(ViewModel& model) {
  tool_ = model.tool;
  pressed_at_.reset();
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

void PointerTools::UseTool(const PictureView& picture, std::size_t edges, ViewModel& model) {
  for (; used_edges_ < std::min(edges, edges_.size()); ++used_edges_) {
    UseEdge(picture, edges_[used_edges_], model);
  }
}

void PointerTools::UseEdge(const PictureView& picture,
                           const ViewWindow::PointerEdge& edge,
                           ViewModel& model) {
  if (model.tool == Tool::kObjects) return;
  if (!edge.is_press) {
    if (!used_in_) return;
    model.hand.MoveTo(used_in_->ToPixel(edge.at), model);
    model.hand.Release(model);
    used_in_.reset();
    return;
  }
  // A panel or the help stands over the picture there.
  const ImGuiIO& io = ImGui::GetIO();
  const bool is_here = glm::distance(edge.at, glm::dvec2(io.MousePos.x, io.MousePos.y)) < 1.0;
  const bool is_other = picture.OtherHolds(edge.at);
  if ((io.WantCaptureMouse && is_here) || !(is_other || picture.Holds(edge.at))) return;
  used_in_ = is_other ? *picture.OtherPlace() : picture.Place();
  constexpr double kReach = 14.0;  // On the screen.
  model.hand.Press({used_in_->ToPixel(edge.at),
                    is_other ? PictureSide::kOther : PictureSide::kCamera,
                    kReach / used_in_->scale,
                    model.brush_gives_back || edge.shift},
                   model);
}

void PointerTools::Follow(const PictureView& picture, ViewModel& model) {
  UseTool(picture, edges_.size(), model);
  const ImGuiIO& io = ImGui::GetIO();
  const bool has_moved = io.MouseDelta.x != 0.0f || io.MouseDelta.y != 0.0f;
  const bool keys_hold = model.hand.IsDown() && !used_in_;
  if (has_moved && !keys_hold) model.cursor.is_shown = false;
  if (used_in_) model.hand.MoveTo(PixelAtPointer(*used_in_), model);
}

}  // namespace pleinair
