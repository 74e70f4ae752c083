#include "apps/run_command.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/calibrate_north_command.h"
#include "apps/frame_writer.h"
#include "apps/lighting_log.h"
#include "apps/plan_log.h"
#include "apps/progress.h"
#include "apps/run_folder.h"
#include "apps/run_report.h"
#include "apps/survey_maps_writer.h"
#include "apps/video_file.h"
#include "datasets/truth.h"
#include "pipeline/shadow_direction.h"
#include "pipeline/sun_check.h"
#include "scene/elapsed.h"
#include "scene/half_float.h"
#include "scene/image_io.h"
#include "session/given_lighting.h"
#include "session/session_choices.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

// What a run reads must not be what it removes first.
void RequireInputsKept(const RunCommandOptions& options) {
  // What is no sequence is refused as such.
  if (std::filesystem::exists(options.sequence / "sequence.json")) {
    RequireApart(options.out, options.sequence);
  }
  if (options.lighting.empty()) return;
  RequireKept(options.lighting, options.out, "--lighting");
  for (const auto& [frame, light] : ReadGivenLighting(options.lighting)) {
    if (light.sky_image) RequireKept(*light.sky_image, options.out, "--lighting");
  }
}

std::string DescribeDaylight(const RunCommandOptions& options, const SequenceSite& site) {
  if (DaylightOf(options, site) == Daylight::kGather) return "with the rest";
  const DirectDaylightOptions& direct = options.pipeline.object_light.direct_daylight;
  return fmt::format("by {} samples a shape of the sky, shadow maps of {} px",
                     direct.sampling.samples,
                     direct.shadows.map_size_px);
}

std::vector<std::string> DescribeSettings(const RunCommandOptions& options,
                                          const Sequence& sequence,
                                          const SequenceSite& site,
                                          const GlDescription& gl) {
  return {
      fmt::format("{} frames, {}x{}",
                  sequence.frames.size(),
                  sequence.intrinsics.width_px,
                  sequence.intrinsics.height_px),
      fmt::format(
          "frames {}, {} samples, seed {}, bounces {}, object light by {}, direct daylight {}, "
          "light {}",
          options.frames == FrameKind::kLinear ? "linear" : "ldr",
          options.light.samples,
          options.light.seed,
          options.prepare.bounces == kAllBounces ? "all" : std::to_string(options.prepare.bounces),
          options.pipeline.object_light.route == ObjectLight::kGather ? "rays at vertices"
          : options.pipeline.object_light.route == ObjectLight::kSingleProbe
              ? "rays at a single probe"
          : options.pipeline.object_light.route == ObjectLight::kVolume ? "folded probes"
                                                                        : "probes from the map",
          DescribeDaylight(options, site),
          options.pipeline.filter ? "filtered over time" : "of each frame by itself"),
      fmt::format("OpenGL: {} ({})", gl.renderer, gl.version)};
}

// By frame; empty where the sequence has no truth. For the report alone: it is read when the run is
// over.
std::map<int, TruthFrame> TruthByFrame(const Sequence& sequence) {
  std::map<int, TruthFrame> by_frame;
  if (!std::filesystem::exists(sequence.folder / "truth" / "truth.json")) return by_frame;
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
  std::string missing;
  for (ReportFrame& frame : report.frames) {
    const auto found = truth.find(frame.index);
    if (found == truth.end()) continue;
    frame.true_sun_irradiance_rgb = found->second.sun_irradiance_rgb;
    frame.true_sky_irradiance_rgb = found->second.sky_irradiance_rgb;
    if (!found->second.with_object || !frame.error.empty()) continue;
    try {
      const RgbImage picture = ReadRadianceImage(*found->second.with_object);
      const Rgb8Image truth_shown =
          display.Show(picture, sequence.frames[static_cast<std::size_t>(frame.index)].exposure);
      frame.truth = MakeReportPicture(truth_shown);
      frame.difference = MakeReportPicture(
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

// What the real shadows say of the sun, into the log and the report.
void ReportShadows(const ShadowDirectionFinder& finder, RunReport& report) {
  const ShadowDirectionResult result = finder.Result();
  for (const FrameShadowDirection& frame : result.frames) {
    report.notes.push_back(
        fmt::format("frame {}: {}", frame.frame, DescribeShadowDirection(frame.shadow)));
  }
  const std::string all = "all frames: " + DescribeShadowDirection(result.all);
  report.notes.push_back(all);
  spdlog::info("{}", all);
  if (!result.all.ContradictsTheSun()) return;
  report.notes.push_back(fmt::format(
      "the shadows indicate a sun {:.1f} deg {} of the computed one: north, place or time may be "
      "wrong; see `pleinair calibrate north`",
      std::abs(DegFromRad(result.all.azimuth_offset_rad)),
      result.all.azimuth_offset_rad > 0.0 ? "clockwise" : "counter-clockwise"));
  spdlog::warn("{}", report.notes.back());
}

void NoteContradiction(const std::optional<SunContradiction>& contradiction,
                       const Sequence& sequence,
                       RunReport& report) {
  if (!contradiction) return;
  const auto frame = static_cast<std::size_t>(contradiction->frame);
  const std::string shown = AzimuthAndElevation(contradiction->shown_enu);
  if (contradiction->stated_enu == kNoSunDirectionEnu) {
    report.notes.push_back(
        fmt::format("frame {}: the shadows show a sun at {}, where none is stated: its "
                    "weather may be wrong, and sun_direction_enu or a site would help",
                    frame,
                    shown));
  } else {
    const bool stated = sequence.StatedSunDirectionEnu(frame).has_value();
    report.notes.push_back(
        fmt::format("frame {}: the shadows show the sun {:.1f} deg (sigma {:.1f}) from where it is "
                    "{}: at {}, not at {}: {} may be wrong; see `pleinair calibrate north`",
                    frame,
                    DegFromRad(contradiction->angle_rad),
                    DegFromRad(contradiction->stddev_rad),
                    stated ? "stated" : "computed",
                    shown,
                    AzimuthAndElevation(contradiction->stated_enu),
                    stated ? "sun_direction_enu, or the camera's pose,"
                           : "the model's north, place or time (zone)"));
  }
  spdlog::warn("{}", report.notes.back());
}

// Once a run: what the light's numbers stand for.
void NoteUnits(LightUnits units, RunReport& report) {
  static const std::string kAll =
      "the exposure of 8-bit frames is known up to one factor: light is relative, not in the "
      "survey's units";
  static const std::string kEach =
      "the exposure of 8-bit frames is not known (a frame's exposure, or exposure_s, iso and "
      "f_number, would give it): light is relative, each frame's in the units of its own picture";
  if (units == LightUnits::kAbsolute) return;
  const std::string& note = units == LightUnits::kRelative ? kAll : kEach;
  if (std::find(report.notes.begin(), report.notes.end(), note) != report.notes.end()) return;
  report.notes.push_back(note);
  spdlog::warn("{}", note);
}

// What no picture could be made of as it was, over a run's frames.
class PictureDefects {
 public:
  void Add(const Frame& frame, const FrameResult& result) {
    not_finite_.Add(frame.defects.not_finite);
    clamped_.Add(result.clamped_pixels);
    frames_without_colour_ += result.drawn_lighting ? 1 : 0;
  }
  void Report(RunReport& report) const {
    NotePixels(not_finite_, "not finite: not used for the estimate, and written unchanged", report);
    NotePixels(clamped_, fmt::format("beyond half floats: written as {}", kLargestHalf), report);
    if (frames_without_colour_ == 0) return;
    Note(
        fmt::format("the estimated light of {} frames lacks a colour that daylight has: drawn with "
                    "more of it, see drawn_light in plan.jsonl",
                    frames_without_colour_),
        report);
  }

 private:
  struct Count {
    std::int64_t pixels = 0;
    int frames = 0;
    void Add(std::int64_t more) {
      pixels += more;
      frames += more > 0 ? 1 : 0;
    }
  };
  static void Note(const std::string& note, RunReport& report) {
    report.notes.push_back(note);
    spdlog::warn("{}", note);
  }
  static void NotePixels(const Count& count, const std::string& what, RunReport& report) {
    if (count.pixels == 0) return;
    Note(fmt::format("{} pixels of {} frames are {}", count.pixels, count.frames, what), report);
  }

  Count not_finite_;
  Count clamped_;
  int frames_without_colour_ = 0;
};

ReportFrame FailedFrame(const FrameError& error) {
  ReportFrame reported;
  reported.index = error.index;
  reported.time = error.time;
  reported.error = error.reason;
  return reported;
}

// What the run has noted since the last call, into the log and the report.
void TakeNotes(SequenceSession& run, RunReport& report) {
  for (std::string& note : run.TakeNotes()) {
    spdlog::warn("{}", note);
    report.notes.push_back(std::move(note));
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
               scene.patches.mesh.triangles.size(),
               scene.probes.Grid().ProbeCount(),
               scene.from_store ? "; all of it from the cache" : "");
  if (options.maps) WriteSurveyMaps(scene, *options.maps);
}

void RunRunCommand(const RunCommandOptions& options) {
  RequireInputsKept(options);
  const auto loaded = LoadSequence(options, ProgressOnStandardError());
  const Sequence& sequence = loaded->sequence;
  SequenceSession run(loaded, options);

  RunReport report;
  report.title =
      "pleinair: " + (sequence.name.empty() ? sequence.folder.filename().string() : sequence.name);
  report.settings = DescribeSettings(options, sequence, loaded->site, run.Renderer());
  if (loaded->board)
    report.settings.push_back("camera poses from the markers of " + options.markers.string());
  TakeNotes(run, report);
  if (const std::string note = run.DaylightNote(); !note.empty()) {
    report.notes.push_back(note);
    spdlog::info("{}", note);
  }
  std::optional<ShadowDirectionFinder> shadows;
  if (options.measure_shadows) {
    shadows.emplace(loaded->site.model.mesh, loaded->site.model.diffuse_regions);
  }

  // A fish-eye camera sees the sun itself, and --lighting states the light.
  std::optional<SunCheck> sun_check;
  if (options.lighting.empty() && SourceOf(options, sequence) == SourceKind::kOutdoor) {
    sun_check.emplace(loaded->site.model.mesh, loaded->site.model.diffuse_regions);
  }

  RunFolder folder(options.out);
  if (!folder.TakenOverFrom().empty()) {
    spdlog::warn("{}: an earlier run did not end ({}): what it left unfinished is removed",
                 options.out.string(),
                 folder.TakenOverFrom());
  }
  const FrameWriter writer(options.out);
  std::optional<VideoFile> video;
  if (options.video) {
    video.emplace(options.out / "composite.mp4", options.video_frames_per_second);
  }
  int done = 0;
  PictureDefects defects;
  while (std::optional<SessionStep> step = run.Next()) {
    TakeNotes(run, report);
    if (!step->result) {
      const FrameError& error = step->result.error();
      spdlog::error("frame {}: {}", error.index, error.reason);
      folder.AddLighting(FailureLine(error));
      folder.AddPlan(FailureLine(error));
      report.frames.push_back(FailedFrame(error));
      if (options.stop_on_bad_frame) {
        throw std::runtime_error(
            fmt::format("stopped at frame {}, as asked: {}", error.index, error.reason));
      }
      continue;
    }
    const Frame& frame = *step->frame;
    FrameResult& result = *step->result;
    const auto write_start = std::chrono::steady_clock::now();
    const Rgb8Image shown = run.Show(*step);
    writer.Write(frame.index, result.composite, shown);
    if (video) video->Add(shown);
    if (options.write_environment) {
      const SequenceSession::Environment environment = run.EnvironmentOf(result.estimate.lighting);
      writer.WriteEnvironment(frame.index, environment.with_sun, environment.without_sun);
    }
    std::string sky_image;
    if (const std::optional<RgbImage> sky = run.SkyImageOf(result.estimate.lighting)) {
      sky_image = writer.WriteSky(frame.index, *sky);
    }
    result.timing_ms.write = MsSince(write_start);
    folder.AddLighting(LightingLine(frame, result, sky_image));
    folder.AddPlan(PlanLine(frame, result, options.pipeline.effects));

    ReportFrame reported;
    reported.index = frame.index;
    reported.time = frame.time;
    reported.input = MakeReportPicture(
        frame.codes ? *frame.codes : run.Display().Show(frame.radiance, frame.exposure));
    reported.composite = MakeReportPicture(shown);
    reported.lighting = result.estimate.lighting;
    reported.estimate = result.estimate;
    reported.timing_ms = result.timing_ms;
    reported.plan = result.plan;
    NoteUnits(result.estimate.units, report);
    defects.Add(frame, result);
    if (shadows) shadows->Add(frame, result.sun.direction_enu);
    if (sun_check) NoteContradiction(sun_check->Look(frame, reported.lighting), sequence, report);
    report.frames.push_back(std::move(reported));
    ++done;
    const glm::dvec3 sun = result.estimate.lighting.sun.irradiance_rgb;
    const glm::dvec3 sky = result.estimate.lighting.SkyIrradianceRgb();
    spdlog::info("frame {} of {}: sun {:.4g}, sky {:.4g}{}",
                 frame.index + 1,
                 sequence.frames.size(),
                 (sun.x + sun.y + sun.z) / 3.0,
                 (sky.x + sky.y + sky.z) / 3.0,
                 !LightIsKnown(result.estimate.lighting)
                     ? " (hardly known: the picture shows neither "
                       "sun nor shade; earlier light and "
                       "weather answer)"
                 : result.estimate.sun_observable ? ""
                                                  : " (sun not observable)");
  }
  folder.Finish();
  if (video) video->Finish();
  defects.Report(report);
  if (shadows && done > 0) ReportShadows(*shadows, report);
  AddTruth(sequence, options.out, run.Display(), report);
  WriteRunReport(options.out / "report.html", report);
  spdlog::info("{} of {} frames done; report: {}",
               done,
               report.frames.size(),
               (options.out / "report.html").string());
  if (done == 0) {
    const ReportFrame& first = report.frames.front();
    throw std::runtime_error(fmt::format("all frames of {} failed; frame {}: {}",
                                         sequence.folder.string(),
                                         first.index,
                                         first.error));
  }
}

}  // namespace pleinair
