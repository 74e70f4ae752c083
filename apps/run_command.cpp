#include "apps/run_command.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/calibrate_north_command.h"
#include "apps/elapsed.h"
#include "apps/frame_writer.h"
#include "apps/given_lighting.h"
#include "apps/lighting_log.h"
#include "apps/plan_log.h"
#include "apps/progress.h"
#include "apps/run_report.h"
#include "apps/survey_maps_writer.h"
#include "apps/video_file.h"
#include "datasets/truth.h"
#include "pipeline/shadow_direction.h"
#include "render/gl_context.h"
#include "scene/image_io.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

// Folders of a run with a file or two for each frame, and what else it leaves.
constexpr const char* kFrameFolders[] = {"composite", "mask", "sky", "environment"};
constexpr const char* kRunFiles[] = {
    "lighting.jsonl", "plan.jsonl", "report.html", "score.json", "composite.mp4"};

// Files named after a frame, NNNNNN..., and their folder where nothing else is in it.
void RemoveFrameFiles(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  if (!fs::is_directory(folder)) return;
  std::vector<fs::path> of_frames;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    constexpr std::size_t kDigits = 6;
    const bool is_numbered =
        name.size() > kDigits && name.find_first_not_of("0123456789") == kDigits;
    if (is_numbered && entry.is_regular_file()) of_frames.push_back(entry.path());
  }
  for (const fs::path& file : of_frames) fs::remove(file);
  if (fs::is_empty(folder)) fs::remove(folder);
}

// One run's output folder: nothing of an earlier run stays beside the new one's, all else does, and
// lighting.jsonl and plan.jsonl have their names only when they are whole.
class RunFolder {
 public:
  explicit RunFolder(std::filesystem::path out) : out_(std::move(out)) {
    std::filesystem::create_directories(out_);
    for (const char* name : kRunFiles) std::filesystem::remove(out_ / name);
    for (const char* name : kFrameFolders) RemoveFrameFiles(out_ / name);
    lighting_.emplace(out_ / "lighting.jsonl");
    plan_.emplace(out_ / "plan.jsonl");
  }

  void AddLighting(const std::string& line) { lighting_->Add(line); }
  void AddPlan(const std::string& line) { plan_->Add(line); }
  void Finish() {
    lighting_->Finish();
    plan_->Finish();
  }

 private:
  // A line a frame.
  class Log {
   public:
    explicit Log(std::filesystem::path file)
        : file_(std::move(file)), partial_(file_.string() + ".partial") {
      out_.open(partial_, std::ios::trunc);
      if (!out_) throw std::runtime_error(partial_.string() + ": cannot be written");
    }
    void Add(const std::string& line) {
      out_ << line << '\n' << std::flush;
      if (!out_) throw std::runtime_error(partial_.string() + ": cannot be written (disc full?)");
    }
    void Finish() {
      out_.close();
      std::filesystem::rename(partial_, file_);
    }

   private:
    std::filesystem::path file_;
    std::filesystem::path partial_;
    std::ofstream out_;
  };

  std::filesystem::path out_;
  std::optional<Log> lighting_;
  std::optional<Log> plan_;
};

// What a run reads must not be what it removes first.
void ExpectLightingElsewhere(const RunCommandOptions& options) {
  namespace fs = std::filesystem;
  if (options.lighting.empty()) return;
  const fs::path out = fs::weakly_canonical(options.out);
  const auto expect_elsewhere = [&](const fs::path& file) {
    const fs::path read = fs::weakly_canonical(file);
    bool is_removed = false;
    for (const char* name : kRunFiles) is_removed = is_removed || read == out / name;
    for (const char* name : kFrameFolders) {
      is_removed = is_removed || read.parent_path() == out / name;
    }
    if (!is_removed) return;
    throw std::invalid_argument("--lighting: " + file.string() +
                                " is of the run in --out, which is written anew: expected another "
                                "folder for one of them");
  };
  expect_elsewhere(options.lighting);
  for (const auto& [frame, light] : ReadGivenLighting(options.lighting)) {
    if (light.sky_image) expect_elsewhere(*light.sky_image);
  }
}

std::string DescribeDaylight(const RunCommandOptions& options, const SequenceSite& site) {
  if (DaylightOf(options, site) == Daylight::kGather) return "with the rest";
  const DirectDaylightOptions& direct = options.direct_daylight;
  return fmt::format("by {} samples a shape of the sky, shadow maps of {} px",
                     direct.sampling.samples,
                     direct.shadows.map_size_px);
}

std::vector<std::string> DescribeSettings(const RunCommandOptions& options,
                                          const Sequence& sequence,
                                          const SequenceSite& site,
                                          const HeadlessContext& context) {
  const GlDescription gl = context.Describe();
  return {
      fmt::format("{} frames, {}x{}",
                  sequence.frames.size(),
                  sequence.intrinsics.width_px,
                  sequence.intrinsics.height_px),
      fmt::format(
          "frames {}, {} samples, seed {}, bounces {}, object light by {}, direct daylight {}, "
          "light {}",
          options.frames == FrameKind::kLinear ? "linear" : "ldr",
          options.samples,
          options.seed,
          options.prepare.bounces == kAllBounces ? "all" : std::to_string(options.prepare.bounces),
          options.object_light == ObjectLight::kGather     ? "rays at vertices"
          : options.object_light == ObjectLight::kOnePlace ? "rays at one place"
          : options.object_light == ObjectLight::kVolume   ? "folded probes"
                                                           : "probes from the map",
          DescribeDaylight(options, site),
          options.filter ? "filtered over time" : "of each frame by itself"),
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
              const FrameWriter& writer,
              RunReport& report) {
  const std::map<int, TruthFrame> truth = TruthByFrame(sequence);
  for (ReportFrame& frame : report.frames) {
    const auto found = truth.find(frame.index);
    if (found == truth.end()) continue;
    frame.true_sun_irradiance_rgb = found->second.sun_irradiance_rgb;
    frame.true_sky_irradiance_rgb = found->second.sky_irradiance_rgb;
    if (found->second.with_object && frame.error.empty()) {
      const RgbImage picture = ReadRadianceImage(*found->second.with_object);
      const Rgb8Image truth_shown =
          writer.Display(picture, sequence.frames[static_cast<std::size_t>(frame.index)].exposure);
      frame.truth = MakeReportPicture(truth_shown);
      frame.difference = MakeReportPicture(
          Difference(ReadDisplayImage(out / "composite" / fmt::format("{:06}.png", frame.index)),
                     truth_shown));
    }
  }
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
      "the shadows speak for a sun {:.1f} deg {} of the computed one: north, place or time may be "
      "wrong; see `pleinair calibrate north`",
      std::abs(DegFromRad(result.all.azimuth_offset_rad)),
      result.all.azimuth_offset_rad > 0.0 ? "clockwise" : "counter-clockwise"));
  spdlog::warn("{}", report.notes.back());
}

// Once a run: what the light's numbers stand for.
void NoteUnits(LightUnits units, RunReport& report) {
  static const std::string kAll =
      "the exposure of 8-bit frames is known up to one factor: light is relative, not in the "
      "survey's units";
  static const std::string kEach =
      "the exposure of 8-bit frames is not known: light is relative, each frame's in the units of "
      "its own picture";
  if (units == LightUnits::kAbsolute) return;
  const std::string& note = units == LightUnits::kRelative ? kAll : kEach;
  if (std::find(report.notes.begin(), report.notes.end(), note) != report.notes.end()) return;
  report.notes.push_back(note);
  spdlog::warn("{}", note);
}

ReportFrame FailedFrame(const FrameError& error) {
  ReportFrame reported;
  reported.index = error.index;
  reported.time = error.time;
  reported.error = error.reason;
  return reported;
}

// What the run has noted since the last call, into the log and the report.
void TakeNotes(SequenceRun& run, RunReport& report) {
  for (std::string& note : run.TakeNotes()) {
    spdlog::warn("{}", note);
    report.notes.push_back(std::move(note));
  }
}

}  // namespace

void RunPrepareCommand(const PrepareCommandOptions& options) {
  SequenceRunOptions run;
  run.sequence = options.sequence;
  run.cache = options.cache;
  run.prepare = options.prepare;
  // What `run` finds from the frames is not kept.
  if (!ReadSequence(options.sequence).environment) run.albedo = AlbedoSource::kMaterials;
  const auto loaded = LoadForRun(run, ProgressOnStandardError());
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
  ExpectLightingElsewhere(options);
  const auto loaded = LoadForRun(options, ProgressOnStandardError());
  const Sequence& sequence = loaded->sequence;
  const ResponseCurve response = ResponseOf(sequence);
  const HeadlessContext context;
  SequenceRun run(loaded, options);

  RunReport report;
  report.title =
      "pleinair: " + (sequence.name.empty() ? sequence.folder.filename().string() : sequence.name);
  report.settings = DescribeSettings(options, sequence, loaded->site, context);
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

  RunFolder folder(options.out);
  FrameWriter writer(options.out, response);
  std::optional<VideoFile> video;
  if (options.video) {
    video.emplace(options.out / "composite.mp4", options.video_frames_per_second);
  }
  int done = 0;
  while (std::optional<RunStep> step = run.Next()) {
    TakeNotes(run, report);
    if (!step->result) {
      const FrameError& error = step->result.error();
      spdlog::error("frame {}: {}", error.index, error.reason);
      folder.AddLighting(FailureLine(error));
      folder.AddPlan(FailureLine(error));
      report.frames.push_back(FailedFrame(error));
      if (options.stop_on_bad_frame) {
        throw std::runtime_error(fmt::format("stopped at frame {}, as asked", error.index));
      }
      continue;
    }
    const Frame& frame = *step->frame;
    FrameResult& result = *step->result;
    const auto write_start = std::chrono::steady_clock::now();
    const Rgb8Image shown = writer.Write(frame, result.composite);
    if (video) video->Add(shown);
    if (options.write_environment) {
      const SequenceRun::Environment environment = run.EnvironmentOf(result.estimate.lighting);
      writer.WriteEnvironment(frame.index, environment.with_sun, environment.without_sun);
    }
    std::string sky_image;
    if (const std::optional<RgbImage> sky = run.SkyImageOf(result.estimate.lighting)) {
      sky_image = writer.WriteSky(frame.index, *sky);
    }
    result.timing_ms.write = MsSince(write_start);
    folder.AddLighting(LightingLine(frame, result, sky_image));
    folder.AddPlan(PlanLine(frame, result, options.effects));

    ReportFrame reported;
    reported.index = frame.index;
    reported.time = frame.time;
    reported.input = MakeReportPicture(
        frame.codes ? *frame.codes : writer.Display(frame.radiance, frame.exposure));
    reported.composite = MakeReportPicture(shown);
    reported.lighting = result.estimate.lighting;
    reported.estimate = result.estimate;
    reported.timing_ms = result.timing_ms;
    reported.plan = result.plan;
    NoteUnits(result.estimate.units, report);
    if (shadows) shadows->Add(frame, result.sun.direction_enu);
    report.frames.push_back(std::move(reported));
    ++done;
    const glm::dvec3 sun = result.estimate.lighting.sun.irradiance_rgb;
    const glm::dvec3 sky = result.estimate.lighting.SkyIrradianceRgb();
    spdlog::info("frame {} of {}: sun {:.4g}, sky {:.4g}{}",
                 frame.index + 1,
                 sequence.frames.size(),
                 (sun.x + sun.y + sun.z) / 3.0,
                 (sky.x + sky.y + sky.z) / 3.0,
                 result.estimate.sun_observable ? "" : " (sun not observable)");
  }
  folder.Finish();
  if (video) video->Finish();
  if (shadows && done > 0) ReportShadows(*shadows, report);
  AddTruth(sequence, options.out, writer, report);
  WriteRunReport(options.out / "report.html", report);
  spdlog::info("{} of {} frames done; report: {}",
               done,
               report.frames.size(),
               (options.out / "report.html").string());
  if (done == 0)
    throw std::runtime_error("no frame of " + sequence.folder.string() + " could be done");
}

}  // namespace pleinair
