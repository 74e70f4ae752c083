#include "apps/viewer/shortcuts.h"

#include <algorithm>
#include <numbers>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <imgui.h>

#include "apps/viewer/actions.h"
#include "apps/viewer/panel.h"

namespace pleinair {
namespace {

constexpr Shortcut kShortcuts[] = {
    {"Space", "play or pause; of a camera: freeze"},
    {"Left, Right", "a frame back or on"},
    {"Home, End", "first and last frame"},
    {"L", "loop"},
    {"Tab, Shift+Tab", "select the next object, or the last"},
    {"W A S D", "move the object along its surface (Shift: ten times as far)"},
    {"Q, E", "turn it (Shift: by a degree)"},
    {"R, F", "lift and lower it"},
    {"+, -", "scale it"},
    {"P", "put it down on the surface under the pointer"},
    {"Ctrl+D, Delete", "duplicate it, delete it"},
    {"Ctrl+Z, Ctrl+Y", "undo, redo"},
    {"Ctrl+S", "save to the site what the tool edits"},
    {"T, Shift+T", "the next tool, or the last: objects, mask, pose, colours, response, lens"},
    {"W A S D", "other tools: move the cursor by a pixel (lens: a quarter; Shift: ten)"},
    {"Enter", "press at the cursor, and let go (mask: Shift gives back); Escape: undo the press"},
    {"Tab, Shift+Tab",
     "pose: the next corner of the mesh, or the last; colours: the other picture; lens: the next "
     "picture that was taken, or the last"},
    {"+, -", "mask, colours: a larger brush, or disc; a smaller one; lens: residuals"},
    {"G", "mask: entire surfaces, or the brush; lens: the next corner, the worst first"},
    {"R", "pose: refine by edges"},
    {"C", "colours, response: by a ColorChecker, or not; lens: by fit, pinhole, fish-eye"},
    {"F", "colours, response: find the ColorChecker; lens: corners as they are found"},
    {"P", "response, lens: take the picture"},
    {"X", "lens: leave the picture out, or take it back in"},
    {"Delete", "lens: remove the corner under the cursor, or the pointer"},
    {"Alt+1 ... Alt+8", "overlays; Alt+0: none"},
    {"F2 ... F9, F11", "panels; the last one by the menu"},
    {"F10", "keys go to the panels: arrows, Space, Ctrl+Tab; Escape: back to the picture"},
    {"F12", "snapshot: the picture, and all that is needed to run it again"},
    {"Ctrl+R", "record a camera's pictures"},
    {"[, ]", "exposure shown, by a third of a stop"},
    {"Ctrl+Q", "quit"},
    {"mouse", "drag an object along surfaces; wheel: turn, Ctrl: scale, Shift: lift"},
};

// F10 is not a panel's.
constexpr int kPanelKeys[] = {GLFW_KEY_F2,
                              GLFW_KEY_F3,
                              GLFW_KEY_F4,
                              GLFW_KEY_F5,
                              GLFW_KEY_F6,
                              GLFW_KEY_F7,
                              GLFW_KEY_F8,
                              GLFW_KEY_F9,
                              GLFW_KEY_F11};

// Dear ImGui moves through panels by the keys that also move objects and frames: one at a time.
void GiveKeysToPanels(bool gives, ViewModel& model) {
  const auto first = std::find(model.is_open.begin(), model.is_open.end(), true);
  model.panels_have_keys = gives && first != model.is_open.end();
  ImGuiConfigFlags& flags = ImGui::GetIO().ConfigFlags;
  if (!model.panels_have_keys) {
    flags &= ~ImGuiConfigFlags_NavEnableKeyboard;
    ImGui::SetWindowFocus(nullptr);
    return;
  }
  flags |= ImGuiConfigFlags_NavEnableKeyboard;
  ImGui::SetWindowFocus(Panels()[static_cast<std::size_t>(first - model.is_open.begin())].name);
}

void AnswerQuit(int key, ViewModel& model) {
  if (key == GLFW_KEY_ESCAPE) {
    model.quitting = Quitting::kNo;
  } else if (key == GLFW_KEY_ENTER || key == GLFW_KEY_KP_ENTER) {
    SaveAndQuit(model);
  } else if (key == GLFW_KEY_DELETE) {
    model.quitting = Quitting::kYes;
  }
}

void TakeFunctionKey(int key, ViewModel& model) {
  if (key == GLFW_KEY_F1) model.help_is_open = !model.help_is_open;
  const auto* panel = std::find(std::begin(kPanelKeys), std::end(kPanelKeys), key);
  if (panel != std::end(kPanelKeys)) {
    model.is_open[static_cast<std::size_t>(panel - std::begin(kPanelKeys))].flip();
  }
  if (key == GLFW_KEY_F10) GiveKeysToPanels(!model.panels_have_keys, model);
  if (key == GLFW_KEY_F12) AskForSnapshot(model);
}

void TakeOverlayKey(int key, ViewModel& model) {
  if (key == GLFW_KEY_0) model.request.overlay.reset();
  const int overlay = key - GLFW_KEY_1;
  if (overlay >= 0 && overlay < static_cast<int>(Overlays().size())) {
    model.request.overlay = static_cast<std::size_t>(overlay);
  }
}

void TakeCommandKey(const ViewWindow::KeyPress& press, ViewWindow& window, ViewModel& model) {
  switch (press.key) {
    case GLFW_KEY_Q:
      return window.Close();
    case GLFW_KEY_R:
      return ToggleRecording(model);
    case GLFW_KEY_S:
      Save(model);
      return;
    case GLFW_KEY_Z:
      return press.shift ? Redo(model) : Undo(model);
    case GLFW_KEY_Y:
      return Redo(model);
    case GLFW_KEY_D:
      if (model.tool == Tool::kObjects && model.editor) model.editor->Duplicate();
      return;
    default:
      return;
  }
}

void TakePlaybackKey(int key, ViewModel& model) {
  constexpr double kThirdOfAStop = 1.0 / 3.0;
  ViewRequest& request = model.request;
  switch (key) {
    case GLFW_KEY_SPACE:
      request.is_playing = !request.is_playing;
      return;
    case GLFW_KEY_LEFT:
      return Step(-1, model);
    case GLFW_KEY_RIGHT:
      return Step(1, model);
    case GLFW_KEY_HOME:
      return model.Seek(0);
    case GLFW_KEY_END:
      if (model.FrameCount() > 0) model.Seek(model.FrameCount() - 1);
      return;
    case GLFW_KEY_L:
      request.loops = !request.loops;
      return;
    case GLFW_KEY_LEFT_BRACKET:
      request.exposure_stops -= kThirdOfAStop;
      return;
    case GLFW_KEY_RIGHT_BRACKET:
      request.exposure_stops += kThirdOfAStop;
      return;
    default:
      return;
  }
}

void TakeObjectKey(const ViewWindow::KeyPress& press,
                   const glm::dvec2& pointer_px,
                   ViewModel& model) {
  constexpr double kScaleStep = 1.1;
  ObjectEditor& editor = *model.editor;
  const double step_px = press.shift ? 10.0 : 1.0;
  const double turn_rad = std::numbers::pi / 180.0 * (press.shift ? 1.0 : 15.0);
  const double lift_m = press.shift ? 0.005 : 0.05;
  switch (press.key) {
    case GLFW_KEY_TAB:
      return editor.SelectNext(press.shift ? -1 : 1);
    case GLFW_KEY_W:
      return Nudge({0.0, -step_px}, model);
    case GLFW_KEY_S:
      return Nudge({0.0, step_px}, model);
    case GLFW_KEY_A:
      return Nudge({-step_px, 0.0}, model);
    case GLFW_KEY_D:
      return Nudge({step_px, 0.0}, model);
    case GLFW_KEY_Q:
      return editor.Turn(turn_rad);
    case GLFW_KEY_E:
      return editor.Turn(-turn_rad);
    case GLFW_KEY_R:
      return editor.Lift(lift_m);
    case GLFW_KEY_F:
      return editor.Lift(-lift_m);
    case GLFW_KEY_EQUAL:
    case GLFW_KEY_KP_ADD:
      return editor.Scale(kScaleStep);
    case GLFW_KEY_MINUS:
    case GLFW_KEY_KP_SUBTRACT:
      return editor.Scale(1.0 / kScaleStep);
    case GLFW_KEY_DELETE:
      return editor.Delete();
    case GLFW_KEY_P: {
      const Camera* camera = model.ShownCamera();
      if (camera != nullptr) model.status = editor.RestAt(*camera, pointer_px);
      return;
    }
    default:
      return;
  }
}

void Resize(double factor, ViewModel& model) {
  if (model.tool == Tool::kLens) {
    model.residuals_magnified =
        std::clamp(model.residuals_magnified * factor, kLeastMagnification, kLargestMagnification);
    return;
  }
  constexpr double kLargestPx = 80.0;
  double* radius = &model.region_radius_px;
  if (model.tool == Tool::kMask) radius = &model.brush_radius_px;
  if (model.tool == Tool::kColour && model.cursor.side == PictureSide::kOther) {
    radius = &model.other_region_radius_px;
  }
  *radius = std::clamp(*radius * factor, 1.0, kLargestPx);
}

void ToggleChart(ViewModel& model) {
  if (!TakeUpTool(model)) return;
  if (model.tool == Tool::kColour) {
    const bool is_chart = model.colour->Way() == ColourWay::kChart;
    model.colour->SetWay(is_chart ? ColourWay::kSurfaces : ColourWay::kChart);
    model.status = model.colour->Describe();
  } else if (model.tool == Tool::kResponse) {
    const bool is_chart = model.response->Way() == ResponseWay::kChart;
    model.response->SetWay(is_chart ? ResponseWay::kBracket : ResponseWay::kChart);
    model.status = model.response->Describe();
  }
}

// By fit, pinhole, fish-eye, and by fit again.
void ChangeLensModel(ViewModel& model) {
  LensPicker& lens = *model.lens;
  const auto& now = lens.Boards().model;
  if (!now) {
    lens.SetModel(LensModel::kPinhole);
  } else if (*now == LensModel::kPinhole) {
    lens.SetModel(LensModel::kFisheye);
  } else {
    lens.SetModel(std::nullopt);
  }
  const auto& next = lens.Boards().model;
  model.status = next ? std::string("lens: ") + LensModelName(*next) : "lens: by fit";
}

// Where the lens is in hand; false: the key is of another kind.
bool TakeLensKey(int key, const glm::dvec2& pointer_px, ViewModel& model) {
  if (model.tool != Tool::kLens || !TakeUpTool(model)) return false;
  LensPicker& lens = *model.lens;
  switch (key) {
    case GLFW_KEY_G:
      JumpToNextCorner(model);
      return true;
    case GLFW_KEY_C:
      ChangeLensModel(model);
      return true;
    case GLFW_KEY_F:
      model.status = lens.FindCorners();
      return true;
    case GLFW_KEY_X:
      model.status = lens.Selected() ? lens.ToggleUse(*lens.Selected())
                                     : "choose one of the pictures that were taken: Tab";
      return true;
    case GLFW_KEY_DELETE: {
      const glm::dvec2 at = model.cursor.is_shown ? model.cursor.pixel : pointer_px;
      model.status = lens.RemoveCorner(at, kKeyReachPx);
      return true;
    }
    default:
      return false;
  }
}

// Of all tools but objects.
void TakeToolKey(const ViewWindow::KeyPress& press,
                 const glm::dvec2& pointer_px,
                 ViewModel& model) {
  constexpr double kResizeStep = 1.25;
  const double step_px = press.shift ? 10.0 : model.tool == Tool::kLens ? 0.25 : 1.0;
  if (TakeLensKey(press.key, pointer_px, model)) return;
  switch (press.key) {
    case GLFW_KEY_W:
      return MoveCursor({0.0, -step_px}, model);
    case GLFW_KEY_S:
      return MoveCursor({0.0, step_px}, model);
    case GLFW_KEY_A:
      return MoveCursor({-step_px, 0.0}, model);
    case GLFW_KEY_D:
      return MoveCursor({step_px, 0.0}, model);
    case GLFW_KEY_ENTER:
    case GLFW_KEY_KP_ENTER:
      if (!press.is_repeat) PressAtCursor(press.shift, model);
      return;
    case GLFW_KEY_ESCAPE:
      model.hand.LetGo(model);
      model.cursor.is_shown = false;
      return;
    case GLFW_KEY_TAB:
      if (model.tool != Tool::kLens) return JumpCursor(press.shift, model);
      if (TakeUpTool(model)) model.status = model.lens->SelectNext(press.shift ? -1 : 1);
      return;
    case GLFW_KEY_EQUAL:
    case GLFW_KEY_KP_ADD:
      return Resize(kResizeStep, model);
    case GLFW_KEY_MINUS:
    case GLFW_KEY_KP_SUBTRACT:
      return Resize(1.0 / kResizeStep, model);
    case GLFW_KEY_G:
      model.brush_takes_surfaces = !model.brush_takes_surfaces;
      return;
    case GLFW_KEY_R:
      return RefinePose(model);
    case GLFW_KEY_C:
      return ToggleChart(model);
    case GLFW_KEY_F:
      return FindChart(model);
    case GLFW_KEY_P:
      if ((model.tool == Tool::kResponse || model.tool == Tool::kLens) && TakeUpTool(model)) {
        TakePicture(model);
      }
      return;
    default:
      return;
  }
}

}  // namespace

std::span<const Shortcut> Shortcuts() { return kShortcuts; }

std::string KeyOfPanel(std::size_t index) {
  return index < std::size(kPanelKeys) ? fmt::format("F{}", 1 + kPanelKeys[index] - GLFW_KEY_F1)
                                       : std::string();
}

void TakeKeys(const glm::dvec2& pointer_px,
              ViewWindow& window,
              const std::function<void(std::size_t)>& use_pointer,
              ViewModel& model) {
  const std::vector<ViewWindow::KeyPress> keys = window.TakeKeys();
  if (ImGui::GetIO().WantTextInput) return;
  for (const ViewWindow::KeyPress& press : keys) {
    use_pointer(press.after_edges);
    if (model.quitting == Quitting::kAsked) {
      AnswerQuit(press.key, model);
      continue;
    }
    // Of a key that is held, only what moves or steps goes on.
    if (press.is_repeat && (press.key == GLFW_KEY_SPACE || press.key >= GLFW_KEY_F1)) continue;
    TakeFunctionKey(press.key, model);
    if (press.alt) {
      TakeOverlayKey(press.key, model);
    } else if (press.ctrl) {
      TakeCommandKey(press, window, model);
    } else if (model.panels_have_keys) {
      if (press.key == GLFW_KEY_ESCAPE) GiveKeysToPanels(false, model);
    } else {
      TakePlaybackKey(press.key, model);
      if (press.key == GLFW_KEY_T) {
        const int step = press.shift ? kTools - 1 : 1;
        TakeTool(static_cast<Tool>((static_cast<int>(model.tool) + step) % kTools), model);
      } else if (!model.editor) {
        continue;
      } else if (model.tool == Tool::kObjects) {
        TakeObjectKey(press, pointer_px, model);
      } else {
        TakeToolKey(press, pointer_px, model);
      }
    }
  }
}

}  // namespace pleinair
