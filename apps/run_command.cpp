#include "apps/run_command.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/calibrate_north_command.h"
#include "apps/file_blob_store.h"
#include "apps/frame_writer.h"
#include "apps/given_lighting.h"
#include "apps/lighting_log.h"
#include "apps/progress.h"
#include "apps/run_report.h"
#include "apps/sequence_site.h"
#include "apps/survey_maps_writer.h"
#include "calib/marker_board.h"
#include "datasets/fisheye_setup.h"
#include "datasets/marker_frame_source.h"
#include "datasets/truth.h"
#include "estimation/fisheye_lighting_source.h"
#include "pipeline/shadow_direction.h"
#include "render/gl_context.h"
#include "scene/image_io.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

double MsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

ResponseCurve ResponseOf(const Sequence& sequence) {
  return sequence.response_ldr == "srgb8"
             ? ResponseCurve::Srgb()
             : ResponseCurve::FromFile(sequence.folder / sequence.response_ldr);
}

bool HasFisheyePictures(const Sequence& sequence) {
  return std::any_of(sequence.frames.begin(), sequence.frames.end(), [](const FrameEntry& frame) {
    return frame.fisheye.has_value();
  });
}

SourceKind SourceOf(const RunCommandOptions& options, const Sequence& sequence) {
  return options.source.value_or(HasFisheyePictures(sequence) ? SourceKind::kFisheye
                                                              : SourceKind::kOutdoor);
}

// One run's output folder: nothing of an earlier run stays beside the new one's, and lighting.jsonl
// has its name only when it is whole.
class RunFolder {
 public:
  explicit RunFolder(std::filesystem::path out) : out_(std::move(out)) {
    std::filesystem::create_directories(out_);
    for (const char* name : {"lighting.jsonl", "report.html", "score.json", "composite", "mask"}) {
      std::filesystem::remove_all(out_ / name);
    }
    log_.open(PartialLog(), std::ios::trunc);
    if (!log_) throw std::runtime_error(PartialLog().string() + ": cannot be written");
  }

  void AddLine(const std::string& line) {
    log_ << line << '\n' << std::flush;
    if (!log_) throw std::runtime_error(PartialLog().string() + ": cannot be written (disc full?)");
  }

  void Finish() {
    log_.close();
    std::filesystem::rename(PartialLog(), out_ / "lighting.jsonl");
  }

 private:
  std::filesystem::path PartialLog() const { return out_ / "lighting.jsonl.partial"; }

  std::filesystem::path out_;
  std::ofstream log_;
};

Daylight DaylightOf(const RunCommandOptions& options, const SequenceSite& site) {
  const bool smooth = options.object_light != ObjectLight::kGather;
  return options.daylight.value_or(site.is_indoors && smooth ? Daylight::kSamples
                                                             : Daylight::kGather);
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
          options.object_light == ObjectLight::kGather   ? "rays at vertices"
          : options.object_light == ObjectLight::kVolume ? "folded probes"
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

void AddTruth(const Sequence& sequence, const FrameWriter& writer, RunReport& report) {
  const std::map<int, TruthFrame> truth = TruthByFrame(sequence);
  for (ReportFrame& frame : report.frames) {
    const auto found = truth.find(frame.index);
    if (found == truth.end()) continue;
    frame.true_sun_irradiance_rgb = found->second.sun_irradiance_rgb;
    frame.true_sky_irradiance_rgb = found->second.sky_irradiance_rgb;
    if (found->second.with_object && frame.error.empty()) {
      const RgbImage picture = ReadRadianceImage(*found->second.with_object);
      frame.truth = MakeReportPicture(
          writer.Display(picture, sequence.frames[static_cast<std::size_t>(frame.index)].exposure));
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

bool CameraMoves(const Sequence& sequence) {
  for (std::size_t i = 1; i < sequence.frames.size(); ++i) {
    if (!(sequence.CameraOfFrame(i) == sequence.CameraOfFrame(0))) return true;
  }
  return false;
}

ReportFrame FailedFrame(const FrameError& error) {
  ReportFrame reported;
  reported.index = error.index;
  reported.time = error.time;
  reported.error = error.reason;
  return reported;
}

// With --markers the sequence's own poses are not used, and may be absent.
Sequence ReadRunSequence(const RunCommandOptions& options,
                         const std::optional<MarkerBoard>& board) {
  Sequence sequence =
      board
          ? WithFirstMarkerPose(
                ReadSequence(options.sequence, SequencePoses::kMayBeAbsent), options.frames, *board)
          : ReadSequence(options.sequence);
  if (options.ignore_exposure) {
    for (FrameEntry& frame : sequence.frames) {
      frame.exposure.reset();
      frame.exposure_s.reset();
    }
  }
  return sequence;
}

std::unique_ptr<FrameSource> FramesOfRun(const RunCommandOptions& options,
                                         const Sequence& sequence,
                                         const std::optional<MarkerBoard>& board,
                                         RunReport& report) {
  if (!board) return MakeRecordedFrameSource(sequence, options.frames, options.camera_noise);
  MarkerFrameOptions markers;
  markers.camera_noise = options.camera_noise;
  markers.on_frame = [&report](const MarkerFrameReport& frame) {
    if (!frame.used || frame.used->origin == PoseOrigin::kFound) return;
    report.notes.push_back(fmt::format("frame {}: the camera pose of {} frame(s) before: {}",
                                       frame.index,
                                       frame.used->carried_frames,
                                       frame.reason));
    spdlog::warn("{}", report.notes.back());
  };
  return MakeRecordedMarkerFrameSource(sequence, options.frames, *board, std::move(markers));
}

// Directions that --lighting gives, by frame.
std::map<int, glm::dvec3> GivenSuns(const RunCommandOptions& options) {
  std::map<int, glm::dvec3> suns;
  if (options.lighting.empty()) return suns;
  for (const auto& [frame, light] : ReadGivenLighting(options.lighting)) {
    if (light.sun_direction_enu) suns.emplace(frame, *light.sun_direction_enu);
  }
  return suns;
}

void UseGivenSun(const std::map<int, glm::dvec3>& given_suns, Frame& frame) {
  const auto found = given_suns.find(frame.index);
  if (found != given_suns.end()) frame.sun_direction_enu = found->second;
}

void WarnWhereNothingWasKept(const FileBlobStore& store) {
  if (store.SaveFailure().empty()) return;
  spdlog::warn("the next run will prepare this site anew: {}", store.SaveFailure());
}

}  // namespace

std::unique_ptr<LightingSource> MakeSourceFor(const RunCommandOptions& options,
                                              const Sequence& sequence) {
  if (!options.lighting.empty()) {
    OutdoorLightingOptions shapes;
    shapes.samples = options.samples;
    shapes.seed = options.seed;
    shapes.sky_shapes = options.sky_shapes;
    return MakeGivenLightingSource(ReadGivenLighting(options.lighting),
                                   MakeOutdoorLightingSource(shapes));
  }
  if (SourceOf(options, sequence) == SourceKind::kFisheye) {
    if (!sequence.fisheye || !HasFisheyePictures(sequence)) {
      throw std::runtime_error((sequence.folder / "sequence.json").string() +
                               ": --source fisheye: expected the key fisheye, and frames that name "
                               "a fish-eye picture");
    }
    FisheyeLightingOptions fisheye;
    fisheye.samples = options.samples;
    fisheye.seed = options.seed;
    return MakeFisheyeLightingSource(MakeFisheyeSetup(*sequence.fisheye, sequence.folder).camera,
                                     fisheye);
  }
  OutdoorLightingOptions outdoor;
  outdoor.samples = options.samples;
  outdoor.seed = options.seed;
  outdoor.sky_shapes = options.sky_shapes;
  return MakeOutdoorLightingSource(outdoor);
}

void RunPrepareCommand(const PrepareCommandOptions& options) {
  const Sequence sequence = ReadSequence(options.sequence);
  const SequenceSite site = LoadSequenceSite(sequence);
  for (const std::string& note : site.notes) spdlog::warn("{}", note);
  FileBlobStore store(options.cache);
  const PreparedScene scene = PrepareScene(
      site.model, PrepareOptionsFor(site, options.prepare), store, ProgressOnStandardError());
  WarnWhereNothingWasKept(store);
  for (const std::string& note : scene.notes) spdlog::info("{}", note);
  spdlog::info("{} patches, {} probes{}",
               scene.patches.mesh.triangles.size(),
               scene.probes.Grid().ProbeCount(),
               scene.from_store ? "; all of it from the cache" : "");
  if (options.maps) WriteSurveyMaps(scene, *options.maps);
}

void RunRunCommand(const RunCommandOptions& options) {
  std::optional<MarkerBoard> board;
  if (!options.markers.empty()) board = ReadMarkerBoard(options.markers);
  const Sequence sequence = ReadRunSequence(options, board);
  const SequenceSite site = LoadSequenceSite(sequence);
  const ResponseCurve response = ResponseOf(sequence);
  std::unique_ptr<LightingSource> source = MakeSourceFor(options, sequence);
  const HeadlessContext context;

  RunReport report;
  report.title =
      "pleinair: " + (sequence.name.empty() ? sequence.folder.filename().string() : sequence.name);
  report.settings = DescribeSettings(options, sequence, site, context);
  if (board)
    report.settings.push_back("camera poses from the markers of " + options.markers.string());
  report.notes = site.notes;

  FileBlobStore store(options.cache);
  const PreparedScene scene = PrepareScene(
      site.model, PrepareOptionsFor(site, options.prepare), store, ProgressOnStandardError());
  WarnWhereNothingWasKept(store);
  report.notes.insert(report.notes.end(), scene.notes.begin(), scene.notes.end());
  for (const std::string& note : report.notes) spdlog::warn("{}", note);

  Compositor compositor;
  FramePipelineOptions pipeline_options;
  pipeline_options.object_light = options.object_light;
  // A source that samples the picture is worth receivers of its own for each new view; another one
  // is not.
  if (SourceOf(options, sequence) == SourceKind::kFisheye && (board || CameraMoves(sequence))) {
    pipeline_options.view.receivers_at = SurfaceViewOptions::ReceiversAt::kPatchCorners;
    pipeline_options.influence_at = InfluenceAt::kFaces;
  }
  pipeline_options.view.sun_block_px = options.sun_block_px;
  pipeline_options.effects = options.effects;
  if (options.influence_at) pipeline_options.influence_at = *options.influence_at;
  pipeline_options.daylight = DaylightOf(options, site);
  pipeline_options.direct_daylight = options.direct_daylight;
  for (const WindowEntry& window : sequence.windows) {
    pipeline_options.direct_daylight.windows.push_back({window.name, window.polygon_world_m});
  }
  if (!options.filter || !options.lighting.empty()) pipeline_options.filter.reset();
  FramePipeline pipeline(scene,
                         site.model.mesh,
                         sequence.site,
                         site.objects,
                         std::move(source),
                         compositor,
                         pipeline_options);
  if (!pipeline.DaylightNote().empty()) {
    report.notes.push_back(pipeline.DaylightNote());
    spdlog::info("{}", report.notes.back());
  }

  const std::map<int, glm::dvec3> given_suns = GivenSuns(options);
  std::optional<ShadowDirectionFinder> shadows;
  if (options.measure_shadows) shadows.emplace(site.model.mesh, site.model.diffuse_regions);

  RunFolder folder(options.out);
  FrameWriter writer(options.out, response);
  const auto frames = FramesOfRun(options, sequence, board, report);
  int done = 0;
  for (;;) {
    const auto read_start = std::chrono::steady_clock::now();
    auto frame = frames->Next();
    if (!frame) break;
    if (*frame) UseGivenSun(given_suns, **frame);
    const double read_ms = MsSince(read_start);
    tl::expected<FrameResult, FrameError> result =
        *frame ? pipeline.Process(**frame) : tl::unexpected((*frame).error());
    if (!result) {
      spdlog::error("frame {}: {}", result.error().index, result.error().reason);
      folder.AddLine(FailureLine(result.error()));
      report.frames.push_back(FailedFrame(result.error()));
      if (options.stop_on_bad_frame) {
        throw std::runtime_error(
            fmt::format("stopped at frame {}, as asked", result.error().index));
      }
      continue;
    }
    const auto write_start = std::chrono::steady_clock::now();
    const Rgb8Image shown = writer.Write(**frame, result->composite);
    result->timing_ms.read = read_ms;
    result->timing_ms.write = MsSince(write_start);
    folder.AddLine(LightingLine(**frame, *result));

    ReportFrame reported;
    reported.index = (*frame)->index;
    reported.time = (*frame)->time;
    reported.input =
        MakeReportPicture((*frame)->codes ? *(*frame)->codes
                                          : writer.Display((*frame)->radiance, (*frame)->exposure));
    reported.composite = MakeReportPicture(shown);
    reported.lighting = result->estimate.lighting;
    reported.estimate = result->estimate;
    reported.timing_ms = result->timing_ms;
    NoteUnits(result->estimate.units, report);
    if (shadows) shadows->Add(**frame, result->sun.direction_enu);
    report.frames.push_back(std::move(reported));
    ++done;
    const glm::dvec3 sun = result->estimate.lighting.sun.irradiance_rgb;
    const glm::dvec3 sky = result->estimate.lighting.SkyIrradianceRgb();
    spdlog::info("frame {} of {}: sun {:.4g}, sky {:.4g}{}",
                 (*frame)->index + 1,
                 frames->Count().value_or(0),
                 (sun.x + sun.y + sun.z) / 3.0,
                 (sky.x + sky.y + sky.z) / 3.0,
                 result->estimate.sun_observable ? "" : " (sun not observable)");
  }
  folder.Finish();
  if (shadows && done > 0) ReportShadows(*shadows, report);
  AddTruth(sequence, writer, report);
  WriteRunReport(options.out / "report.html", report);
  spdlog::info("{} of {} frames done; report: {}",
               done,
               report.frames.size(),
               (options.out / "report.html").string());
  if (done == 0)
    throw std::runtime_error("no frame of " + sequence.folder.string() + " could be done");
}

}  // namespace pleinair
