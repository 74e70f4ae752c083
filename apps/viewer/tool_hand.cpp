#include "apps/viewer/tool_hand.h"

#include <exception>

#include "apps/viewer/view_model.h"

namespace pleinair {
namespace {

// The mask has the site's size; a camera's picture may have another one.
double MaskScale(const ViewModel& model) {
  return static_cast<double>(model.mask->Mask().width) / model.ShownCamera()->intrinsics.width_px;
}

bool TakeUpPose(ViewModel& model) {
  if (model.site->camera_moves) {
    model.status = "the camera's pose is picked for a camera that stands still";
    return false;
  }
  if (!model.pose) model.pose.emplace(model.site, *model.ShownCamera());
  return true;
}

}  // namespace

bool TakeUpTool(ViewModel& model) {
  if (!model.site || model.ShownCamera() == nullptr) return false;
  try {
    switch (model.tool) {
      case Tool::kObjects:
        return true;
      case Tool::kMask:
        if (!model.mask) model.mask.emplace(model.site);
        return model.mask->WhyNot().empty();
      case Tool::kPose:
        return TakeUpPose(model);
      case Tool::kColour:
        if (!model.colour) model.colour.emplace(model.site);
        model.colour->Look(*model.frame);
        return true;
      case Tool::kResponse:
        if (!model.response) model.response.emplace(model.site);
        return true;
      case Tool::kLens:
        if (!model.lens) {
          model.lens.emplace(model.site->loaded->sequence.file, ViewWindow::Wake);
        }
        return true;
    }
  } catch (const std::exception& error) {
    model.status = error.what();
  }
  return false;
}

void ToolHand::Press(const PressPlace& place, ViewModel& model) {
  Release(model);  // Of a press by keys, with the pointer.
  if (!TakeUpTool(model)) return;
  at_ = place.pixel;
  gives_back_ = place.gives_back;
  is_down_ = true;
  switch (model.tool) {
    case Tool::kObjects:
      is_down_ = false;
      return;
    case Tool::kMask:
      model.mask->BeginStroke();
      if (model.brush_takes_surfaces) {
        const double scale = MaskScale(model);
        model.mask->PaintSurface((at_ + 0.5) * scale - 0.5, gives_back_);
      } else {
        Paint(at_, model);
      }
      return;
    case Tool::kPose:
      corner_ = model.pose->CornerAt(at_, place.reach_px);
      is_down_ = corner_.has_value();
      if (!corner_) model.status = "no corner of the mesh there";
      return;
    case Tool::kColour:
      model.status =
          model.colour->Press(place.side,
                              at_,
                              place.reach_px,
                              place.side == PictureSide::kCamera ? model.region_radius_px
                                                                 : model.other_region_radius_px);
      return;
    case Tool::kResponse:
      model.status = model.response->Press(at_, place.reach_px);
      return;
    case Tool::kLens:
      model.status = model.lens->Press(at_, place.reach_px);
      return;
  }
}

void ToolHand::Paint(const glm::dvec2& pixel, ViewModel& model) {
  const double scale = MaskScale(model);
  const glm::dvec2 on_mask = (pixel + 0.5) * scale - 0.5;
  model.mask->Paint(
      painted_.value_or(on_mask), on_mask, model.brush_radius_px * scale, gives_back_);
  painted_ = on_mask;
}

void ToolHand::MoveTo(const glm::dvec2& pixel, ViewModel& model) {
  if (!is_down_ || pixel == at_) return;
  at_ = pixel;
  if (model.tool == Tool::kMask && model.mask && !model.brush_takes_surfaces) Paint(at_, model);
  if (model.tool == Tool::kColour && model.colour) {
    model.colour->MoveTo(at_);
    model.status = model.colour->Describe();
  }
  if (model.tool == Tool::kResponse && model.response) model.response->MoveTo(at_);
  if (model.tool == Tool::kLens && model.lens) model.lens->MoveTo(at_);
}

void ToolHand::Release(ViewModel& model) {
  if (!is_down_) return;
  if (model.tool == Tool::kPose && model.pose && corner_) {
    model.pose->Pick(*corner_, at_);
    model.status = model.pose->Describe();
  }
  if (model.mask) model.mask->EndStroke();
  if (model.colour) model.colour->Release();
  if (model.tool == Tool::kResponse && model.response &&
      model.response->Way() == ResponseWay::kChart) {
    model.response->Release();
    model.status = model.response->Describe();
  }
  if (model.lens) model.lens->Release();
  Lift();
}

void ToolHand::LetGo(ViewModel& model) {
  if (!is_down_) return;
  if (model.mask) model.mask->DropStroke();
  if (model.colour) model.colour->LetGo();
  if (model.response) model.response->LetGo();
  if (model.lens) model.lens->LetGo();
  model.status = "let go: all is as before the press";
  Lift();
}

void ToolHand::Lift() {
  is_down_ = false;
  painted_.reset();
  corner_.reset();
}

}  // namespace pleinair
