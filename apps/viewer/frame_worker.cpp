#include "apps/viewer/frame_worker.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "apps/effect_budget.h"
#include "apps/lighting_log.h"
#include "apps/viewer/shaded_ball.h"
#include "apps/viewer/view_source.h"
#include "calib/response.h"
#include "pipeline/display_codes.h"
#include "scene/stopwatch.h"
#include "session/settings.h"

namespace pleinair {
namespace {

using SteadyClock = std::chrono::steady_clock;

// Of a dragged object's pictures, on its light: what is left of 50 ms beside drawing.
constexpr double kDragBudgetMs = 20.0;

// Thrown out of a preparation that nobody waits for any more.
struct Ending {};

PictureHistogram HistogramOf(const Rgb8Image& picture) {
  PictureHistogram histogram;
  histogram.pixels = static_cast<int>(picture.pixels.size());
  for (const glm::u8vec3& pixel : picture.pixels) {
    for (int c = 0; c < 3; ++c) ++histogram.counts[pixel[c]][static_cast<std::size_t>(c)];
  }
  for (std::size_t code = 1; code + 1 < histogram.counts.size(); ++code) {
    for (const int count : histogram.counts[code]) {
      histogram.largest = std::max(histogram.largest, count);
    }
  }
  return histogram;
}

LightPoint LightPointOf(const SessionStep& step) {
  LightPoint point;
  if (!step.result) {
    point.frame = step.result.error().index;
    point.time = step.result.error().time;
    point.failed = true;
    return point;
  }
  point.frame = step.frame->index;
  point.time = step.frame->time;
  const RecordedLight light = RecordOf(point.frame, step.result).light;
  point.sun_rgb = light.sun_irradiance_rgb.value_or(glm::dvec3(0.0));
  point.sky_rgb = light.sky_irradiance_rgb.value_or(glm::dvec3(0.0));
  point.has_stddev = light.sun_irradiance_stddev_rgb && light.sky_irradiance_stddev_rgb;
  point.sun_stddev_rgb = light.sun_irradiance_stddev_rgb.value_or(glm::dvec3(0.0));
  point.sky_stddev_rgb = light.sky_irradiance_stddev_rgb.value_or(glm::dvec3(0.0));
  return point;
}

}  // namespace

// What the window wants, carried out. On the worker's thread.
class FrameWorker::Viewing {
 public:
  explicit Viewing(FrameWorker& worker) : worker_(worker), source_(worker.options_, events_) {
    {
      const std::lock_guard lock(worker_.mutex_);
      worker_.interrupt_ = [this] { source_.Stop(); };
    }
  }
  ~Viewing() {
    const std::lock_guard lock(worker_.mutex_);
    worker_.interrupt_ = nullptr;
  }
  Viewing(const Viewing&) = delete;
  Viewing& operator=(const Viewing&) = delete;

  // Throws as LoadSequence, LoadSite and SequenceSession.
  void Open() { Load(worker_.options_); }

  // Until the worker ends.
  void Run() {
    for (std::optional<ViewRequest> request = Wait(); request; request = Wait()) {
      Try([&] { Carry(*request); });
      done_ = std::move(*request);
      ReportEvents();
    }
    Try([&] { source_.Record(false); });
  }

 private:
  // The next request that there is something to do for; none: the worker ends.
  std::optional<ViewRequest> Wait() {
    std::unique_lock lock(worker_.mutex_);
    for (;;) {
      if (worker_.is_ending_) return std::nullopt;
      const ViewRequest& request = *worker_.request_;
      if (IsChanged(request)) return request;
      const bool takes_pictures = request.is_playing || source_.IsRecording();
      if (source_.IsLive() && !has_ended_) {
        if (takes_pictures) return request;
        // Of a camera that is not looked at, events are reported all the same.
        constexpr auto kEventInterval = std::chrono::milliseconds(200);
        if (worker_.changed_.wait_for(lock, kEventInterval) == std::cv_status::timeout) {
          lock.unlock();
          ReportEvents();
          lock.lock();
        }
      } else if (!request.is_playing || IsAtEnd(request)) {
        worker_.changed_.wait(lock);
      } else if (SteadyClock::now() >= NextDue(request)) {
        return request;
      } else {
        worker_.changed_.wait_until(lock, NextDue(request));
      }
    }
  }

  SteadyClock::time_point NextDue(const ViewRequest& request) const {
    return last_frame_ + std::chrono::duration_cast<SteadyClock::duration>(
                             std::chrono::duration<double>(1.0 / request.frames_per_second));
  }

  // And stays there: it does not go round, or cannot.
  bool IsAtEnd(const ViewRequest& request) const {
    return has_ended_ && !(request.loops && can_go_back_ && !source_.IsLive());
  }
  // Lit in steps, where no other frame will refine the light: objects came to rest with the last
  // frame that was played. Or the window wants this frame complete, for a snapshot.
  bool IsLeftCoarse(const ViewRequest& request) const {
    return (!request.is_playing || has_ended_ || request.wants_complete) && !request.is_dragging &&
           frame_is_of_session_ && frame_ && frame_->number != last_refined_ &&
           frame_->Succeeded() && frame_->step.result->is_light_coarse;
  }
  bool IsChanged(const ViewRequest& request) const {
    return (!frame_ && !has_ended_) || IsLeftCoarse(request) || request.seeks != done_.seeks ||
           request.settings_changes != done_.settings_changes || IsOtherPicture(request) ||
           IsShownOtherwise(request) || request.is_recording != done_.is_recording;
  }
  bool IsOtherPicture(const ViewRequest& request) const {
    return request.edits != done_.edits || request.is_dragging != done_.is_dragging ||
           request.effects.switches != done_.effects.switches ||
           request.effects.threshold_code_values != done_.effects.threshold_code_values ||
           request.effects.budget_ms != done_.effects.budget_ms;
  }
  bool IsShownOtherwise(const ViewRequest& request) const {
    return request.exposure_stops != done_.exposure_stops || request.overlay != done_.overlay ||
           request.wants_histogram != done_.wants_histogram ||
           request.wants_daylight != done_.wants_daylight ||
           request.wants_input != done_.wants_input ||
           request.wants_environment != done_.wants_environment ||
           request.wants_probes != done_.wants_probes;
  }

  void Carry(const ViewRequest& request) {
    if (request.is_recording != done_.is_recording) {
      Try([&] { source_.Record(request.is_recording); });
      ReportRecording();
    }
    const bool is_other_session = request.settings_changes != done_.settings_changes &&
                                  Try([&] { ApplySettingsOf(request); });
    if (request.edits != done_.edits || is_other_session) {
      Try([&] { session_->SetObjects(request.objects); });
    }
    const bool is_due = request.is_playing && !IsAtEnd(request) && !IsLeftCoarse(request) &&
                        (source_.IsLive() || SteadyClock::now() >= NextDue(request));
    if (source_.IsLive() && !request.is_playing && frame_) {
      if (is_other_session) {
        LookAgain(request);
      } else {
        DrawAgain(request);
      }
      if (source_.IsRecording() && !source_.PassOver()) End();
    } else if (!frame_ || is_other_session || IsSoughtBy(request) || is_due) {
      TakeFrame(request, is_other_session);
    } else {
      DrawAgain(request);
    }
  }

  bool IsSoughtBy(const ViewRequest& request) const {
    return request.seeks != done_.seeks && !source_.IsLive();
  }

  // The frame that is shown, in a new session.
  void LookAgain(const ViewRequest& request) {
    if (!frame_->step.frame) return;
    session_->SetEffects(EffectsFor(request));
    Stopwatch watch;
    SessionStep step = session_->Process(*frame_->step.frame);
    Show(std::move(step), request, watch);
  }

  void DrawAgain(const ViewRequest& request) {
    if (!frame_is_of_session_ || !frame_->Succeeded()) return;
    Stopwatch watch;
    const bool is_other = IsOtherPicture(request);
    if (is_other || IsLeftCoarse(request)) {
      // Once each, also where it fails. With other objects it starts in steps, too.
      if (!is_other) last_refined_ = frame_->number;
      session_->SetEffects(EffectsFor(request));
      SessionStep step = session_->Redraw(frame_->step);
      // The picture that there is stays.
      if (!step.result) throw std::runtime_error(step.result.error().reason);
      Show(std::move(step), request, watch);
      if (!is_other) last_refined_ = frame_->number;
    } else if (IsShownOtherwise(request)) {
      Show(frame_->step, request, watch);
    }
  }

  void TakeFrame(const ViewRequest& request, bool is_other_session) {
    if (IsSoughtBy(request)) {
      if (!session_->Seek(request.seek_frame)) {
        throw std::runtime_error("these frames come in order alone: no frame can be gone to");
      }
      has_ended_ = false;
    } else if (is_other_session && frame_) {
      session_->Seek(frame_->Index());
    }
    session_->SetEffects(EffectsFor(request));
    Stopwatch watch;
    std::optional<SessionStep> step = session_->Next();
    if (!step && !source_.IsLive() && request.loops) {
      can_go_back_ = session_->Seek(0);
      if (can_go_back_) step = session_->Next();
    }
    last_frame_ = SteadyClock::now();
    if (!step) return End();
    has_ended_ = false;
    if (step->result && budget_) budget_->Look(step->result->plan);
    // The wait for a camera's picture is none of its work.
    double waited_ms = 0.0;
    if (source_.IsLive() && step->result) waited_ms = step->result->timing_ms.read;
    if (source_.IsLive() && !step->result) watch.LapMs();
    const LightPoint light = LightPointOf(*step);
    Show(std::move(*step), request, watch, waited_ms);
    worker_.Report([&](WorkerNews& news) { news.lights.push_back(light); });
  }

  void End() {
    has_ended_ = true;
    worker_.Report([](WorkerNews& news) { news.has_ended = true; });
  }

  EffectSettings EffectsFor(const ViewRequest& request) const {
    EffectSettings effects = request.effects;
    if (request.is_dragging) {
      // Where the object stands is seen by its shadow: it comes whatever it takes.
      for (const Effect effect : {Effect::kSunShading, Effect::kSunShadow}) {
        if (effects[effect] == EffectSwitch::kPlan) effects[effect] = EffectSwitch::kOn;
      }
      effects.budget_ms = std::min(kDragBudgetMs, effects.budget_ms.value_or(kDragBudgetMs));
    } else if (budget_ && !effects.budget_ms && request.is_playing) {
      effects.budget_ms = budget_->Next().budget_ms;
    }
    return effects;
  }

  void Show(SessionStep step,
            const ViewRequest& request,
            Stopwatch& watch,
            double waited_ms = 0.0) {
    auto frame = std::make_shared<ViewedFrame>();
    frame->number = ++frames_made_;
    frame->request = request;
    frame->request.effects = EffectsFor(request);
    frame->step = std::move(step);
    if (frame->Succeeded()) {
      frame->shown = session_->Show(frame->step, request.exposure_stops);
      Add(request, *frame);
    } else if (frame->step.frame) {
      frame->shown =
          session_->Display().Show(frame->step.frame->radiance, frame->step.frame->exposure);
    }
    frame->work_ms = watch.LapMs() - waited_ms;
    frame_ = frame;
    frame_is_of_session_ = true;
    ReportNotes();
    worker_.Report([&](WorkerNews& news) { news.frame = std::move(frame); });
  }

  void Add(const ViewRequest& request, ViewedFrame& frame) {
    const SessionStep& step = frame.step;
    frame.sky = session_->SkyImageOf(step.result->estimate.lighting);
    if (request.overlay) {
      frame.overlay = Overlays()[*request.overlay].draw(
          {*step.frame, *step.result, session_->WholeView(), session_->Samples()});
    }
    if (request.wants_input || request.wants_histogram) {
      Rgb8Image input = step.frame->codes
                            ? *step.frame->codes
                            : session_->Display().Show(step.frame->radiance, step.frame->exposure);
      if (request.wants_histogram) frame.histogram = HistogramOf(input);
      if (request.wants_input) frame.input = std::move(input);
    }
    if (const DirectDaylight* daylight = session_->Daylight();
        request.wants_daylight && daylight != nullptr) {
      const auto windows = daylight->Windows();
      frame.daylight = {daylight->Note(), {windows.begin(), windows.end()}, daylight->Samples()};
    }
    if (request.is_dragging || !(request.wants_environment || request.wants_probes)) return;
    const SequenceSession::Environment light =
        session_->EnvironmentOf(step.result->DrawnLighting());
    const std::optional<double> exposure = step.frame->exposure;
    if (request.wants_environment) {
      frame.environment = session_->Display().Show(light.with_sun, exposure);
    }
    if (request.wants_probes) {
      const PictureDisplay& display = session_->Display();
      frame.balls = BallsOf(session_->Volume(), *step.frame, display);
      if (frame.balls.empty()) {
        frame.balls.push_back(
            BallIn(light.with_sun, session_->EnvironmentPlaceM(), *step.frame, display));
      }
    }
  }

  void Load(SessionOptions options) {
    options.pipeline.sun_ahead = source_.IsLive();
    options.pipeline.light_in_steps = true;
    options.pipeline.first_in_steps = true;
    options = source_.OptionsOfSession(options);
    const auto loaded = source_.Load(options, [this](std::string_view stage, double share) {
      if (worker_.IsEnding()) throw Ending();
      worker_.Report([&](WorkerNews& news) {
        news.stage = std::string(stage);
        news.stage_share = share;
      });
    });
    std::unique_ptr<FrameSource> frames = source_.Frames(*loaded, options);
    const std::optional<int> count =
        frames ? frames->Count() : static_cast<int>(loaded->sequence.frames.size());
    // The last one stays where this one cannot be made.
    auto session = frames ? std::make_unique<SequenceSession>(loaded, options, std::move(frames))
                          : std::make_unique<SequenceSession>(loaded, options);
    session_ = std::move(session);
    frame_is_of_session_ = false;
    has_ended_ = false;
    const bool can_seek = session_->Seek(0);
    if (source_.IsLive()) budget_.emplace(options.pipeline.effects, source_.FramesPerSecond());
    auto site = std::make_shared<const ViewedSite>(ViewedSite{loaded,
                                                              RayCaster(loaded->site.model.mesh),
                                                              count,
                                                              source_.IsLive(),
                                                              can_seek,
                                                              source_.CameraMoves(),
                                                              session_->Renderer().renderer});
    ReportNotes();
    worker_.Report([&](WorkerNews& news) {
      news.stage.clear();
      news.site = std::move(site);
      news.lights.clear();  // Those of the site before.
    });
  }

  // All or none are applied.
  void ApplySettingsOf(const ViewRequest& request) {
    SessionOptions options = worker_.options_;
    for (const std::string& assignment : request.settings) ApplySetting(assignment, options);
    options.pipeline.effects = request.effects;
    Load(options);
  }

  // Whether it did not fail. What fails is a note, and all goes on as it was.
  template <typename Step>
  bool Try(const Step& step) {
    try {
      step();
      return true;
    } catch (const std::exception& error) {
      worker_.Report([&](WorkerNews& news) {
        news.stage.clear();
        news.notes.emplace_back(error.what());
      });
      return false;
    }
  }

  void ReportNotes() {
    std::vector<std::string> notes = session_->TakeNotes();
    if (notes.empty()) return;
    worker_.Report([&](WorkerNews& news) {
      for (std::string& note : notes) news.notes.push_back(std::move(note));
    });
  }

  void ReportRecording() {
    worker_.Report([&](WorkerNews& news) { news.is_recording = source_.IsRecording(); });
  }

  void ReportEvents() {
    if (const std::string why = source_.WhyRecordingStopped(); !why.empty()) {
      Try([&] { source_.Record(false); });
      worker_.Report([&](WorkerNews& news) { news.notes.push_back(why); });
      ReportRecording();
    }
    std::vector<Event> events = events_.Take(source_.Now());
    if (events.empty()) return;
    source_.AddEvents(events);
    worker_.Report([&](WorkerNews& news) {
      for (Event& event : events) news.events.push_back(std::move(event));
    });
  }

  FrameWorker& worker_;
  EventLog events_;
  ViewSource source_;
  std::optional<EffectBudget> budget_;  // Of a camera.
  std::unique_ptr<SequenceSession> session_;
  ViewRequest done_;
  std::shared_ptr<const ViewedFrame> frame_;
  bool frame_is_of_session_ = false;  // Else of the one before.
  std::int64_t frames_made_ = 0;
  std::int64_t last_refined_ = 0;  // The number of a frame that was drawn again, or failed to be.
  bool has_ended_ = false;
  bool can_go_back_ = true;  // To the first frame, as far as is known.
  SteadyClock::time_point last_frame_{};
};

FrameWorker::FrameWorker(const ViewCommandOptions& options, std::function<void()> wake)
    : options_(options), wake_(std::move(wake)), thread_([this] { Run(); }) {}

FrameWorker::~FrameWorker() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
    if (interrupt_) interrupt_();
  }
  changed_.notify_all();
  thread_.join();
}

void FrameWorker::Post(const ViewRequest& request) {
  {
    const std::lock_guard lock(mutex_);
    request_ = request;
  }
  changed_.notify_all();
}

WorkerNews FrameWorker::Take() {
  const std::lock_guard lock(mutex_);
  WorkerNews news = std::move(news_);
  // These last until they change.
  news_ = {};
  news_.stage = news.stage;
  news_.stage_share = news.stage_share;
  news_.has_ended = news.has_ended;
  news_.failure = news.failure;
  return news;
}

void FrameWorker::Run() {
  try {
    Viewing viewing(*this);
    viewing.Open();
    {
      // The objects that are wanted are known once the window has seen the site.
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return request_.has_value() || is_ending_; });
    }
    viewing.Run();
  } catch (const Ending&) {
    // Nobody waits for it.
  } catch (const std::exception& error) {
    Report([&](WorkerNews& news) { news.failure = error.what(); });
  }
}

bool FrameWorker::IsEnding() {
  const std::lock_guard lock(mutex_);
  return is_ending_;
}

void FrameWorker::Report(const std::function<void(WorkerNews&)>& change) {
  {
    const std::lock_guard lock(mutex_);
    change(news_);
  }
  wake_();
}

}  // namespace pleinair
