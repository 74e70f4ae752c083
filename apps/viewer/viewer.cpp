// `pleinair view`: the window's loop.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <numbers>
#include <stdexcept>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <imgui.h>
#include <spdlog/spdlog.h>

#include "apps/viewer/panel.h"
#include "apps/viewer/picture_view.h"
#include "apps/viewer/snapshot.h"
#include "apps/viewer/view_command.h"
#include "apps/viewer/view_model.h"
#include "apps/viewer/view_state.h"
#include "scene/stopwatch.h"
#include "scene/upper_median.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::size_t kKeptLights = 20'000;
constexpr std::size_t kKeptLines = 300;

constexpr const char* kHelp[][2] = {
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
    {"Ctrl+S", "save objects to the site"},
    {"T", "the next tool: objects, mask, camera's pose"},
    {"Alt+1 ... Alt+8", "overlays; Alt+0: none"},
    {"F2 ... F9, F11", "panels; the last one by the menu"},
    {"F10", "keys go to the panels: arrows, Enter, Ctrl+Tab; Escape: back to the picture"},
    {"F12", "snapshot: the picture, and all that is needed to run it again"},
    {"Ctrl+R", "record a camera's pictures"},
    {"[, ]", "exposure shown, by a third of a stop"},
    {"Ctrl+Q", "quit"},
    {"mouse", "drag an object along surfaces; wheel: turn, Ctrl: scale, Shift: lift"},
};

template <typename Value>
void AppendLast(std::vector<Value> more, std::size_t most, std::deque<Value>& values) {
  for (Value& value : more) values.push_back(std::move(value));
  while (values.size() > most) values.pop_front();
}

// Of a recording that is played again, a frame's light replaces the one before.
void AddLight(const LightPoint& point, std::vector<LightPoint>& lights) {
  const auto at = std::lower_bound(
      lights.begin(), lights.end(), point.frame, [](const LightPoint& known, int frame) {
        return known.frame < frame;
      });
  if (at != lights.end() && at->frame == point.frame) {
    *at = point;
  } else {
    lights.insert(at, point);
  }
  if (lights.size() > kKeptLights) lights.erase(lights.begin());
}

class Viewer {
 public:
  explicit Viewer(const ViewCommandOptions& options)
      : options_(options),
        state_folder_(options.restores_state ? ViewStateFolder() : std::filesystem::path()),
        state_(ReadViewState(state_folder_).value_or(FirstState())),
        window_("pleinair", state_.window, LayoutFile()),
        worker_(options, ViewWindow::Wake) {
    model_.request.effects = options.pipeline.effects;
    model_.request.is_playing = !options.input.empty() && IsCameraName(options.input);
    model_.request.loops = state_.loops;
    model_.request.frames_per_second = state_.frames_per_second;
    model_.request.exposure_stops = state_.exposure_stops;
    for (std::size_t i = 0; i < Overlays().size(); ++i) {
      if (state_.overlay == Overlays()[i].name) model_.request.overlay = i;
    }
    for (const PanelDefinition& panel : Panels()) {
      is_open_.push_back(std::find(state_.open_panels.begin(),
                                   state_.open_panels.end(),
                                   panel.name) != state_.open_panels.end());
    }
  }

  void Run() {
    // Dear ImGui needs some pictures after an input until all of it is shown.
    constexpr int kPicturesAfterInput = 3;
    constexpr double kIdleS = 0.5;
    // Drawing for input alone leaves the processor to the frames.
    constexpr double kLeastIntervalS = 1.0 / 30.0;
    bool has_news = false;
    while (!IsToEnd()) {
      const double since_last_s =
          std::chrono::duration<double>(SteadyClock::now() - drawn_).count();
      const double until_next_s = std::max(0.0, kLeastIntervalS - since_last_s);
      window_.Wait(pending_pictures_ > 0 || has_news ? until_next_s : kIdleS);
      if (window_.TakeInput()) pending_pictures_ = kPicturesAfterInput;
      const std::int64_t frames_before = frames_shown_;
      has_news |= TakeNews();
      if (!has_news && pending_pictures_ == 0) continue;
      if (frames_shown_ == frames_before && until_next_s > 0.0) continue;
      has_news = false;
      pending_pictures_ = std::max(0, pending_pictures_ - 1);
      drawn_ = SteadyClock::now();
      DrawWindow();
      PostRequest();
      if (SnapshotIsDue()) WriteWantedSnapshot();
      if (!model_.failure.empty() && !model_.site) throw std::runtime_error(model_.failure);
    }
    SaveState();
    spdlog::info("{} pictures shown, {} of frames; the window took {:.1f} ms each (median)",
                 pictures_shown_,
                 frames_shown_,
                 window_ms_.empty() ? 0.0 : UpperMedian(window_ms_));
  }

 private:
  // Work that is not saved is asked about first.
  bool IsToEnd() {
    if (!window_.IsToClose()) return quits_;
    if (!HasUnsavedWork()) return true;
    window_.StayOpen();
    quit_is_asked_ = true;
    pending_pictures_ = std::max(pending_pictures_, 1);
    return quits_;
  }

  static ViewState FirstState() {
    ViewState state;
    for (const PanelDefinition& panel : Panels()) {
      if (panel.is_open_at_first) state.open_panels.emplace_back(panel.name);
    }
    return state;
  }

  std::filesystem::path LayoutFile() const {
    if (state_folder_.empty()) return {};
    std::error_code ignored;
    std::filesystem::create_directories(state_folder_, ignored);
    return state_folder_ / "view-layout.ini";
  }

  void SaveState() {
    if (state_folder_.empty()) return;
    state_.window = window_.Place();
    state_.open_panels.clear();
    for (std::size_t i = 0; i < is_open_.size(); ++i) {
      if (is_open_[i]) state_.open_panels.emplace_back(Panels()[i].name);
    }
    state_.overlay = model_.request.overlay ? Overlays()[*model_.request.overlay].name : "";
    state_.exposure_stops = model_.request.exposure_stops;
    state_.frames_per_second = model_.request.frames_per_second;
    state_.loops = model_.request.loops;
    try {
      WriteViewState(state_, state_folder_);
    } catch (const std::exception& error) {
      spdlog::warn("the window's state is not kept: {}", error.what());
    }
  }

  bool TakeNews() {
    WorkerNews news = worker_.Take();
    const bool has_news = news.site || news.frame || !news.lights.empty() || !news.events.empty() ||
                          !news.notes.empty() || news.stage != model_.stage ||
                          news.stage_share != model_.stage_share ||
                          news.failure != model_.failure || news.has_ended != model_.has_ended ||
                          news.is_recording;
    if (news.site) {
      if (!model_.site) StartEditing(news.site);
      model_.site = std::move(news.site);
      model_.editor->SetSite(model_.site);
      if (model_.mask) model_.mask->SetSite(model_.site);
    }
    if (news.frame) {
      model_.frame = std::move(news.frame);
      ++frames_shown_;
      TimeDrag();
      ShowTitle();
    }
    for (const LightPoint& light : news.lights) AddLight(light, model_.lights);
    if (!news.notes.empty()) model_.status = news.notes.back();
    AppendLast(std::move(news.events), kKeptLines, model_.events);
    AppendLast(std::move(news.notes), kKeptLines, model_.notes);
    model_.stage = std::move(news.stage);
    model_.stage_share = news.stage_share;
    model_.failure = std::move(news.failure);
    model_.has_ended = news.has_ended;
    if (news.is_recording) model_.request.is_recording = *news.is_recording;
    return has_news;
  }

  // Of a drag, as its pictures come.
  void TimeDrag() {
    const auto now = SteadyClock::now();
    if (!model_.frame->IsComplete()) {
      if (drag_pictures_++ == 0) drag_start_ = now;
      const double s = std::chrono::duration<double>(now - drag_start_).count();
      if (s > 0.0) model_.times.drag_pictures_per_second = (drag_pictures_ - 1) / s;
    } else if (drag_end_ && model_.frame->request.edits == model_.request.edits) {
      model_.times.completed_after_s = std::chrono::duration<double>(now - *drag_end_).count();
      spdlog::info("drag: {:.1f} pictures a second, complete {:.2f} s after its end",
                   model_.times.drag_pictures_per_second,
                   model_.times.completed_after_s);
      drag_end_.reset();
      drag_pictures_ = 0;
    }
  }

  // Also of "site/" and ".".
  static std::string NameOf(const std::filesystem::path& folder) {
    const std::filesystem::path clean = std::filesystem::absolute(folder).lexically_normal();
    return (clean.has_filename() ? clean : clean.parent_path()).filename().string();
  }

  void ShowTitle() {
    window_.SetTitle(fmt::format("pleinair: {} frame {}{}",
                                 NameOf(model_.site->loaded->sequence.folder),
                                 model_.frame->Index(),
                                 model_.editor->HasUnsavedEdits() ? " *" : ""));
  }

  void StartEditing(std::shared_ptr<const ViewedSite> site) {
    model_.editor.emplace(std::move(site));
    model_.request.objects = model_.editor->Objects();
    ++model_.request.edits;
    worker_.Post(model_.request);
  }

  void PostRequest() {
    if (!model_.editor) return;
    ViewRequest& request = model_.request;
    if (editor_edits_ != model_.editor->Edits()) {
      editor_edits_ = model_.editor->Edits();
      request.objects = model_.editor->Objects();
      ++request.edits;
    }
    request.wants_histogram = IsOpen("Histogram");
    request.wants_environment = IsOpen("Environment");
    request.wants_daylight = IsOpen("Daylight");
    request.wants_input = model_.tool != Tool::kObjects;
    if (!request.wants_environment) request.wants_probes = false;
    worker_.Post(request);
  }

  bool IsOpen(std::string_view name) const {
    for (std::size_t i = 0; i < is_open_.size(); ++i) {
      if (name == Panels()[i].name) return is_open_[i];
    }
    return false;
  }

  void DrawWindow() {
    Stopwatch watch;
    window_.BeginFrame();
    DrawMenu();
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const float bar = ImGui::GetFrameHeight();
    // Below the menu and above the bar of playback; panels start at the right edge.
    const float bottom = 2.4f * ImGui::GetFrameHeightWithSpacing();
    picture_.Draw(
        model_,
        window_,
        {0.0, bar},
        {std::max(64.0f, display.x - PanelWidth()), std::max(64.0f, display.y - bar - bottom)});
    DrawPlayback({0.0f, display.y - bottom}, {display.x, bottom});
    DrawPanels(bar, display, bottom);
    if (help_is_open_) DrawHelp();
    if (quit_is_asked_) DrawQuestion();
    TakeKeys();
    TakePointer();
    TakeDrop();
    window_.EndFrame();
    Learn(watch.LapMs());
  }

  void Learn(double ms) {
    ++pictures_shown_;
    constexpr std::size_t kTimes = 120;
    window_ms_.push_back(ms);
    if (window_ms_.size() > kTimes) window_ms_.erase(window_ms_.begin());
    const auto now = SteadyClock::now();
    shown_at_.push_back(now);
    while (now - shown_at_.front() > std::chrono::seconds(1)) shown_at_.pop_front();
    model_.times.pictures_per_second = static_cast<double>(shown_at_.size());
    model_.times.window_ms = UpperMedian(window_ms_);
  }

  // Panels stand in columns at the right edge.
  int PanelColumns() const {
    constexpr int kPanelsAColumn = 4;
    const auto open = static_cast<int>(std::count(is_open_.begin(), is_open_.end(), true));
    return (open + kPanelsAColumn - 1) / kPanelsAColumn;
  }
  float ColumnWidth() const { return 400.0f * window_.ContentScale(); }
  float PanelWidth() const { return static_cast<float>(PanelColumns()) * ColumnWidth(); }

  void DrawMenu() {
    if (!ImGui::BeginMainMenuBar()) return;
    if (ImGui::BeginMenu("File")) {
      if (ImGui::MenuItem("Save objects", "Ctrl+S", false, model_.editor.has_value())) Save();
      if (ImGui::MenuItem("Snapshot", "F12", false, model_.Result() != nullptr)) TakeSnapshot();
      if (ImGui::MenuItem("Record", "Ctrl+R", model_.request.is_recording, IsLive()))
        ToggleRecording();
      if (ImGui::MenuItem("Quit", "Ctrl+Q")) window_.Close();
      ImGui::EndMenu();
    }
    if (ImGui::BeginMenu("Edit", model_.editor.has_value())) {
      ObjectEditor& editor = *model_.editor;
      if (ImGui::MenuItem("Undo", "Ctrl+Z", false, editor.CanUndo())) editor.Undo();
      if (ImGui::MenuItem("Redo", "Ctrl+Y", false, editor.CanRedo())) editor.Redo();
      const bool has_object = editor.Selected().has_value();
      if (ImGui::MenuItem("Duplicate", "Ctrl+D", false, has_object)) editor.Duplicate();
      if (ImGui::MenuItem("Delete", "Delete", false, has_object)) editor.Delete();
      ImGui::EndMenu();
    }
    if (ImGui::BeginMenu("Overlay")) {
      if (ImGui::MenuItem("none", "Alt+0", !model_.request.overlay)) model_.request.overlay.reset();
      for (std::size_t i = 0; i < Overlays().size(); ++i) {
        const std::string key = fmt::format("Alt+{}", i + 1);
        if (ImGui::MenuItem(Overlays()[i].name, key.c_str(), model_.request.overlay == i)) {
          model_.request.overlay = i;
        }
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", Overlays()[i].help);
      }
      ImGui::EndMenu();
    }
    if (ImGui::BeginMenu("Panels")) {
      for (std::size_t i = 0; i < is_open_.size(); ++i) {
        const std::string key = i < 8 ? fmt::format("F{}", i + 2) : i == 8 ? "F11" : "";
        if (ImGui::MenuItem(Panels()[i].name, key.c_str(), is_open_[i])) is_open_[i] = !is_open_[i];
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", Panels()[i].help);
      }
      ImGui::EndMenu();
    }
    if (ImGui::MenuItem("Help", "F1", help_is_open_)) help_is_open_ = !help_is_open_;
    if (panels_have_keys_) ImGui::TextUnformatted("keys go to the panels (Escape: back)");
    if (model_.request.overlay) ImGui::TextDisabled("%s", Overlays()[*model_.request.overlay].help);
    ImGui::EndMainMenuBar();
  }

  void DrawPlayback(ImVec2 origin, ImVec2 size) {
    ImGui::SetNextWindowPos(origin);
    ImGui::SetNextWindowSize(size);
    constexpr ImGuiWindowFlags kBar = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                      ImGuiWindowFlags_NoSavedSettings |
                                      ImGuiWindowFlags_NoBringToFrontOnFocus;
    ImGui::Begin("playback", nullptr, kBar | KeysOfPanels());
    ViewRequest& request = model_.request;
    const char* play = request.is_playing ? (IsLive() ? "Freeze" : "Pause") : "Play";
    if (ImGui::Button(play)) request.is_playing = !request.is_playing;
    ImGui::SameLine();
    if (!IsLive()) {
      if (ImGui::Button("<")) Step(-1);
      ImGui::SameLine();
      if (ImGui::Button(">")) Step(1);
      ImGui::SameLine();
      ImGui::Checkbox("loop", &request.loops);
      ImGui::SameLine();
      DrawScrubber();
    } else {
      bool records = request.is_recording;
      if (ImGui::Checkbox("record", &records)) ToggleRecording();
      if (model_.has_ended) {
        ImGui::SameLine();
        ImGui::TextUnformatted("the camera's stream has ended");
      }
    }
    DrawStatus();
    ImGui::End();
  }

  void DrawScrubber() {
    const int count = FrameCount();
    int frame = model_.frame ? model_.frame->Index() : 0;
    ImGui::SetNextItemWidth(-220.0f * window_.ContentScale());
    if (ImGui::SliderInt(
            "##frame", &frame, 0, std::max(0, count - 1), "%d", ImGuiSliderFlags_AlwaysClamp))
      SeekIfRecorded(frame);
    ImGui::SameLine();
    auto rate = static_cast<float>(model_.request.frames_per_second);
    ImGui::SetNextItemWidth(110.0f * window_.ContentScale());
    if (ImGui::SliderFloat("a second",
                           &rate,
                           0.5f,
                           60.0f,
                           "%.3g",
                           ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp)) {
      model_.request.frames_per_second = rate;
    }
  }

  void DrawStatus() {
    if (!model_.stage.empty()) {
      ImGui::ProgressBar(static_cast<float>(model_.stage_share),
                         {160.0f * window_.ContentScale(), 0.0f});
      ImGui::SameLine();
      ImGui::TextUnformatted(model_.stage.c_str());
      return;
    }
    std::string text;
    if (model_.frame) {
      text =
          fmt::format("frame {}  {}", model_.frame->Index(), FormatUtcTime(model_.frame->Time()));
      if (!model_.frame->Succeeded())
        text += "  failed: " + model_.frame->step.result.error().reason;
      if (!model_.frame->IsComplete()) text += "  (quick picture)";
    } else {
      text = "opening " + options_.sequence.string();
    }
    if (model_.editor && model_.editor->HasUnsavedEdits()) text += "  * not saved";
    if (!model_.failure.empty()) text += "  " + model_.failure;
    ImGui::TextUnformatted(text.c_str());
    if (model_.status.empty()) return;
    ImGui::SameLine();
    ImGui::TextColored({1.0f, 0.75f, 0.35f, 1.0f}, "  %s", model_.status.c_str());
    // It may be longer than the window is wide.
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", model_.status.c_str());
  }

  void DrawPanels(float top, ImVec2 display, float bottom) {
    constexpr ImGuiWindowFlags kTiled =
        ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse;
    const auto open = static_cast<int>(std::count(is_open_.begin(), is_open_.end(), true));
    const int columns = PanelColumns();
    int placed = 0;
    for (std::size_t i = 0; i < is_open_.size(); ++i) {
      if (!is_open_[i]) continue;
      // The columns' panels, the first ones one more where they do not divide.
      const int column = placed * columns / open;
      const int first = (column * open + columns - 1) / columns;
      const int rows = ((column + 1) * open + columns - 1) / columns - first;
      const float height = (display.y - top - bottom) / static_cast<float>(rows);
      ImGui::SetNextWindowPos(
          {display.x - PanelWidth() + static_cast<float>(column) * ColumnWidth(),
           top + static_cast<float>(placed - first) * height});
      ImGui::SetNextWindowSize({ColumnWidth(), height});
      ++placed;
      bool stays_open = true;
      if (ImGui::Begin(Panels()[i].name, &stays_open, kTiled | KeysOfPanels()))
        Panels()[i].draw(model_);
      ImGui::End();
      is_open_[i] = stays_open;
    }
  }

  void DrawHelp() {
    ImGui::SetNextWindowSize({560.0f * window_.ContentScale(), 0.0f});  // As high as its text.
    if (ImGui::Begin("Help", &help_is_open_, ImGuiWindowFlags_NoSavedSettings)) {
      if (ImGui::BeginTable("keys", 2)) {
        ImGui::TableSetupColumn("keys", ImGuiTableColumnFlags_WidthFixed);
        ImGui::TableSetupColumn("what they do", ImGuiTableColumnFlags_WidthStretch);
        for (const auto& row : kHelp) {
          ImGui::TableNextRow();
          ImGui::TableNextColumn();
          ImGui::TextUnformatted(row[0]);
          ImGui::TableNextColumn();
          ImGui::TextWrapped("%s", row[1]);
        }
        ImGui::EndTable();
      }
    }
    ImGui::End();
  }

  void TakeKeys() {
    const std::vector<ViewWindow::KeyPress> keys = window_.TakeKeys();
    if (ImGui::GetIO().WantTextInput) return;
    for (const ViewWindow::KeyPress& press : keys) {
      if (quit_is_asked_) {
        AnswerQuit(press.key);
        continue;
      }
      // Of a key that is held, only what moves or steps goes on.
      if (press.is_repeat && (press.key == GLFW_KEY_SPACE || press.key >= GLFW_KEY_F1)) continue;
      TakeFunctionKey(press.key);
      if (press.alt) {
        TakeOverlayKey(press.key);
      } else if (press.ctrl) {
        TakeCommandKey(press);
      } else if (!panels_have_keys_) {
        TakePlaybackKey(press.key);
        if (press.key == GLFW_KEY_T) {
          ChooseTool(static_cast<Tool>((static_cast<int>(model_.tool) + 1) % 3));
        } else if (model_.editor && model_.tool == Tool::kObjects) {
          TakeObjectKey(press);
        }
      } else if (press.key == GLFW_KEY_ESCAPE) {
        GiveKeysToPanels(false);
      }
    }
  }

  // What the pointer has begun with the last tool ends.
  void ChooseTool(Tool tool) {
    model_.tool = tool;
    pressed_at_.reset();
    corner_.reset();
    painted_.reset();
    model_.request.is_dragging = false;
    if (model_.editor) model_.editor->EndDrag();
  }

  bool HasUnsavedWork() const {
    return (model_.editor && model_.editor->HasUnsavedEdits()) ||
           (model_.mask && model_.mask->HasUnsavedStrokes());
  }

  void AnswerQuit(int key) {
    if (key == GLFW_KEY_ESCAPE) {
      quit_is_asked_ = false;
    } else if (key == GLFW_KEY_ENTER || key == GLFW_KEY_KP_ENTER) {
      SaveAll();
    } else if (key == GLFW_KEY_DELETE) {
      quits_ = true;
    }
  }

  void SaveAll() {
    try {
      if (model_.editor->HasUnsavedEdits()) model_.editor->Save();
      if (model_.mask && model_.mask->HasUnsavedStrokes()) model_.mask->Save();
      quits_ = true;
    } catch (const std::exception& error) {
      quit_is_asked_ = false;
      Warn(error.what());
    }
  }

  void DrawQuestion() {
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({0.5f * display.x, 0.4f * display.y}, 0, {0.5f, 0.5f});
    ImGui::SetNextWindowFocus();
    ImGui::Begin("Not saved",
                 nullptr,
                 ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNavInputs);
    ImGui::TextUnformatted("Objects or the mask are not saved.");
    if (ImGui::Button("Save and quit (Enter)")) SaveAll();
    ImGui::SameLine();
    if (ImGui::Button("Quit without (Delete)")) quits_ = true;
    ImGui::SameLine();
    if (ImGui::Button("Stay (Escape)")) quit_is_asked_ = false;
    ImGui::End();
  }

  void TakeFunctionKey(int key) {
    if (key == GLFW_KEY_F1) help_is_open_ = !help_is_open_;
    const int panel = key == GLFW_KEY_F11 ? 8 : key == GLFW_KEY_F10 ? -1 : key - GLFW_KEY_F2;
    if (panel >= 0 && panel < static_cast<int>(is_open_.size())) is_open_[panel].flip();
    if (key == GLFW_KEY_F10) GiveKeysToPanels(!panels_have_keys_);
    if (key == GLFW_KEY_F12 && model_.Result() != nullptr) TakeSnapshot();
  }

  // Else Tab would begin to edit the text of a slider, and no key would come through.
  ImGuiWindowFlags KeysOfPanels() const {
    return panels_have_keys_ ? ImGuiWindowFlags_None : ImGuiWindowFlags_NoNavInputs;
  }

  // Dear ImGui moves through panels by the keys that also move objects and frames: one at a time.
  void GiveKeysToPanels(bool gives) {
    panels_have_keys_ = gives && PanelColumns() > 0;
    ImGuiConfigFlags& flags = ImGui::GetIO().ConfigFlags;
    if (!panels_have_keys_) {
      flags &= ~ImGuiConfigFlags_NavEnableKeyboard;
      ImGui::SetWindowFocus(nullptr);
      return;
    }
    flags |= ImGuiConfigFlags_NavEnableKeyboard;
    const auto first = std::find(is_open_.begin(), is_open_.end(), true) - is_open_.begin();
    ImGui::SetWindowFocus(Panels()[static_cast<std::size_t>(first)].name);
  }

  void TakeOverlayKey(int key) {
    if (key == GLFW_KEY_0) model_.request.overlay.reset();
    const int overlay = key - GLFW_KEY_1;
    if (overlay >= 0 && overlay < static_cast<int>(Overlays().size())) {
      model_.request.overlay = static_cast<std::size_t>(overlay);
    }
  }

  void TakeCommandKey(const ViewWindow::KeyPress& press) {
    if (press.key == GLFW_KEY_Q) window_.Close();
    if (press.key == GLFW_KEY_R && IsLive()) ToggleRecording();
    if (!model_.editor) return;
    if (model_.tool == Tool::kMask && model_.mask) {
      if (press.key == GLFW_KEY_Z) model_.mask->Undo();
      return;
    }
    if (model_.tool == Tool::kPose && model_.pose) {
      if (press.key == GLFW_KEY_Z) model_.pose->TakeBack();
      return;
    }
    switch (press.key) {
      case GLFW_KEY_S:
        return Save();
      case GLFW_KEY_Z:
        return press.shift ? model_.editor->Redo() : model_.editor->Undo();
      case GLFW_KEY_Y:
        return model_.editor->Redo();
      case GLFW_KEY_D:
        return model_.editor->Duplicate();
      default:
        return;
    }
  }

  void TakePlaybackKey(int key) {
    constexpr double kThirdOfAStop = 1.0 / 3.0;
    ViewRequest& request = model_.request;
    switch (key) {
      case GLFW_KEY_SPACE:
        request.is_playing = !request.is_playing;
        return;
      case GLFW_KEY_LEFT:
        return Step(-1);
      case GLFW_KEY_RIGHT:
        return Step(1);
      case GLFW_KEY_HOME:
        return SeekIfRecorded(0);
      case GLFW_KEY_END:
        if (FrameCount() > 0) SeekIfRecorded(FrameCount() - 1);
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

  void TakeObjectKey(const ViewWindow::KeyPress& press) {
    constexpr double kScaleStep = 1.1;
    ObjectEditor& editor = *model_.editor;
    const double step_px = press.shift ? 10.0 : 1.0;
    const double turn_rad = std::numbers::pi / 180.0 * (press.shift ? 1.0 : 15.0);
    const double lift_m = press.shift ? 0.005 : 0.05;
    switch (press.key) {
      case GLFW_KEY_TAB:
        return editor.SelectNext(press.shift ? -1 : 1);
      case GLFW_KEY_W:
        return Nudge({0.0, -step_px});
      case GLFW_KEY_S:
        return Nudge({0.0, step_px});
      case GLFW_KEY_A:
        return Nudge({-step_px, 0.0});
      case GLFW_KEY_D:
        return Nudge({step_px, 0.0});
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
        const Camera* camera = ShownCamera();
        if (camera != nullptr) model_.status = editor.RestAt(*camera, PointerPixel());
        return;
      }
      default:
        return;
    }
  }

  void TakePointer() {
    if (!model_.editor || ShownCamera() == nullptr) return;
    switch (model_.tool) {
      case Tool::kObjects:
        return MoveObjects();
      case Tool::kMask:
        return PaintMask();
      case Tool::kPose:
        return PickPose();
    }
  }

  void PaintMask() {
    if (!model_.mask) model_.mask.emplace(model_.site);
    MaskPainter& mask = *model_.mask;
    const ImGuiIO& io = ImGui::GetIO();
    if (!mask.WhyNot().empty() || io.WantCaptureMouse) return;
    const bool gives_back = model_.brush_gives_back || io.KeyShift;
    // The mask has the site's size; a camera's picture may have another one.
    const double scale =
        static_cast<double>(mask.Mask().width) / ShownCamera()->intrinsics.width_px;
    const glm::dvec2 pixel = (PointerPixel() + 0.5) * scale - 0.5;
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
      mask.BeginStroke();
      if (model_.brush_takes_surfaces) mask.PaintSurface(pixel, gives_back);
    }
    if (ImGui::IsMouseDown(ImGuiMouseButton_Left) && !model_.brush_takes_surfaces) {
      mask.Paint(painted_.value_or(pixel), pixel, model_.brush_radius_px * scale, gives_back);
      painted_ = pixel;
    } else {
      painted_.reset();
    }
  }

  void PickPose() {
    if (!model_.pose) model_.pose.emplace(model_.site, *ShownCamera());
    const ImGuiIO& io = ImGui::GetIO();
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left) && !io.WantCaptureMouse) {
      constexpr double kReach = 14.0;  // On the screen.
      corner_ = model_.pose->CornerAt(PointerPixel(), kReach / picture_.Place().scale);
      if (!corner_) model_.status = "no corner of the mesh there";
    }
    if (corner_ && ImGui::IsMouseReleased(ImGuiMouseButton_Left)) {
      model_.pose->Pick(*corner_, PointerPixel());
      model_.status = model_.pose->Describe();
      corner_.reset();
    }
  }

  void MoveObjects() {
    ObjectEditor& editor = *model_.editor;
    const ImGuiIO& io = ImGui::GetIO();
    const glm::dvec2 pixel = PointerPixel();
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left) && !io.WantCaptureMouse) {
      const glm::dvec2 pressed_at = picture_.Place().ToPixel(window_.PressedAt());
      if (const auto object = editor.ObjectAt(*ShownCamera(), pressed_at)) {
        editor.Select(object);
        editor.BeginDrag();
        pressed_at_ = pressed_at;
        model_.request.is_dragging = false;
      }
    }
    if (pressed_at_ && ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
      constexpr double kLeastDragPx = 2.0;
      if (model_.request.is_dragging || glm::distance(pixel, *pressed_at_) > kLeastDragPx) {
        model_.request.is_dragging = true;
        DragTo(pixel);
      }
    } else if (pressed_at_) {
      pressed_at_.reset();
      if (model_.request.is_dragging) DragTo(picture_.Place().ToPixel(window_.ReleasedAt()));
      editor.EndDrag();
      if (model_.request.is_dragging) drag_end_ = SteadyClock::now();
      model_.request.is_dragging = false;
    }
    if (io.MouseWheel != 0.0f && !io.WantCaptureMouse) TurnWheel(io.MouseWheel);
  }

  void DragTo(const glm::dvec2& pixel) {
    if (pixel != dragged_to_) model_.status = model_.editor->RestAt(*ShownCamera(), pixel);
    dragged_to_ = pixel;
  }

  void TurnWheel(double notches) {
    ObjectEditor& editor = *model_.editor;
    if (ImGui::GetIO().KeyCtrl) {
      editor.Scale(std::pow(1.05, notches));
    } else if (ImGui::GetIO().KeyShift) {
      editor.Lift(0.02 * notches);
    } else {
      editor.Turn(std::numbers::pi / 36.0 * notches);
    }
  }

  void TakeDrop() {
    const ViewWindow::Drop drop = window_.TakeDrop();
    if (drop.files.empty()) return;
    if (!model_.editor || ShownCamera() == nullptr) {
      model_.status = "objects can be dropped once there is a picture";
      return;
    }
    for (const std::filesystem::path& file : drop.files) {
      try {
        model_.status = model_.editor->Add(file, *ShownCamera(), picture_.Place().ToPixel(drop.at));
      } catch (const std::exception& error) {
        Warn(error.what());
      }
    }
  }

  void Nudge(const glm::dvec2& step_px) {
    if (const Camera* camera = ShownCamera())
      model_.status = model_.editor->Nudge(*camera, step_px);
  }

  // In the window, and in the log of whoever has started it.
  void Warn(const std::string& fault) {
    model_.status = fault;
    spdlog::warn("{}", fault);
  }

  void Save() {
    try {
      model_.editor->Save();
      model_.status = "objects saved to " + model_.site->loaded->sequence.file.string();
      ShowTitle();
    } catch (const std::exception& error) {
      Warn(error.what());
    }
  }

  void TakeSnapshot() {
    snapshot_is_wanted_ = true;
    model_.status = "snapshot: waiting for the complete picture";
  }

  // Not of a picture that an edit has made old, or that was made in haste.
  bool SnapshotIsDue() const {
    return snapshot_is_wanted_ && model_.frame && model_.frame->IsComplete() &&
           model_.editor->Edits() == editor_edits_ &&
           model_.frame->request.edits == model_.request.edits &&
           model_.frame->request.settings_changes == model_.request.settings_changes &&
           model_.frame->request.exposure_stops == model_.request.exposure_stops;
  }

  void WriteWantedSnapshot() {
    snapshot_is_wanted_ = false;
    try {
      model_.status = "snapshot: " + WriteSnapshot(*model_.site,
                                                   *model_.frame,
                                                   {model_.frame->request.objects,
                                                    SettingsOf(model_.frame->request),
                                                    model_.frame->request.effects},
                                                   options_.out)
                                         .string();
    } catch (const std::exception& error) {
      Warn(error.what());
    }
  }

  std::vector<std::string> SettingsOf(const ViewRequest& request) const {
    std::vector<std::string> settings = options_.stated_settings;
    settings.insert(settings.end(), request.settings.begin(), request.settings.end());
    return settings;
  }

  void ToggleRecording() { model_.request.is_recording = !model_.request.is_recording; }
  bool IsLive() const { return model_.site && model_.site->is_live; }
  int FrameCount() const { return model_.site ? model_.site->frames.value_or(0) : 0; }

  void Step(int frames) {
    if (!model_.frame || !CanSeek()) return;
    const int count = FrameCount();
    const int wanted = model_.frame->Index() + frames;
    model_.request.is_playing = false;
    if (count == 0)
      return SeekIfRecorded(std::max(0, wanted));  // Of a video, whose end is not known.
    SeekIfRecorded(model_.request.loops ? (wanted + count) % count
                                        : std::clamp(wanted, 0, count - 1));
  }

  void SeekIfRecorded(int frame) {
    if (CanSeek()) model_.Seek(frame);
  }
  bool CanSeek() const { return model_.site && model_.site->can_seek; }

  const Camera* ShownCamera() const {
    return model_.frame && model_.frame->step.frame ? &model_.frame->step.frame->camera : nullptr;
  }

  glm::dvec2 PointerPixel() const {
    const ImVec2 at = ImGui::GetIO().MousePos;
    return picture_.Place().ToPixel({at.x, at.y});
  }

  ViewCommandOptions options_;
  std::filesystem::path state_folder_;
  ViewState state_;
  ViewWindow window_;
  // Textures are the window's, and go before it.
  ViewModel model_;
  PictureView picture_;
  std::vector<bool> is_open_;  // By panel.
  bool help_is_open_ = false;
  bool panels_have_keys_ = false;
  int pending_pictures_ = 1;
  SteadyClock::time_point drawn_{};  // The last picture.
  std::int64_t editor_edits_ = 0;
  std::optional<glm::dvec2> pressed_at_;
  std::optional<glm::dvec2> painted_;  // Of the stroke, last.
  std::optional<glm::dvec3> corner_;   // That is being picked.
  glm::dvec2 dragged_to_{0.0};
  int drag_pictures_ = 0;
  SteadyClock::time_point drag_start_;
  std::optional<SteadyClock::time_point> drag_end_;
  bool snapshot_is_wanted_ = false;
  bool quit_is_asked_ = false;
  bool quits_ = false;
  std::int64_t pictures_shown_ = 0;
  std::int64_t frames_shown_ = 0;
  std::vector<double> window_ms_;
  std::deque<SteadyClock::time_point> shown_at_;
  FrameWorker worker_;  // It wakes the window: it ends first.
};

}  // namespace

void RunViewCommand(const ViewCommandOptions& options) { Viewer(options).Run(); }

}  // namespace pleinair
