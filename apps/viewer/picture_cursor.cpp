#include "apps/viewer/picture_cursor.h"

#include <algorithm>
#include <vector>

#include <glm/common.hpp>

#include "apps/viewer/view_model.h"

namespace pleinair {
namespace {

glm::dvec2 LastPixel(const ViewModel& model) {
  if (model.cursor.side == PictureSide::kOther) {
    const Rgb8Image& other = *model.colour->OtherShown();
    return {other.width - 1, other.height - 1};
  }
  if (model.tool == Tool::kLens && model.lens && model.lens->Shown()) {
    return {model.lens->Shown()->width - 1, model.lens->Shown()->height - 1};
  }
  const CameraIntrinsics& camera = model.ShownCamera()->intrinsics;
  return {camera.width_px - 1, camera.height_px - 1};
}

bool HasOtherPicture(const ViewModel& model) {
  return model.tool == Tool::kColour && model.colour && model.colour->OtherShown();
}

// False where there is no picture.
bool ShowCursor(ViewModel& model) {
  if (model.ShownCamera() == nullptr) return false;
  PictureCursor& cursor = model.cursor;
  if (cursor.side == PictureSide::kOther && !HasOtherPicture(model)) {
    cursor = {};
  }
  if (!cursor.is_shown && cursor.pixel == glm::dvec2(0.0)) {
    cursor.pixel = glm::floor(0.5 * LastPixel(model));
  }
  // The picture may have become smaller.
  cursor.pixel = glm::clamp(cursor.pixel, glm::dvec2(0.0), LastPixel(model));
  cursor.is_shown = true;
  return true;
}

void JumpToCorner(bool back, ViewModel& model) {
  glm::dvec2& at = model.cursor.pixel;
  std::vector<glm::dvec2> corners = model.pose->CornersInView();
  const auto is_left = [](const glm::dvec2& a, const glm::dvec2& b) {
    return a.x != b.x ? a.x < b.x : a.y < b.y;
  };
  std::sort(corners.begin(), corners.end(), is_left);
  if (corners.empty()) {
    model.status = "no corner of the mesh is in view";
  } else if (back) {
    const auto next = std::lower_bound(corners.begin(), corners.end(), at, is_left);
    at = next == corners.begin() ? corners.back() : *(next - 1);
  } else {
    const auto next = std::upper_bound(corners.begin(), corners.end(), at, is_left);
    at = next == corners.end() ? corners.front() : *next;
  }
}

}  // namespace

void MoveCursor(const glm::dvec2& step_px, ViewModel& model) {
  if (!ShowCursor(model)) return;
  glm::dvec2& pixel = model.cursor.pixel;
  pixel = glm::clamp(pixel + step_px, glm::dvec2(0.0), LastPixel(model));
  model.hand.MoveTo(pixel, model);
}

void PressAtCursor(bool gives_back, ViewModel& model) {
  if (!ShowCursor(model)) return;
  if (model.hand.IsDown()) return model.hand.Release(model);
  model.hand.Press(
      {model.cursor.pixel, model.cursor.side, kKeyReachPx, gives_back || model.brush_gives_back},
      model);
}

void JumpToNextCorner(ViewModel& model) {
  const auto next = model.lens->NextCorner(model.cursor.pixel);
  if (!next) {
    model.status = "no board is found in the picture that is shown";
    return;
  }
  if (!ShowCursor(model) || model.hand.IsDown()) return;
  model.cursor.pixel = *next;
}

void JumpCursor(bool back, ViewModel& model) {
  if (!ShowCursor(model) || !TakeUpTool(model)) return;
  if (model.tool == Tool::kPose && !model.hand.IsDown()) JumpToCorner(back, model);
  if (!HasOtherPicture(model) || model.hand.IsDown()) return;
  PictureCursor& cursor = model.cursor;
  cursor.side = cursor.side == PictureSide::kCamera ? PictureSide::kOther : PictureSide::kCamera;
  cursor.pixel = glm::floor(0.5 * LastPixel(model));
  // Next to what was picked last.
  const auto& surfaces = model.colour->Surfaces();
  if (surfaces.empty()) return;
  if (cursor.side == PictureSide::kCamera) {
    cursor.pixel = surfaces.back().camera.at_px;
  } else if (surfaces.back().other) {
    cursor.pixel = surfaces.back().other->at_px;
  }
  cursor.pixel = glm::clamp(cursor.pixel, glm::dvec2(0.0), LastPixel(model));
}

}  // namespace pleinair
