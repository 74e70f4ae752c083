// What the pointer does in the pictures: drags objects, or presses with the tool that is taken.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>

#include "apps/viewer/picture_view.h"
#include "apps/viewer/view_model.h"

namespace pleinair {

class PointerTools {
 public:
  // These three once a picture of the window, while Dear ImGui's frame is open, in this order.
  void Take(const PictureView& picture, ViewWindow& window, ViewModel& model);
  // Presses and releases with a tool, up to number `edges` of this picture; as often as there are
  // keys between them.
  void UseTool(const PictureView& picture, std::size_t edges, ViewModel& model);
  // The rest of them; then the tool moves with the pointer.
  void Follow(const PictureView& picture, ViewModel& model);

 private:
  // What was begun with another tool ends.
  void EndGestures(ViewModel& model);
  void MoveObjects(const PicturePlace& place, const ViewWindow& window, ViewModel& model);
  void DragTo(const glm::dvec2& pixel, ViewModel& model);
  void UseEdge(const PictureView& picture, const ViewWindow::PointerEdge& edge, ViewModel& model);

  Tool tool_ = Tool::kObjects;  // The gestures' tool.
  std::optional<glm::dvec2> pressed_at_;
  glm::dvec2 dragged_to_{0.0};
  std::vector<ViewWindow::PointerEdge> edges_;  // The edges of this picture.
  std::size_t used_edges_ = 0;                  // How many of these were used.
  std::optional<PicturePlace> used_in_;         // Where the tool was pressed, until it is let go.
};

}  // namespace pleinair
