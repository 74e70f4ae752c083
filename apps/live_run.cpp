#include "apps/live_run.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <stop_token>
#include <string_view>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/camera_watch.h"
#include "apps/effect_budget.h"
#include "apps/frame_loop.h"
#include "apps/log_event.h"
#include "apps/progress.h"
#include "apps/run_description.h"
#include "apps/run_output.h"
#include "apps/run_targets.h"
#include "apps/stop_signals.h"
#include "datasets/camera/live_frame_source.h"
#include "datasets/recording/recorder.h"
#include "scene/elapsed.h"
#include "session/session_choices.h"
#include "session/site_frames.h"

namespace pleinair {
namespace {

using SteadyClock = std::chrono::steady_clock;

// Writes what is finished. A failure ends it, and is thrown by Finish.
class OutputThread {
 public:
  explicit OutputThread(RunOutput& output) : output_(output), thread_([this] { Run(); }) {}
  ~OutputThread() {
    queue_.Close();
    if (thread_.joinable()) thread_.join();
  }
  OutputThread(const OutputThread&) = delete;
  OutputThread& operator=(const OutputThread&) = delete;

  // Waits where writing is slower than compositing: the camera's queue then drops frames. False
  // where writing has failed.
  bool Push(FinishedFrame frame) { return queue_.PushWhenRoom(std::move(frame)); }

  void Finish() {
    queue_.Close();
    thread_.join();
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  void Run() {
    try {
      while (std::optional<FinishedFrame> frame = queue_.Pop()) output_.Add(std::move(*frame));
    } catch (...) {
      failure_ = std::current_exception();
      queue_.Close();
    }
  }

  static constexpr std::size_t kWaitingFrames = 4;
  RunOutput& output_;
  FrameQueue<FinishedFrame> queue_{kWaitingFrames};
  std::exception_ptr failure_;
  std::thread thread_;
};

// Events to the log, the run's output and its recording.
class EventWriter {
 public:
  // `recorder`: none where nothing is recorded.
  EventWriter(RunOutput& output, Recorder* recorder) : output_(output), recorder_(recorder) {}

  void Write(Event event) {
    LogEvent(event);
    if (recorder_ != nullptr) recorder_->AddEvents({event});
    try {
      output_.AddEvent(std::move(event));
    } catch (const std::exception& error) {
      // The frames' own files end the run, for the same reason.
      if (!std::exchange(has_failed_, true)) spdlog::error("{}", error.what());
    }
  }

 private:
  RunOutput& output_;
  Recorder* recorder_;
  bool has_failed_ = false;
};

CameraRequest RequestFor(const RunCommandOptions& options, const Sequence& site) {
  CameraRequest request = options.camera;
  if (!request.width_px) {
    request.width_px = site.intrinsics.width_px;
    request.height_px = site.intrinsics.height_px;
  }
  return request;
}

// A line a second: light, rate, drops.
class LightOfTheSecond {
 public:
  explicit LightOfTheSecond(const EventLog& events) : events_(events) {}
  void Add(const FinishedFrame& finished) {
    ++frames_;
    const double seconds = SecondsSince(shown_);
    if (seconds < 1.0) return;
    LogLight(finished, std::nullopt);
    spdlog::info("{:.1f} composites a second, {} frames dropped, {} lost by the driver",
                 frames_ / seconds,
                 events_.CountOf(EventKind::kFrameDropped),
                 events_.CountOf(EventKind::kFrameLost));
    shown_ = SteadyClock::now();
    frames_ = 0;
  }

 private:
  const EventLog& events_;
  SteadyClock::time_point shown_ = SteadyClock::now();
  int frames_ = 0;
};

std::optional<double> RateOf(const CameraCapture& capture) {
  const double rate = capture.FramesPerSecond();
  return rate > 0.0 ? std::optional(rate) : std::nullopt;
}

// The order of the members is that of construction: other threads use what stands before them.
class LiveRun {
 public:
  explicit LiveRun(const RunCommandOptions& options)
      : options_(options),
        site_(ReadSite(options.sequence, std::chrono::system_clock::now())),
        capture_(options.input, RequestFor(options, site_), {}, events_),
        targets_(options, RateOf(capture_)),
        output_(options, targets_, events_, RateOf(capture_)) {
    // A camera of another shape would fail in every frame.
    ScaledTo(site_.intrinsics, capture_.Layout().width_px, capture_.Layout().height_px);
    if (!options.record.empty()) {
      RecorderOptions record;
      record.recording.folder = options.record;
      recorder_.emplace(site_, capture_.Layout(), record, events_);
    }
    camera_.emplace(options, capture_, events_);
    WatchTasks tasks;
    tasks.write = [writer = EventWriter(output_, recorder_ ? &*recorder_ : nullptr)](
                      Event event) mutable { writer.Write(std::move(event)); };
    tasks.look = [this] {
      LookAtSite();
      return false;
    };
    tasks.end = [this] { output_.StopWaitingForReaders(); };
    watch_.emplace(signals_, capture_, events_, options.duration_s, std::move(tasks));
  }

  void Run() {
    RunReport& report = output_.Report();
    report.title = TitleOf(site_);
    if (const std::unique_ptr<SequenceSession> session = Prepare()) {
      FrameLoop frames(options_, *session, true);
      report.settings =
          DescribeSettings(options_, session->Loaded(), std::nullopt, session->Renderer());
      Composite(*session, frames);
      std::vector<std::string> notes;
      TryAndNote([&] { notes = frames.Finish(); });
      End(std::move(notes));
    } else {
      End({});
    }
    SayHowItEnded(options_, report, site_);
  }

 private:
  // Thrown to end a preparation whose result is no longer wanted.
  struct NotWanted {};

  void Note(EventKind kind, std::string text) {
    events_.Add({capture_.Clock().Now(), kind, std::move(text)});
  }

  // A run goes on with what it has read.
  void LookAtSite() {
    std::error_code error;
    const bool is_there = std::filesystem::exists(options_.sequence, error);
    if (is_there == site_is_there_) return;
    site_is_there_ = is_there;
    Note(EventKind::kSite,
         options_.sequence.string() +
             (is_there ? ": is there again" : ": is gone; the run goes on with what it has read"));
  }

  // Loads the site, and prepares it where that was not done before, while pictures pass. None where
  // the run is to end before; preparation then stops after its current stage.
  std::unique_ptr<SequenceSession> Prepare() {
    const SteadyClock::time_point start = SteadyClock::now();
    std::jthread passing([this](const std::stop_token& is_ready) { PassPictures(is_ready); });
    try {
      const auto loaded =
          LoadSite(PosedCamera::OfflineOptions(options_),
                   capture_.Clock().Now(),
                   [this, show = ProgressOnStandardError()](std::string_view stage, double share) {
                     if (no_more_pictures_) throw NotWanted();
                     if (!is_preparing_.exchange(true)) {
                       Note(EventKind::kPreparing,
                            options_.sequence.string() + ": pictures pass as they come meanwhile");
                     }
                     show(stage, share);
                   });
      auto session = std::make_unique<SequenceSession>(
          loaded, camera_->OptionsOfSession(options_), FramesAt(*loaded));
      passing.request_stop();
      passing.join();
      Note(EventKind::kPrepared,
           fmt::format("{}: {} in {:.2f} s; {} pictures passed",
                       options_.sequence.string(),
                       loaded->scene.from_store ? "loaded from the cache" : "prepared",
                       SecondsSince(start),
                       passed_));
      return session;
    } catch (const NotWanted&) {
      return nullptr;
    } catch (...) {
      capture_.Stop();  // Wakes the thread.
      throw;
    }
  }

  std::unique_ptr<FrameSource> FramesAt(const LoadedSequence& loaded) {
    PosedCamera::Taps taps;
    taps.taken = [this](const CameraFrame& frame) { taken_ = frame.buffer.monotonic_time; };
    if (recorder_) taps.record = [this](CameraFrame frame) { recorder_->Offer(std::move(frame)); };
    return camera_->FramesAt(loaded, options_, taps);
  }

  // Where the site is prepared, they are shown and recorded; not in the moment that it takes to
  // load one that was prepared before, so that what is recorded is what is composited.
  void PassPictures(const std::stop_token& is_ready) {
    try {
      const auto source = MakeLiveFrameSource(
          site_, capture_, events_, options_.camera_noise, [this](const CameraFrame& frame) {
            if (recorder_ && is_preparing_ && !camera_->Moves()) recorder_->Offer(frame);
          });
      const PictureDisplay display(ResponseOf(options_, site_));
      const bool are_shown = options_.video || !options_.picture_stream.empty();
      while (!is_ready.stop_requested()) {
        const auto frame = source->Next();
        if (!frame) break;
        ++passed_;
        if (!*frame || !are_shown || !is_preparing_) continue;
        const Frame& shown = **frame;
        output_.AddPassed(shown.codes ? *shown.codes : display.Show(shown.radiance, shown.exposure),
                          shown.time);
      }
    } catch (const std::exception& error) {
      failure_ = error.what();
      Note(EventKind::kDisk, failure_);
    }
    no_more_pictures_ = !is_ready.stop_requested();
  }

  void Composite(SequenceSession& session, FrameLoop& frames) {
    EffectBudget budget(options_.pipeline.effects, capture_.FramesPerSecond());
    LightOfTheSecond shown_light(events_);
    OutputThread writing(output_);
    std::int64_t taken_frames = 0;
    watch_->StartTime();
    // Not by the frames' times: the system's clock may be stepped.
    std::optional<SteadyClock::time_point> first;
    bool is_time_up = false;
    TryAndNote([&] {
      while (failure_.empty() && !is_time_up && !(taken_frames == options_.frames_limit)) {
        session.SetEffects(budget.Next());
        std::optional<FinishedFrame> finished = frames.Next();
        if (!finished) break;
        std::string bad_frame;  // Why it ends the run.
        ++taken_frames;
        if (finished->step.result) {
          budget.Look(finished->step.result->plan);
          shown_light.Add(*finished);
          finished->latency_ms =
              std::chrono::duration<double, std::milli>(capture_.Clock().MonotonicNow() - taken_)
                  .count();
          if (!first) first = SteadyClock::now();
          is_time_up = options_.duration_s && SecondsSince(*first) >= *options_.duration_s;
        } else if (options_.stop_on_bad_frame) {
          bad_frame = StoppedAt(finished->step.result.error());
        }
        if (!writing.Push(std::move(*finished))) break;
        if (!bad_frame.empty()) throw std::runtime_error(bad_frame);
      }
    });
    capture_.Stop();
    output_.StopWaitingForReaders();
    try {
      writing.Finish();
    } catch (const std::exception& error) {
      failure_ = error.what();
      output_.LeaveRoom();
      Note(EventKind::kDisk, failure_);
    }
  }

  // Done whatever has failed: complete outputs get their names, and the report is written if
  // possible.
  void End(std::vector<std::string> notes) {
    capture_.Stop();
    if (recorder_) recorder_->Close();
    RunReport& report = output_.Report();
    watch_->Finish(fmt::format("{} frames composited", report.totals.done));
    if (recorder_) Try([&] { recorder_->Finish(); });
    Try([&] { output_.Finish(); });
    std::ranges::move(notes, std::back_inserter(report.notes));
    Summarise(report);
    Try([&] { output_.WriteReport(); });
    if (!failure_.empty()) throw std::runtime_error(failure_);
  }

  // Its failure is an event, too: before the watch ends.
  void TryAndNote(const std::function<void()>& step) {
    const bool had_failed = !failure_.empty();
    Try(step);
    if (!had_failed && !failure_.empty()) Note(EventKind::kFailed, failure_);
  }

  void Try(const std::function<void()>& step) {
    try {
      step();
    } catch (const std::exception& error) {
      if (failure_.empty()) failure_ = error.what();
    }
  }

  void Summarise(RunReport& report) const {
    report.notes.push_back(fmt::format(
        "{} frames composited, {} failed, {} passed before the site was ready, {} dropped as later "
        "ones were there, {} lost by the driver",
        report.totals.done,
        report.totals.failed,
        passed_,
        events_.CountOf(EventKind::kFrameDropped),
        events_.CountOf(EventKind::kFrameLost)));
    const TimeStatistics& latency = report.totals.latency;
    if (latency.Count() == 0) return;
    report.notes.push_back(
        fmt::format("from a frame's timestamp to its composite: median {:.1f} ms, 99 % within "
                    "{:.1f} ms, worst {:.1f} ms",
                    latency.QuantileMs(0.5),
                    latency.QuantileMs(0.99),
                    latency.LargestMs()));
    spdlog::info("{}", report.notes.back());
  }

  const RunCommandOptions& options_;
  StopSignals signals_;
  EventLog events_;
  Sequence site_;
  CameraCapture capture_;
  RunTargets targets_;
  RunOutput output_;
  std::optional<Recorder> recorder_;
  std::optional<PosedCamera> camera_;
  bool site_is_there_ = true;
  std::optional<CameraWatch> watch_;
  std::atomic<bool> is_preparing_ = false;
  std::atomic<bool> no_more_pictures_ = false;  // Before the site was ready.
  std::int64_t passed_ = 0;                     // Pictures that passed until then.
  std::chrono::nanoseconds taken_{0};  // When the current frame was taken, on the monotonic clock.
  std::string failure_;                // Why it ended early, one line; empty: it did not.
};

}  // namespace

void RunLiveCommand(RunCommandOptions options) {
  if (!options.written) options.written = WrittenPictures::kShown;
  options.pipeline.sun_ahead = true;
  options.pipeline.light_in_steps = true;
  LiveRun(options).Run();
}

}  // namespace pleinair
