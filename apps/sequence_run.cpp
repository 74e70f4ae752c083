#include "apps/sequence_run.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/elapsed.h"
#include "apps/file_blob_store.h"
#include "apps/given_lighting.h"
#include "datasets/fisheye_setup.h"
#include "datasets/marker_frame_source.h"
#include "estimation/fisheye_lighting_source.h"
#include "pipeline/north_correction.h"
#include "pipeline/self_calibration.h"
#include "scene/mesh_io.h"
#include "sunmodel/angles.h"
#include "sunmodel/sky_shapes.h"

namespace pleinair {
namespace {

bool HasFisheyePictures(const Sequence& sequence) {
  return std::any_of(sequence.frames.begin(), sequence.frames.end(), [](const FrameEntry& frame) {
    return frame.fisheye.has_value();
  });
}

bool CameraMoves(const Sequence& sequence) {
  for (std::size_t i = 1; i < sequence.frames.size(); ++i) {
    if (!(sequence.CameraOfFrame(i) == sequence.CameraOfFrame(0))) return true;
  }
  return false;
}

// With --markers the sequence's own poses are not used, and may be absent.
Sequence ReadRunSequence(const SequenceRunOptions& options,
                         const std::optional<MarkerBoard>& board) {
  Sequence sequence =
      board ? WithFirstMarkerPose(
                  ReadSequence(options.sequence, SequencePoses::kMayBeAbsent, options.weather),
                  options.frames,
                  *board)
            : ReadSequence(options.sequence, SequencePoses::kRequired, options.weather);
  if (options.ignore_exposure) {
    for (FrameEntry& frame : sequence.frames) {
      frame.exposure.reset();
      frame.exposure_s.reset();
    }
  }
  return sequence;
}

std::unique_ptr<FrameSource> FramesOfRun(const SequenceRunOptions& options,
                                         const LoadedSequence& loaded,
                                         std::vector<std::string>& notes) {
  if (!loaded.board) {
    return MakeRecordedFrameSource(loaded.sequence, options.frames, options.camera_noise);
  }
  MarkerFrameOptions markers;
  markers.camera_noise = options.camera_noise;
  markers.on_frame = [&notes](const MarkerFrameReport& frame) {
    if (!frame.used || frame.used->origin == PoseOrigin::kFound) return;
    notes.push_back(fmt::format("frame {}: the camera pose of {} frame(s) before: {}",
                                frame.index,
                                frame.used->carried_frames,
                                frame.reason));
  };
  return MakeRecordedMarkerFrameSource(
      loaded.sequence, options.frames, *loaded.board, std::move(markers));
}

// Directions that --lighting gives, by frame.
std::map<int, glm::dvec3> GivenSuns(const SequenceRunOptions& options) {
  std::map<int, glm::dvec3> suns;
  if (options.lighting.empty()) return suns;
  for (const auto& [frame, light] : ReadGivenLighting(options.lighting)) {
    if (light.sun_direction_enu) suns.emplace(frame, *light.sun_direction_enu);
  }
  return suns;
}

void WarnWhereNothingWasKept(const FileBlobStore& store) {
  if (store.SaveFailure().empty()) return;
  spdlog::warn("the next run will prepare this site anew: {}", store.SaveFailure());
}

// As though it had no map; what the map says of the sun stays.
void LeaveOutEnvironment(Sequence& sequence) {
  if (!sequence.environment) return;
  sequence.sun_direction_enu = sequence.environment->sun_direction_enu;
  sequence.environment.reset();
}

// Where the model's orientation is said to be uncertain. Returns what was found, for the report.
std::string CorrectNorthOf(const SequenceRunOptions& options, LoadedSequence& loaded) {
  Sequence& sequence = loaded.sequence;
  if (!sequence.site || !(sequence.north_stddev_rad > 0.0)) return {};
  std::vector<std::string> unused_notes;
  const NorthCorrection north =
      CorrectNorth([&] { return FramesOfRun(options, loaded, unused_notes); },
                   *sequence.site,
                   LoadMesh(sequence.folder / sequence.scene_mesh).mesh,
                   sequence.diffuse_regions,
                   sequence.north_stddev_rad);
  if (!north.determined) {
    return fmt::format(
        "north: the shadows in {} frame(s) do not correct it: {}; it stays as stated, give or take "
        "{:.2f} deg",
        north.frames,
        north.reason,
        DegFromRad(north.stddev_rad));
  }
  sequence.site->model_north_azimuth_rad = north.north_azimuth_rad;
  return fmt::format(
      "north: the model's +Y is taken to point to true azimuth {:+.2f} deg (sigma {:.2f}); shadows "
      "in "
      "{} frame(s) say {:+.2f} (sigma {:.2f}), the sequence 0 (sigma {:.2f})",
      DegFromRad(north.north_azimuth_rad),
      DegFromRad(north.stddev_rad),
      north.frames,
      DegFromRad(north.shadows_azimuth_rad),
      DegFromRad(north.shadows_stddev_rad),
      DegFromRad(sequence.north_stddev_rad));
}

void CalibrateAlbedo(const SequenceRunOptions& options, LoadedSequence& loaded) {
  SelfCalibrationOptions calibration;
  calibration.seed = options.seed;
  calibration.sky_shapes = options.sky_shapes;
  calibration.joint.expected_stddev = loaded.site.model.material_albedo_stddev;
  // Ground and walls, from asphalt to bright plaster (Oke, Boundary Layer Climates, 1987,
  // table 8.1: 0.05 to 0.5). Kd that nobody has guessed says less.
  constexpr double kUsualAlbedo = 0.3;
  if (!loaded.site.albedo_is_a_guess && !loaded.sequence.albedos_known) {
    calibration.mean_albedo = kUsualAlbedo;
  }
  // Of the scale, where Kd is measured but asked to be found anew.
  constexpr double kKnownAlbedoStddev = 0.05;
  if (loaded.sequence.albedos_known) calibration.joint.expected_stddev = kKnownAlbedoStddev;
  std::vector<std::string> unused_notes;
  SelfCalibrateAlbedo([&] { return FramesOfRun(options, loaded, unused_notes); },
                      loaded.sequence.site,
                      calibration,
                      loaded.scene);
}

OutdoorLightingOptions OutdoorOptionsFor(const SequenceRunOptions& options,
                                         double aerosol_optical_depth_500nm) {
  OutdoorLightingOptions outdoor;
  outdoor.samples = options.samples;
  outdoor.seed = options.seed;
  outdoor.choice = options.sample_choice;
  outdoor.fit.loss = options.loss;
  outdoor.fit.solver = options.solver;
  outdoor.sky_shapes = options.sky_shapes;
  outdoor.aerosol_optical_depth_500nm = aerosol_optical_depth_500nm;
  return outdoor;
}

constexpr LatLongSize kSkyImageSize{768, 384};      // A pixel is 0.47 deg, as SkyTable's cells.
constexpr LatLongSize kEnvironmentSize{1024, 512};  // A pixel is 0.35 deg: less than the sun.

glm::vec3 EnvironmentPlace(const LoadedSequence& loaded, bool with_objects) {
  if (with_objects && !loaded.site.objects.empty()) {
    glm::vec3 lower(std::numeric_limits<float>::infinity());
    glm::vec3 upper(-lower);
    for (const VirtualObject& object : loaded.site.objects) {
      const BoundingBox box = BoundingBoxOf(object.mesh);
      lower = glm::min(lower, box.lower_m);
      upper = glm::max(upper, box.upper_m);
    }
    return 0.5f * (lower + upper);
  }
  if (loaded.sequence.environment) return glm::vec3(loaded.sequence.environment->position_m);
  const glm::dmat4 world_from_camera =
      glm::inverse(loaded.sequence.CameraOfFrame(0).camera_from_world);
  return glm::vec3(world_from_camera[3]);
}

}  // namespace

ResponseCurve ResponseOf(const Sequence& sequence) {
  return sequence.response_ldr == "srgb8"
             ? ResponseCurve::Srgb()
             : ResponseCurve::FromFile(sequence.folder / sequence.response_ldr);
}

SourceKind SourceOf(const SequenceRunOptions& options, const Sequence& sequence) {
  return options.source.value_or(HasFisheyePictures(sequence) ? SourceKind::kFisheye
                                                              : SourceKind::kOutdoor);
}

AlbedoSource AlbedoSourceOf(const SequenceRunOptions& options, const Sequence& sequence) {
  if (options.albedo) return *options.albedo;
  if (sequence.environment) return AlbedoSource::kSurvey;
  const bool estimated =
      SourceOf(options, sequence) == SourceKind::kOutdoor && options.lighting.empty();
  const bool told = sequence.albedos_known || sequence.albedos_assumed;
  return told || !estimated ? AlbedoSource::kMaterials : AlbedoSource::kSelfCalibrated;
}

Daylight DaylightOf(const SequenceRunOptions& options, const SequenceSite& site) {
  const bool smooth = options.object_light == ObjectLight::kVolume ||
                      options.object_light == ObjectLight::kVolumeByMap;
  return options.daylight.value_or(site.is_indoors && smooth ? Daylight::kSamples
                                                             : Daylight::kGather);
}

std::unique_ptr<LightingSource> MakeSourceFor(const SequenceRunOptions& options,
                                              const Sequence& sequence,
                                              double aerosol_optical_depth_500nm) {
  if (!options.lighting.empty()) {
    const OutdoorLightingOptions outdoor = OutdoorOptionsFor(options, aerosol_optical_depth_500nm);
    return MakeGivenLightingSource(ReadGivenLighting(options.lighting),
                                   MakeOutdoorLightingSource(outdoor),
                                   aerosol_optical_depth_500nm);
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
    if (options.sky_regions) {
      fisheye.regions = *options.sky_regions;
      fisheye.detail = SkyDetail::kRegions;
    }
    return MakeFisheyeLightingSource(MakeFisheyeSetup(*sequence.fisheye, sequence.folder).camera,
                                     fisheye);
  }
  return MakeOutdoorLightingSource(OutdoorOptionsFor(options, aerosol_optical_depth_500nm));
}

FramePipelineOptions PipelineOptionsFor(const SequenceRunOptions& options,
                                        const LoadedSequence& loaded) {
  const Sequence& sequence = loaded.sequence;
  FramePipelineOptions pipeline;
  pipeline.object_light = options.object_light;
  pipeline.object_gather.rays_per_receiver = options.object_rays;
  pipeline.one_place = options.one_place;
  pipeline.one_place.seed = options.object_ray_seed;
  pipeline.object_gather.seed = options.object_ray_seed;
  // A source that samples the picture is worth receivers of its own for each new view; another one
  // is not.
  if (SourceOf(options, sequence) == SourceKind::kFisheye &&
      (loaded.board || CameraMoves(sequence))) {
    pipeline.view.receivers_at = SurfaceViewOptions::ReceiversAt::kPatchCorners;
    pipeline.influence_at = InfluenceAt::kFaces;
  }
  pipeline.view.sun_block_px = options.sun_block_px;
  pipeline.view.receiver_block_px = options.receiver_block_px;
  pipeline.effects = options.effects;
  if (options.camera_noise_is_known) pipeline.camera_matching.camera_noise = options.camera_noise;
  pipeline.display_response = ResponseOf(sequence);
  pipeline.daylight_colours = SourceOf(options, sequence) == SourceKind::kOutdoor;
  pipeline.soft_sun.disc_samples = options.penumbra_samples;
  if (options.influence_at) pipeline.influence_at = *options.influence_at;
  pipeline.daylight = DaylightOf(options, loaded.site);
  pipeline.direct_daylight = options.direct_daylight;
  for (const WindowEntry& window : sequence.windows) {
    pipeline.direct_daylight.windows.push_back({window.name, window.polygon_world_m});
  }
  if (!options.filter || !options.lighting.empty()) pipeline.filter.reset();
  return pipeline;
}

std::shared_ptr<const LoadedSequence> LoadForRun(const SequenceRunOptions& options,
                                                 const Progress& progress) {
  auto loaded = std::make_shared<LoadedSequence>();
  if (!options.markers.empty()) loaded->board = ReadMarkerBoard(options.markers);
  loaded->sequence = ReadRunSequence(options, loaded->board);
  const std::vector<std::string> notes_on_sun = FindSunInMap(loaded->sequence);
  const AlbedoSource albedo = AlbedoSourceOf(options, loaded->sequence);
  if (albedo == AlbedoSource::kSurvey && !loaded->sequence.environment) {
    throw std::runtime_error((loaded->sequence.folder / "sequence.json").string() +
                             ": --albedo survey: expected the key environment, with an image");
  }
  if (albedo != AlbedoSource::kSurvey) LeaveOutEnvironment(loaded->sequence);
  const std::string note_on_north = CorrectNorthOf(options, *loaded);
  loaded->site = LoadSequenceSite(loaded->sequence);
  if (!note_on_north.empty()) loaded->site.notes.push_back(note_on_north);
  loaded->site.notes.insert(loaded->site.notes.end(), notes_on_sun.begin(), notes_on_sun.end());
  if (albedo == AlbedoSource::kMaterials && !loaded->site.materials_note.empty()) {
    loaded->site.notes.push_back(loaded->site.materials_note);
  }
  // A source that there are no data for is told before the work begins.
  MakeSourceFor(options, loaded->sequence, kStandardAerosolDepth500nm);
  FileBlobStore store(options.cache);
  loaded->scene = PrepareScene(
      loaded->site.model, PrepareOptionsFor(loaded->site, options.prepare), store, progress);
  WarnWhereNothingWasKept(store);
  if (albedo == AlbedoSource::kSelfCalibrated) CalibrateAlbedo(options, *loaded);
  return loaded;
}

SequenceRun::SequenceRun(std::shared_ptr<const LoadedSequence> loaded,
                         const SequenceRunOptions& options)
    : loaded_(std::move(loaded)),
      with_objects_(options.with_objects),
      notes_(loaded_->site.notes),
      given_suns_(GivenSuns(options)),
      compositor_({.object_samples_per_side = options.object_samples_per_side}) {
  const std::vector<std::string>& of_scene = loaded_->scene.notes;
  notes_.insert(notes_.end(), of_scene.begin(), of_scene.end());
  pipeline_ = std::make_unique<FramePipeline>(
      loaded_->scene,
      loaded_->site.model.mesh,
      loaded_->sequence.site,
      with_objects_ ? loaded_->site.objects : std::vector<VirtualObject>(),
      MakeSourceFor(options, loaded_->sequence, loaded_->scene.aerosol_optical_depth_500nm),
      compositor_,
      PipelineOptionsFor(options, *loaded_));
  frames_ = FramesOfRun(options, *loaded_, notes_);
}

SequenceRun::~SequenceRun() = default;

std::optional<RunStep> SequenceRun::Next() {
  return Next([](int) { return true; });
}

std::optional<RunStep> SequenceRun::Next(const std::function<bool(int)>& wanted) {
  for (;;) {
    const auto read_start = std::chrono::steady_clock::now();
    auto frame = frames_->Next();
    if (!frame) return std::nullopt;
    if (!wanted(*frame ? (*frame)->index : frame->error().index)) continue;
    if (!*frame) return RunStep{std::nullopt, tl::unexpected(frame->error())};
    const auto given = given_suns_.find((*frame)->index);
    if (given != given_suns_.end()) (*frame)->sun_direction_enu = given->second;
    const double read_ms = MsSince(read_start);
    RunStep step = Process(std::move(**frame));
    if (step.result) step.result->timing_ms.read = read_ms;
    return step;
  }
}

RunStep SequenceRun::Process(Frame frame) {
  RunStep step{std::move(frame), {}};
  step.result = pipeline_->Process(*step.frame, PosesAt(step.frame->time));
  return step;
}

SequenceRun::Environment SequenceRun::EnvironmentOf(const Lighting& lighting) {
  if (!environment_view_) {
    const PreparedScene& scene = loaded_->scene;
    environment_view_.emplace(scene.patches,
                              scene.survey ? &*scene.survey : nullptr,
                              EnvironmentPlace(*loaded_, with_objects_),
                              kEnvironmentSize);
  }
  Environment environment;
  environment.without_sun = pipeline_->EnvironmentRadiance(*environment_view_, lighting);
  environment.with_sun = environment.without_sun;
  environment_view_->AddSun(lighting.sun, environment.with_sun);
  return environment;
}

std::optional<RgbImage> SequenceRun::SkyImageOf(const Lighting& lighting) const {
  const auto is_known = [](const SkyComponent& component) {
    return std::any_of(std::begin(kAllSkyShapeKinds),
                       std::end(kAllSkyShapeKinds),
                       [&](SkyShapeKind kind) { return component.shape == NameOf(kind); });
  };
  if (std::all_of(lighting.sky.begin(), lighting.sky.end(), is_known)) return std::nullopt;
  return pipeline_->SkyRadiance(lighting, kSkyImageSize);
}

std::vector<glm::dmat4> SequenceRun::PosesAt(UtcTime time) const {
  if (!with_objects_) return {};
  return ObjectPosesAt(loaded_->site, SecondsSinceFirstFrame(loaded_->sequence, time));
}

}  // namespace pleinair
