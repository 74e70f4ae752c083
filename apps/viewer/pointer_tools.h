// What the pointer does in the picture: moves objects, paints the mask, picks corners.
#pragma once

#include <optional>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "apps/viewer/picture_view.h"
#include "apps/viewer/view_model.h"

namespace pleinair {

class PointerTools {
 public:
  // Once a picture of the window, while Dear ImGui's frame is open.
  void Take(const PicturePlace& place, const ViewWindow& window, ViewModel& model);

 private:
  // What was begun with another tool ends.
  void EndGestures(ViewModel& model);
  void MoveObjects(const PicturePlace& place, const ViewWindow& window, ViewModel& model);
  void DragTo(const glm::dvec2& pixel, ViewModel& model);
  void PaintMask(const glm::dvec2& pixel, ViewModel& model);
  void PickPose(const glm::dvec2& pixel, double reach_px, ViewModel& model);

  Tool tool_ = Tool::kObjects;  // Of the gestures.
  std::optional<glm::dvec2> pressed_at_;
  glm::dvec2 dragged_to_{0.0};
  std::optional<glm::dvec2> painted_;  // Of the stroke, last.
  std::optional<glm::dvec3> corner_;   // That is being picked.
};

}  // namespace pleinair
