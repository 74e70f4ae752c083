#include "apps/run_output.h"

#include <exception>
#include <utility>

#include <spdlog/spdlog.h>

#include "apps/lighting_log.h"
#include "apps/plan_log.h"
#include "datasets/recording/recording.h"
#include "scene/stopwatch.h"

namespace pleinair {
namespace {

ReportFrame FailedFrame(const FrameError& error) {
  ReportFrame reported;
  reported.index = error.index;
  reported.time = error.time;
  reported.error = error.reason;
  return reported;
}

}  // namespace

RunOutput::RunOutput(const RunCommandOptions& options,
                     RunTargets& targets,
                     EventLog& events,
                     std::optional<double> camera_rate)
    : options_(options),
      targets_(targets),
      events_(events),
      folder_(targets.folder),
      writer_(options.out, options.written.value_or(WrittenPictures::kAll)),
      report_(options.out) {
  if (!targets.folder.TakenOverFrom().empty() && folder_.HadUnfinished()) {
    spdlog::warn("{}: an earlier run did not end ({}): what it left unfinished is removed",
                 options.out.string(),
                 targets.folder.TakenOverFrom());
  }
  if (options.video) {
    constexpr double kUsualRate = 10.0;
    video_.emplace(options.out / "composite.mp4",
                   options.video_frames_per_second.value_or(camera_rate.value_or(kUsualRate)));
  }
}

template <typename Stream, typename Item>
void RunOutput::WriteTo(std::optional<Stream>& stream, const Item& item, UtcTime time) {
  if (!stream) return;
  try {
    stream->Write(item);
  } catch (const std::exception& error) {
    events_.Add({time, EventKind::kOutput, error.what()});
    stream.reset();
  }
}

void RunOutput::Begin() {
  if (folder_.HadResults() && !folder_.HasBegun()) {
    spdlog::info("{}: the results of an earlier run are replaced", options_.out.string());
  }
  folder_.Begin();
}

bool RunOutput::KeepsEarlierResults() const { return folder_.HadResults() && !folder_.HasBegun(); }

void RunOutput::Add(FinishedFrame frame) {
  if (frame.step.result) {
    Begin();
    AddDone(std::move(frame));
    return;
  }
  const FrameError& error = frame.step.result.error();
  const std::string line = FailureLine(error);
  folder_.AddFrame(line, line);
  WriteTo(targets_.lines, line, error.time);
  report_.Add(FailedFrame(error));
}

void RunOutput::AddPassed(const Rgb8Image& picture, UtcTime time) {
  WriteTo(targets_.pictures, picture, time);
  if (video_) video_->Add(picture);
}

void RunOutput::AddDone(FinishedFrame finished) {
  const Frame& frame = *finished.step.frame;
  FrameResult& result = *finished.step.result;
  Stopwatch watch;
  // Pictures that somebody watches go out before those that are kept.
  WriteTo(targets_.pictures, finished.shown, frame.time);
  writer_.Write(frame.index, result.composite, finished.shown);
  if (video_) video_->Add(finished.shown);
  if (finished.environment) {
    writer_.WriteEnvironment(
        frame.index, finished.environment->with_sun, finished.environment->without_sun);
  }
  std::string sky_image;
  if (finished.sky) sky_image = writer_.WriteSky(frame.index, *finished.sky);
  result.timing_ms.write = watch.LapMs();
  const std::string line = LightingLine(frame, result, sky_image, finished.latency_ms);
  folder_.AddFrame(line, PlanLine(frame, result, options_.pipeline.effects));
  WriteTo(targets_.lines, line, frame.time);

  ReportFrame reported;
  reported.index = frame.index;
  reported.time = frame.time;
  if (report_.ShowsNext()) {
    const Rgb8Image* input = finished.input ? &*finished.input : nullptr;
    if (frame.codes) input = &*frame.codes;
    if (input != nullptr) reported.input = report_.AddPicture(*input);
    reported.composite = report_.AddPicture(finished.shown);
    NoteFullDisk(frame.time);
  }
  reported.lighting = result.estimate.lighting;
  reported.estimate = std::move(result.estimate);
  reported.is_drawn_without_sun = result.is_drawn_without_sun;
  reported.timing_ms = result.timing_ms;
  reported.latency_ms = finished.latency_ms;
  reported.plan = result.plan;
  report_.Add(std::move(reported));
}

void RunOutput::AddEvent(Event event) {
  const std::string line = LineOf(event);
  report_.AddEvent(std::move(event));  // Also where the folder has no room.
  folder_.AddEvent(line);
}

void RunOutput::Finish() {
  if (KeepsEarlierResults()) {
    spdlog::warn("{}: no frame was composited: the results of an earlier run stay",
                 options_.out.string());
    return;
  }
  folder_.Finish();
  if (video_) video_->Finish();
}

void RunOutput::NoteFullDisk(UtcTime time) {
  if (is_disk_full_ || !report_.PicturesAreInMemory()) return;
  is_disk_full_ = true;
  events_.Add({time,
               EventKind::kDisk,
               options_.out.string() +
                   ": the disk is nearly full: the report's pictures are kept in memory"});
}

void RunOutput::WriteReport() {
  if (KeepsEarlierResults()) return;
  const std::filesystem::path file = options_.out / "report.html";
  report_.LeaveRoom();
  try {
    WriteRunReport(file, report_);
  } catch (const std::exception& error) {
    // A day's light is worth more than its pictures, and is a hundredth of them.
    report_.LeavePicturesOut();
    report_.notes.push_back(std::string("the report is without pictures: ") + error.what());
    WriteRunReport(file, report_);
    spdlog::warn("{}", report_.notes.back());
  }
}

}  // namespace pleinair
