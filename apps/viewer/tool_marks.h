// What tools have picked, drawn over the pictures.
#pragma once

#include <glm/vec2.hpp>

#include "apps/viewer/picture_place.h"
#include "apps/viewer/view_model.h"

namespace pleinair {

// Picked surfaces, each with its number, or the chart's corners; on that side.
void DrawColourMarks(const PicturePlace& place, PictureSide side, const ColourPicker& picker);
// The chart's corners.
void DrawResponseMarks(const PicturePlace& place, const ResponsePicker& picker);
// The corners of the board's picture that is shown, row by row, with their residuals to the
// lens. Over the camera's picture: where boards were seen so far.
void DrawLensMarks(const PicturePlace& place, const ViewModel& model);
// The mesh's edges as the pose has them, each pick with its residual, and the corner that is held,
// which is to come to `hand_px`.
void DrawPoseMarks(const PicturePlace& place, const ViewModel& model, const glm::dvec2& hand_px);
void DrawCursor(const PicturePlace& place, const PictureCursor& cursor);

}  // namespace pleinair
