#include "apps/viewer/chrome.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>
#include <imgui.h>

#include "apps/viewer/actions.h"
#include "apps/viewer/panel.h"
#include "apps/viewer/shortcuts.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

constexpr float kColumnWidth = 400.0f;  // Of panels, at a content scale of 1.

int OpenPanels(const ViewModel& model) {
  return static_cast<int>(std::count(model.is_open.begin(), model.is_open.end(), true));
}

// Panels stand in columns at the right edge.
int PanelColumns(const ViewModel& model) {
  constexpr int kPanelsAColumn = 4;
  return (OpenPanels(model) + kPanelsAColumn - 1) / kPanelsAColumn;
}

float PanelWidth(float scale, const ViewModel& model) {
  return static_cast<float>(PanelColumns(model)) * kColumnWidth * scale;
}

// Else Tab would begin to edit the text of a slider, and no key would come through.
ImGuiWindowFlags FlagsOfKeys(const ViewModel& model) {
  return model.panels_have_keys ? ImGuiWindowFlags_None : ImGuiWindowFlags_NoNavInputs;
}

void DrawMenu(ViewWindow& window, ViewModel& model) {
  if (!ImGui::BeginMainMenuBar()) return;
  if (ImGui::BeginMenu("File")) {
    if (ImGui::MenuItem("Save", "Ctrl+S", false, model.editor.has_value())) Save(model);
    if (ImGui::MenuItem("Snapshot", "F12", false, model.Result() != nullptr)) AskForSnapshot(model);
    if (ImGui::MenuItem("Record", "Ctrl+R", model.request.is_recording, model.IsLive()))
      ToggleRecording(model);
    if (ImGui::MenuItem("Quit", "Ctrl+Q")) window.Close();
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("Edit", model.editor.has_value())) {
    ObjectEditor& editor = *model.editor;
    if (ImGui::MenuItem("Undo", "Ctrl+Z", false, editor.CanUndo())) editor.Undo();
    if (ImGui::MenuItem("Redo", "Ctrl+Y", false, editor.CanRedo())) editor.Redo();
    const bool has_object = editor.Selected().has_value();
    if (ImGui::MenuItem("Duplicate", "Ctrl+D", false, has_object)) editor.Duplicate();
    if (ImGui::MenuItem("Delete", "Delete", false, has_object)) editor.Delete();
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("Overlay")) {
    if (ImGui::MenuItem("none", "Alt+0", !model.request.overlay)) model.request.overlay.reset();
    for (std::size_t i = 0; i < Overlays().size(); ++i) {
      const std::string key = fmt::format("Alt+{}", i + 1);
      if (ImGui::MenuItem(Overlays()[i].name, key.c_str(), model.request.overlay == i)) {
        model.request.overlay = i;
      }
      if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", Overlays()[i].help);
    }
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("Panels")) {
    for (std::size_t i = 0; i < model.is_open.size(); ++i) {
      const std::string key = KeyOfPanel(i);
      if (ImGui::MenuItem(Panels()[i].name, key.c_str(), model.is_open[i]))
        model.is_open[i] = !model.is_open[i];
      if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", Panels()[i].help);
    }
    ImGui::EndMenu();
  }
  if (ImGui::MenuItem("Help", "F1", model.help_is_open)) model.help_is_open = !model.help_is_open;
  if (model.panels_have_keys) ImGui::TextUnformatted("keys go to the panels (Escape: back)");
  if (model.request.overlay) ImGui::TextDisabled("%s", Overlays()[*model.request.overlay].help);
  ImGui::EndMainMenuBar();
}

void DrawScrubber(float scale, ViewModel& model) {
  const int count = model.FrameCount();
  int frame = model.frame ? model.frame->Index() : 0;
  ImGui::SetNextItemWidth(-220.0f * scale);
  if (ImGui::SliderInt(
          "##frame", &frame, 0, std::max(0, count - 1), "%d", ImGuiSliderFlags_AlwaysClamp))
    model.Seek(frame);
  ImGui::SameLine();
  auto rate = static_cast<float>(model.request.frames_per_second);
  ImGui::SetNextItemWidth(110.0f * scale);
  if (ImGui::SliderFloat("a second",
                         &rate,
                         0.5f,
                         60.0f,
                         "%.3g",
                         ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp)) {
    model.request.frames_per_second = rate;
  }
}

void DrawStatus(float scale, const ViewModel& model) {
  if (!model.stage.empty()) {
    ImGui::ProgressBar(static_cast<float>(model.stage_share), {160.0f * scale, 0.0f});
    ImGui::SameLine();
    ImGui::TextUnformatted(model.stage.c_str());
    return;
  }
  std::string text;
  if (model.frame) {
    text = fmt::format("frame {}  {}", model.frame->Index(), FormatUtcTime(model.frame->Time()));
    if (!model.frame->Succeeded()) text += "  failed: " + model.frame->step.result.error().reason;
    if (model.frame->IsQuick()) text += "  (quick picture)";
  } else {
    text = "opening";
  }
  if (model.editor && model.editor->HasUnsavedEdits()) text += "  * not saved";
  if (!model.failure.empty()) text += "  " + model.failure;
  ImGui::TextUnformatted(text.c_str());
  if (model.status.empty()) return;
  ImGui::SameLine();
  ImGui::TextColored({1.0f, 0.75f, 0.35f, 1.0f}, "  %s", model.status.c_str());
  // It may be longer than the window is wide.
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", model.status.c_str());
}

void DrawPlayback(ImVec2 origin, ImVec2 size, float scale, ViewModel& model) {
  ImGui::SetNextWindowPos(origin);
  ImGui::SetNextWindowSize(size);
  constexpr ImGuiWindowFlags kBar = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                    ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_NoBringToFrontOnFocus;
  ImGui::Begin("playback", nullptr, kBar | FlagsOfKeys(model));
  ViewRequest& request = model.request;
  const char* play = request.is_playing ? (model.IsLive() ? "Freeze" : "Pause") : "Play";
  if (ImGui::Button(play)) request.is_playing = !request.is_playing;
  ImGui::SameLine();
  if (!model.IsLive()) {
    if (ImGui::Button("<")) Step(-1, model);
    ImGui::SameLine();
    if (ImGui::Button(">")) Step(1, model);
    ImGui::SameLine();
    ImGui::Checkbox("loop", &request.loops);
    ImGui::SameLine();
    DrawScrubber(scale, model);
  } else {
    bool records = request.is_recording;
    if (ImGui::Checkbox("record", &records)) ToggleRecording(model);
    if (model.has_ended) {
      ImGui::SameLine();
      ImGui::TextUnformatted("the camera's stream has ended");
    }
  }
  DrawStatus(scale, model);
  ImGui::End();
}

void DrawPanels(float top, ImVec2 display, float bottom, float scale, ViewModel& model) {
  constexpr ImGuiWindowFlags kTiled =
      ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse;
  const int open = OpenPanels(model);
  const int columns = PanelColumns(model);
  int placed = 0;
  for (std::size_t i = 0; i < model.is_open.size(); ++i) {
    if (!model.is_open[i]) continue;
    // The columns' panels, the first ones one more where they do not divide.
    const int column = placed * columns / open;
    const int first = (column * open + columns - 1) / columns;
    const int rows = ((column + 1) * open + columns - 1) / columns - first;
    const float height = (display.y - top - bottom) / static_cast<float>(rows);
    ImGui::SetNextWindowPos(
        {display.x - PanelWidth(scale, model) + static_cast<float>(column) * kColumnWidth * scale,
         top + static_cast<float>(placed - first) * height});
    ImGui::SetNextWindowSize({kColumnWidth * scale, height});
    ++placed;
    bool stays_open = true;
    if (ImGui::Begin(Panels()[i].name, &stays_open, kTiled | FlagsOfKeys(model)))
      Panels()[i].draw(model);
    ImGui::End();
    model.is_open[i] = stays_open;
  }
}

void DrawHelp(float scale, ViewModel& model) {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  // As high as its text, which a wide window keeps short; all of it on the screen.
  ImGui::SetNextWindowPos({0.5f * display.x, 0.5f * display.y}, 0, {0.5f, 0.5f});
  ImGui::SetNextWindowSizeConstraints({0.0f, 0.0f}, {0.95f * display.x, 0.9f * display.y});
  ImGui::SetNextWindowSize({std::min(920.0f * scale, 0.95f * display.x), 0.0f});
  if (ImGui::Begin("Help", &model.help_is_open, ImGuiWindowFlags_NoSavedSettings)) {
    if (ImGui::BeginTable("keys", 2)) {
      ImGui::TableSetupColumn("keys", ImGuiTableColumnFlags_WidthFixed);
      ImGui::TableSetupColumn("what they do", ImGuiTableColumnFlags_WidthStretch);
      for (const Shortcut& shortcut : Shortcuts()) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(shortcut.keys);
        ImGui::TableNextColumn();
        ImGui::TextWrapped("%s", shortcut.help);
      }
      ImGui::EndTable();
    }
  }
  ImGui::End();
}

void DrawQuestion(ViewModel& model) {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * display.x, 0.4f * display.y}, 0, {0.5f, 0.5f});
  ImGui::SetNextWindowFocus();
  ImGui::Begin("Not saved",
               nullptr,
               ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNavInputs);
  ImGui::Text("Not saved: %s.", UnsavedWork(model).c_str());
  if (ImGui::Button("Save and quit (Enter)")) SaveAndQuit(model);
  ImGui::SameLine();
  if (ImGui::Button("Quit without (Delete)")) model.quitting = Quitting::kYes;
  ImGui::SameLine();
  if (ImGui::Button("Stay (Escape)")) model.quitting = Quitting::kNo;
  ImGui::End();
}

}  // namespace

FreeArea DrawChrome(ViewWindow& window, ViewModel& model) {
  const float scale = window.ContentScale();
  DrawMenu(window, model);
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const float top = ImGui::GetFrameHeight();
  const float bottom = 2.4f * ImGui::GetFrameHeightWithSpacing();  // Two lines.
  const FreeArea free{{0.0, top},
                      {std::max(64.0f, display.x - PanelWidth(scale, model)),
                       std::max(64.0f, display.y - top - bottom)}};
  DrawPlayback({0.0f, display.y - bottom}, {display.x, bottom}, scale, model);
  DrawPanels(top, display, bottom, scale, model);
  if (model.help_is_open) DrawHelp(scale, model);
  if (model.quitting == Quitting::kAsked) DrawQuestion(model);
  return free;
}

}  // namespace pleinair
