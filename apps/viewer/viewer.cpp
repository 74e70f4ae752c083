// `pleinair view`: the window's loop.
#include <algorithm>
#include <chrono>
#include <exception>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <imgui.h>
#include <spdlog/spdlog.h>

#include "apps/input_refusals.h"
#include "apps/viewer/actions.h"
#include "apps/viewer/chrome.h"
#include "apps/viewer/panel.h"
#include "apps/viewer/picture_view.h"
#include "apps/viewer/pointer_tools.h"
#include "apps/viewer/shortcuts.h"
#include "apps/viewer/view_command.h"
#include "apps/viewer/view_model.h"
#include "apps/viewer/view_state.h"
#include "scene/elapsed.h"
#include "scene/stopwatch.h"
#include "scene/upper_median.h"
#include "session/settings.h"
#include "session/site_frames.h"

namespace pleinair {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::size_t kKeptLights = 20'000;
constexpr std::size_t kKeptLines = 300;
constexpr std::size_t kKeptTimes = 10'000;

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
    for (const std::string& assignment : options.stated_settings) {
      const auto [name, value] = NameAndValue(assignment);
      model_.stated_settings[name] = value;
    }
    model_.request.effects = options.pipeline.effects;
    model_.request.is_playing = !options.input.empty() && IsCameraName(options.input);
    model_.request.loops = state_.loops;
    model_.request.frames_per_second = state_.frames_per_second;
    model_.request.exposure_stops = state_.exposure_stops;
    for (std::size_t i = 0; i < Overlays().size(); ++i) {
      if (state_.overlay == Overlays()[i].name) model_.request.overlay = i;
    }
    for (const PanelDefinition& panel : Panels()) {
      model_.is_open.push_back(std::find(state_.open_panels.begin(),
                                         state_.open_panels.end(),
                                         panel.name) != state_.open_panels.end());
    }
  }

  void Run() {
    while (!IsToEnd()) {
      window_.Wait(is_hidden_ ? kIdleS : UntilDueS());
      if (window_.TakeInput()) pending_pictures_ = kPicturesAfterInput;
      TakeNews();
      if (!model_.failure.empty() && !model_.site) throw std::runtime_error(model_.failure);
      if (!HasNewFrame() && UntilDueS() > 0.0) continue;
      is_hidden_ = !window_.IsShown();
      // Events that show it again are input.
      if (is_hidden_) continue;
      DrawWindow(UntilPanelsDueS() <= 0.0);
      PostRequest();
      if (SnapshotIsDue(model_)) TakeSnapshot(options_.stated_settings, options_.out, model_);
    }
    SaveState();
    spdlog::info("{} pictures shown, {} of frames; the window took {:.1f} ms each (mean)",
                 pictures_shown_,
                 frames_shown_,
                 window_ms_sum_ / static_cast<double>(std::max<std::int64_t>(1, pictures_shown_)));
    if (hidden_work_ms_.empty() || shown_work_ms_.empty()) return;
    spdlog::info(
        "a frame's work took {:.1f} ms, and {:.1f} ms while the window was hidden (medians)",
        UpperMedian({shown_work_ms_.begin(), shown_work_ms_.end()}),
        UpperMedian({hidden_work_ms_.begin(), hidden_work_ms_.end()}));
  }

 private:
  static constexpr double kIdleS = 0.5;
  // Dear ImGui needs some pictures after an input until all of it is shown.
  static constexpr int kPicturesAfterInput = 3;
  // Drawing for input alone leaves the processor to the frames.
  static constexpr double kAfterInputS = 1.0 / 30.0;

  bool HasNewFrame() const { return model_.frame && model_.frame->number != shown_frame_; }

  // Until the panels are drawn again, at 0 and less; kIdleS: there is nothing to draw. Frames come
  // more often than numbers can be read, and panels take longer to draw than the picture.
  double UntilPanelsDueS() const {
    // With the next frame, where one comes.
    constexpr double kWithFrameS = 0.2;
    constexpr double kAloneS = 0.3;
    if (pending_pictures_ == 0 && !panels_are_old_) return kIdleS;
    const bool follows_input = pending_pictures_ > 0 && !model_.request.is_dragging;
    return (follows_input   ? kAfterInputS
            : HasNewFrame() ? kWithFrameS
                            : kAloneS) -
           SecondsSince(panels_drawn_);
  }

  // Until anything is drawn without a new frame.
  double UntilDueS() const {
    const double panels_s = UntilPanelsDueS();
    const double input_s = pending_pictures_ > 0 ? kAfterInputS - SecondsSince(drawn_) : kIdleS;
    return std::max(0.0, std::min(panels_s, input_s));
  }

  // Work that is not saved is asked about first.
  bool IsToEnd() {
    if (window_.IsToClose()) {
      if (UnsavedWork(model_).empty()) return true;
      window_.StayOpen();
      model_.quitting = Quitting::kAsked;
      pending_pictures_ = std::max(pending_pictures_, 1);
    }
    return model_.quitting == Quitting::kYes;
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
    for (std::size_t i = 0; i < model_.is_open.size(); ++i) {
      if (model_.is_open[i]) state_.open_panels.emplace_back(Panels()[i].name);
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

  void TakeNews() {
    panels_are_old_ |= FollowLens(model_);
    WorkerNews news = worker_.Take();
    panels_are_old_ |= news.site || news.frame || !news.lights.empty() || !news.events.empty() ||
                       !news.notes.empty() || news.stage != model_.stage ||
                       news.stage_share != model_.stage_share || news.failure != model_.failure ||
                       news.has_ended != model_.has_ended || news.is_recording;
    if (news.site) {
      if (!model_.site) StartEditing(news.site);
      // Those of the site before: of a camera, their frames have other times.
      model_.lights.clear();
      model_.site = std::move(news.site);
      model_.editor->SetSite(model_.site);
      if (model_.mask) model_.mask->SetSite(model_.site);
      if (model_.pose) model_.pose->SetSite(model_.site);
      if (model_.colour) model_.colour->SetSite(model_.site);
    }
    if (news.frame) {
      model_.frame = std::move(news.frame);
      AppendLast(
          {model_.frame->work_ms}, kKeptTimes, is_hidden_ ? hidden_work_ms_ : shown_work_ms_);
      TimeDrag();
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
  }

  // Of a drag, as its pictures come.
  void TimeDrag() {
    const auto now = SteadyClock::now();
    if (model_.frame->IsQuick()) {
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
    if (!model_.frame) return;
    const bool shows_board = model_.tool == Tool::kLens && model_.lens && model_.lens->Shown();
    std::string title = fmt::format("pleinair{}: {} frame {}{}",
                                    picture_.OtherPlace() ? ", colours"
                                    : shows_board         ? ", lens"
                                                          : "",
                                    NameOf(model_.site->loaded->sequence.folder),
                                    model_.frame->Index(),
                                    model_.editor->HasUnsavedEdits() ? " *" : "");
    if (title == title_) return;
    window_.SetTitle(title);
    title_ = std::move(title);
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
    request.wants_complete = model_.snapshot_is_wanted;
    worker_.Post(request);
  }

  bool IsOpen(std::string_view name) const {
    for (std::size_t i = 0; i < model_.is_open.size(); ++i) {
      if (name == Panels()[i].name) return model_.is_open[i];
    }
    return false;
  }

  // `draws_all`: else panels may stay as they were.
  void DrawWindow(bool draws_all) {
    Stopwatch watch;
    drawn_ = SteadyClock::now();
    if (HasNewFrame()) {
      shown_frame_ = model_.frame->number;
      ++frames_shown_;
    }
    if (draws_all) {
      panels_drawn_ = drawn_;
      panels_are_old_ = false;
      pending_pictures_ = std::max(0, pending_pictures_ - 1);
    }
    window_.BeginFrame();
    const FreeArea free = DrawChrome(window_, model_);
    picture_.Draw(model_, window_, free.origin, free.size);
    const bool was_dragging = model_.request.is_dragging;
    pointer_.Take(picture_, window_, model_);
    if (was_dragging && !model_.request.is_dragging) drag_end_ = SteadyClock::now();
    // After the pointer: where a drag has ended is what is saved, also on a slow display.
    const ImVec2 pointer = ImGui::GetIO().MousePos;
    TakeKeys(
        picture_.Place().ToPixel({pointer.x, pointer.y}),
        window_,
        [this](std::size_t edges) { pointer_.UseTool(picture_, edges, model_); },
        model_);
    pointer_.Follow(picture_, model_);
    TakeDrop();
    ShowTitle();
    window_.EndFrame(draws_all);
    Learn(watch.LapMs());
  }

  void Learn(double ms) {
    ++pictures_shown_;
    window_ms_sum_ += ms;
    constexpr std::size_t kTimes = 120;
    AppendLast({ms}, kTimes, window_ms_);
    const auto now = SteadyClock::now();
    shown_at_.push_back(now);
    while (now - shown_at_.front() > std::chrono::seconds(1)) shown_at_.pop_front();
    model_.times.pictures_per_second = static_cast<double>(shown_at_.size());
    model_.times.window_ms = std::accumulate(window_ms_.begin(), window_ms_.end(), 0.0) /
                             static_cast<double>(window_ms_.size());
  }

  // Files that were dropped on the window.
  void TakeDrop() {
    const ViewWindow::Drop drop = window_.TakeDrop();
    const glm::dvec2 pixel = picture_.Place().ToPixel(drop.at);
    for (const std::filesystem::path& file : drop.files) {
      if (model_.tool == Tool::kColour) {
        OpenOtherPicture(file, model_);
      } else if (model_.tool == Tool::kLens) {
        OpenBoards(file, model_);
      } else {
        AddObject(file, pixel, model_);
      }
    }
  }

  ViewCommandOptions options_;
  std::filesystem::path state_folder_;
  ViewState state_;
  ViewWindow window_;
  // Textures are the window's, and go before it.
  ViewModel model_;
  PictureView picture_;
  PointerTools pointer_;
  std::string title_;
  int pending_pictures_ = 1;
  SteadyClock::time_point drawn_{};         // The last picture.
  SteadyClock::time_point panels_drawn_{};  // With panels.
  bool panels_are_old_ = false;             // There is news that they do not show.
  bool is_hidden_ = false;
  std::int64_t shown_frame_ = 0;  // The number of the last one that was drawn.
  std::int64_t editor_edits_ = 0;
  int drag_pictures_ = 0;
  SteadyClock::time_point drag_start_;
  std::optional<SteadyClock::time_point> drag_end_;
  std::int64_t pictures_shown_ = 0;
  std::int64_t frames_shown_ = 0;
  double window_ms_sum_ = 0.0;
  std::deque<double> window_ms_;  // Of the last pictures.
  // Of the last frames that came while the window was shown, or not.
  std::deque<double> shown_work_ms_;
  std::deque<double> hidden_work_ms_;
  std::deque<SteadyClock::time_point> shown_at_;
  FrameWorker worker_;  // It wakes the window: it ends first.
};

}  // namespace

void RunViewCommand(const ViewCommandOptions& options) {
  const PlayedInput input{options.input, options.camera, options.times};
  RefuseContradictions(options);
  RefuseOtherInputs(input, options);
  if (input.IsCamera()) return Viewer(options).Run();
  ViewCommandOptions readable = options;
  readable.poses = PoseFileOf(options.poses);
  Viewer(readable).Run();
}

}  // namespace pleinair
