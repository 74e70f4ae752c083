#include "apps/run_command.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/frame_loop.h"
#include "apps/input_refusals.h"
#include "apps/live_run.h"
#include "apps/progress.h"
#include "apps/run_description.h"
#include "apps/run_folder.h"
#include "apps/run_output.h"
#include "apps/run_targets.h"
#include "apps/stop_signals.h"
#include "apps/survey_maps_writer.h"
#include "datasets/truth.h"
#include "scene/image_io.h"
#include "session/given_lighting.h"
#include "session/site_frames.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

// A run must not first remove what it reads.
void RequireInputsKept(const RunCommandOptions& options) {
  // What is no sequence and no site is refused as such.
  for (const char* name : {"sequence.json", "site.json"}) {
    if (std::filesystem::exists(options.sequence / name)) {
      RequireApart(options.out, options.sequence);
    }
  }
  if (std::filesystem::is_directory(options.input)) RequireApart(options.out, options.input);
  if (std::filesystem::is_regular_file(options.input)) {
    RequireKept(options.input, options.out, "input");
  }
  if (std::filesystem::is_regular_file(options.poses)) {
    RequireKept(options.poses, options.out, "--poses");
  }
  if (options.lighting.empty()) return;
  RequireKept(options.lighting, options.out, "--lighting");
  for (const auto& [frame, light] : ReadGivenLighting(options.lighting)) {
    if (light.sky_image) RequireKept(*light.sky_image, options.out, "--lighting");
  }
}

// By frame; empty where the sequence has no truth. For the report alone: it is read when the run is
// over.
std::map<int, TruthFrame> TruthByFrame(const Sequence& sequence) {
  std::map<int, TruthFrame> by_frame;
  if (!HasTruth(sequence)) return by_frame;
  for (TruthFrame& truth : ReadTruth(sequence)) by_frame.emplace(truth.frame, std::move(truth));
  return by_frame;
}

// a - b, kDifferenceGain times as large, around grey.
Rgb8Image Difference(const Rgb8Image& a, const Rgb8Image& b) {
  Rgb8Image difference(a.width, a.height);
  for (std::size_t i = 0; i < difference.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const int value = 128 + kDifferenceGain * (int{a.pixels[i][c]} - int{b.pixels[i][c]});
      difference.pixels[i][c] = static_cast<std::uint8_t>(std::clamp(value, 0, 255));
    }
  }
  return difference;
}

void AddTruth(const Sequence& sequence,
              const std::filesystem::path& out,
              const PictureDisplay& display,
              RunReport& report) {
  std::map<int, TruthFrame> truth;
  try {
    truth = TruthByFrame(sequence);
  } catch (const std::exception& error) {
    report.notes.push_back(std::string("the report is without truth: ") + error.what());
    spdlog::warn("{}", report.notes.back());
  }
  const bool has_pictures = std::filesystem::exists(out / "composite");
  std::string missing;
  for (ReportFrame& frame : report.frames) {
    const auto found = truth.find(frame.index);
    if (found == truth.end()) continue;
    frame.true_sun_irradiance_rgb = found->second.sun_irradiance_rgb;
    frame.true_sky_irradiance_rgb = found->second.sky_irradiance_rgb;
    if (!has_pictures || !found->second.with_object || !frame.error.empty()) continue;
    try {
      const RgbImage picture = ReadRadianceImage(*found->second.with_object);
      const Rgb8Image truth_shown =
          display.Show(picture, sequence.frames[static_cast<std::size_t>(frame.index)].exposure);
      frame.truth = report.AddPicture(truth_shown);
      frame.difference = report.AddPicture(
          Difference(ReadDisplayImage(out / "composite" / fmt::format("{:06}.png", frame.index)),
                     truth_shown));
    } catch (const std::exception& error) {
      if (missing.empty()) missing = error.what();
    }
  }
  if (missing.empty()) return;
  report.notes.push_back("the report is without some true pictures: " + missing);
  spdlog::warn("{}", report.notes.back());
}

void RefuseWhatDoesNotHold(const RunCommandOptions& options) {
  const PlayedInput input{options.input, options.camera, options.times};
  RefuseContradictions(options);
  RefuseOtherInputs(input, options);
  if (input.IsCamera()) return;
  RefuseWithoutCamera(!options.record.empty(), "--record");
  RefuseWithoutCamera(options.duration_s.has_value(), "--duration");
}

// An interrupted run does not wait for a stream's reader that does not read.
void StopWaitingForReadersOnceSet(const StopFlag& stop,
                                  RunOutput& output,
                                  const std::stop_token& is_over) {
  constexpr std::chrono::milliseconds kBetweenLooks{20};
  while (!is_over.stop_requested() && !stop.IsSet()) std::this_thread::sleep_for(kBetweenLooks);
  if (stop.IsSet()) output.StopWaitingForReaders();
}

// Runs on the sequence's own frames, or on a video or pictures at a site.
void RunRecorded(const RunCommandOptions& options) {
  RunTargets targets(options);
  const bool is_at_site = !options.input.empty();
  std::optional<UtcTime> first_time;
  if (is_at_site) first_time = FirstPictureTime(options.input, options.times);
  const auto loaded = is_at_site ? LoadSite(options, *first_time, ProgressOnStandardError())
                                 : LoadSequence(options, ProgressOnStandardError());
  const Sequence& sequence = loaded->sequence;
  std::optional<SequenceSession> session;
  std::optional<std::size_t> count;
  if (is_at_site) {
    if (!options.times.start && !IsPictureOrFolder(options.input)) {
      spdlog::warn(
          "{}: taken at {}, as the video states; a program that converted it may have "
          "stated its own time, and the sun would be elsewhere (see --start-time)",
          options.input,
          FormatUtcTime(*first_time));
    }
    auto frames =
        PosedFramesAt(*loaded, options.input, options.times, options, [](const std::string& note) {
          spdlog::warn("{}", note);
        });
    if (const auto known = frames->Count()) count = static_cast<std::size_t>(*known);
    session.emplace(loaded, options, std::move(frames));
  } else {
    count = sequence.frames.size();
    session.emplace(loaded, options);
  }
  SequenceSession& run = *session;

  FrameLoop frames(options, run);
  EventLog events;
  RunOutput output(options, targets, events);
  RunReport& report = output.Report();
  report.title = TitleOf(sequence);
  report.settings = DescribeSettings(options, *loaded, count, run.Renderer());
  const StopFlag stop;
  const std::jthread ending(
      [&](const std::stop_token& is_over) { StopWaitingForReadersOnceSet(stop, output, is_over); });
  std::string stopped;
  std::int64_t taken = 0;
  while (stopped.empty() && (!options.frames_limit || taken < *options.frames_limit)) {
    if (stop.IsSet() && !(count && static_cast<std::size_t>(taken) >= *count)) {
      stopped = InterruptedAfter(taken, count);
      break;
    }
    std::optional<FinishedFrame> finished = frames.Next();
    if (!finished) break;
    ++taken;
    LogLight(*finished, count);
    if (!finished->step.result && options.stop_on_bad_frame) {
      stopped = StoppedAt(finished->step.result.error());
    }
    output.Add(std::move(*finished));
  }
  for (Event& event : events.TakeAll()) {
    spdlog::warn("{}", event.text);
    output.AddEvent(std::move(event));
  }
  if (!stopped.empty()) report.notes.push_back(stopped);
  output.Finish();
  for (std::string& note : frames.Finish()) report.notes.push_back(std::move(note));
  if (!is_at_site && !output.KeepsEarlierResults()) {
    AddTruth(sequence, options.out, run.Display(), report);
  }
  output.WriteReport();
  if (stopped.empty()) {
    SayHowItEnded(options, report, sequence);
  } else {
    if (report.totals.done > 0) SayWhereTheReportIs(options, report);
    throw std::runtime_error(stopped);
  }
}

}  // namespace

void RunPrepareCommand(const PrepareCommandOptions& options) {
  if (options.maps) RequireApart(*options.maps, options.sequence);
  SessionOptions run;
  run.sequence = options.sequence;
  run.cache = options.cache;
  run.prepare = options.prepare;
  // What `run` finds from the frames is not kept.
  if (!ReadSequence(options.sequence).environment) run.albedo = AlbedoSource::kMaterials;
  const auto loaded = LoadSequence(run, ProgressOnStandardError());
  for (const std::string& note : loaded->site.notes) spdlog::warn("{}", note);
  const PreparedScene& scene = loaded->scene;
  for (const std::string& note : scene.notes) spdlog::info("{}", note);
  spdlog::info("{} patches, {} probes{}",
               scene.patches.PatchCount(),
               scene.probes.Grid().ProbeCount(),
               scene.from_store ? "; all of it from the cache" : "");
  if (options.maps) WriteSurveyMaps(scene, *options.maps);
}

void RunRunCommand(const RunCommandOptions& options) {
  RefuseWhatDoesNotHold(options);
  RequireInputsKept(options);
  if (!options.input.empty() && IsCameraName(options.input)) {
    RunLiveCommand(options);
  } else {
    RunCommandOptions readable = options;
    readable.poses = PoseFileOf(options.poses);
    RunRecorded(readable);
  }
}

}  // namespace pleinair
