// A cursor in the picture that keys move and press with: all that the pointer does in tools.
#pragma once

#include <glm/vec2.hpp>

#include "apps/viewer/picture_side.h"

namespace pleinair {

struct ViewModel;

struct PictureCursor {
  glm::dvec2 pixel{0.0};  // A pixel of the picture on that side.
  PictureSide side = PictureSide::kCamera;
  bool is_shown = false;  // From the first key that moves it until the pointer moves.
};

// How near a mark has to be to the cursor to be taken.
inline constexpr double kKeyReachPx = 8.0;

// Shown first in the middle of the camera's picture. It stays in its picture.
void MoveCursor(const glm::dvec2& step_px, ViewModel& model);
// Presses; where the hand is down, lets go.
void PressAtCursor(bool gives_back, ViewModel& model);
// With the pose, to the next corner of the mesh to the right, or to the left; with colours, to the
// other picture.
void JumpCursor(bool back, ViewModel& model);
// With the lens, to the next of the board's corners, those with large residuals first.
void JumpToNextCorner(ViewModel& model);

}  // namespace pleinair
