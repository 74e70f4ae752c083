// What the window shows and changes: one place for all panels.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/viewer/colour_picker.h"
#include "apps/viewer/frame_worker.h"
#include "apps/viewer/lens_picker.h"
#include "apps/viewer/mask_painter.h"
#include "apps/viewer/object_editor.h"
#include "apps/viewer/picture_cursor.h"
#include "apps/viewer/pose_picker.h"
#include "apps/viewer/response_picker.h"
#include "apps/viewer/tool_hand.h"
#include "apps/viewer/window.h"

namespace pleinair {

// Times of the window alone, over its last pictures.
struct WindowTimes {
  double pictures_per_second = 0.0;
  double window_ms = 0.0;  // Mean, of what a picture takes beside the composite.
  // The last drag's pictures, and the time from its end to the complete one; 0: none yet.
  double drag_pictures_per_second = 0.0;
  double completed_after_s = 0.0;
};

// Limits of how much residuals are magnified when drawn.
inline constexpr double kLeastMagnification = 1.0;
inline constexpr double kLargestMagnification = 200.0;

enum class Quitting { kNo, kAsked, kYes };

struct ViewModel {
  ViewRequest request;  // Posted where it has changed.
  std::shared_ptr<const ViewedSite> site;
  std::shared_ptr<const ViewedFrame> frame;
  std::optional<ObjectEditor> editor;  // Once there is a site.
  std::vector<LightPoint> lights;      // By frame number; of a camera the last ones.
  std::deque<Event> events;            // The last ones.
  std::deque<std::string> notes;       // The last ones.
  std::string status;                  // What the last action did, or why it did nothing.
  std::string stage;                   // Name of long work that goes on.
  double stage_share = 0.0;
  std::string failure;
  bool has_ended = false;
  WindowTimes times;
  Texture environment;
  std::int64_t environment_number = 0;  // Number of the frame that it shows.

  Tool tool = Tool::kObjects;
  ToolHand hand;
  PictureCursor cursor;
  std::optional<MaskPainter> mask;  // Once its tool was taken.
  double brush_radius_px = 12.0;
  bool brush_gives_back = false;
  bool brush_takes_surfaces = false;
  // Each once its tool was taken.
  std::optional<PosePicker> pose;
  std::optional<ColourPicker> colour;
  std::optional<ResponsePicker> response;
  std::optional<LensPicker> lens;
  double residuals_magnified = 20.0;  // Scale of the lens's residuals at the board's corners.
  bool saves_lens_in_doubt = false;
  bool lens_save_is_wanted = false;  // Once it is fitted.
  std::string typed_boards;          // Path of a board's picture, or of a folder of them.
  double region_radius_px = 6.0;     // Radius of surfaces that are pressed in the camera's picture.
  double other_region_radius_px = 3.0;
  std::string typed_other_picture;  // Path of the other camera's picture.
  double typed_exposure = 0.0;      // Exposure of the picture that is taken next; 0: its own.
  // To read the site again, after what was saved.
  void Reload() { ++request.settings_changes; }

  std::vector<bool> is_open;  // By panel.
  bool help_is_open = false;
  bool panels_have_keys = false;  // In place of frames and objects.
  bool snapshot_is_wanted = false;
  Quitting quitting = Quitting::kNo;

  std::map<std::string, std::string> stated_settings;  // By name: at the start.
  std::map<std::string, std::string> typed_settings;   // By name; empty text: as at the start.
  std::string settings_filter;
  std::string typed_mesh;  // Path of a file to load.

  const FrameResult* Result() const {
    return frame && frame->Succeeded() ? &*frame->step.result : nullptr;
  }
  const Camera* ShownCamera() const {
    return frame && frame->step.frame ? &frame->step.frame->camera : nullptr;
  }
  bool IsLive() const { return site && site->is_live; }
  int FrameCount() const { return site ? site->frames.value_or(0) : 0; }  // 0: not known.
  bool CanSeek() const { return site && site->can_seek; }
  void Seek(int index) {
    if (!CanSeek()) return;
    request.seek_frame = index;
    ++request.seeks;
  }
};

}  // namespace pleinair
