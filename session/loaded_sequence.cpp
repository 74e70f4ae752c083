#include "session/loaded_sequence.h"

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "datasets/diffuse_mask.h"
#include "datasets/marker_frame_source.h"
#include "datasets/pose_lines.h"
#include "datasets/posed_frame_source.h"
#include "pipeline/north_correction.h"
#include "pipeline/self_calibration.h"
#include "scene/mesh_io.h"
#include "session/available_memory.h"
#include "session/corrected_pose.h"
#include "session/file_blob_store.h"
#include "session/map_north.h"
#include "session/session_choices.h"
#include "session/survey_map_file.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

// A camera pose for what has to know roughly where the camera is before the first frame is played:
// that of the first frame that has one.
Sequence WithFirstPose(Sequence sequence, const PoseTrack& poses) {
  std::string first_reason;
  for (const FrameEntry& frame : sequence.frames) {
    const auto pose = poses.At(frame.time);
    if (pose) {
      sequence.camera_from_world = pose->camera_from_world;
      for (FrameEntry& entry : sequence.frames) entry.camera_from_world.reset();
      return sequence;
    }
    if (first_reason.empty()) first_reason = pose.error();
  }
  throw std::runtime_error(
      sequence.file.string() +
      ": expected a frame at the time of a camera pose; the first frame: " + first_reason);
}

// With markers or poses from outside the sequence's own poses are not used, and may be absent.
Sequence ReadSequenceOf(const SessionOptions& options, const LoadedSequence& loaded) {
  const bool has_own = !loaded.board && !loaded.poses;
  Sequence sequence = ReadSequence(options.sequence,
                                   has_own ? SequencePoses::kRequired : SequencePoses::kMayBeAbsent,
                                   options.weather);
  if (loaded.board) {
    sequence = WithFirstMarkerPose(std::move(sequence), options.frames, *loaded.board);
  }
  if (loaded.poses) sequence = WithFirstPose(std::move(sequence), *loaded.poses);
  if (options.ignore_exposure) {
    for (FrameEntry& frame : sequence.frames) {
      frame.exposure.reset();
      frame.exposure_s.reset();
    }
  }
  return sequence;
}

// Removes the map and its mask from the sequence; the sun found in it stays.
void LeaveOutEnvironment(Sequence& sequence) {
  if (!sequence.environment) return;
  if (const auto mask = ReadDiffuseMask(sequence); mask && mask->is_over_map) {
    sequence.diffuse_mask.reset();
  }
  sequence.sun_direction_enu = sequence.environment->sun_direction_enu;
  sequence.environment.reset();
}

struct NorthEvidence {
  std::string from;
  double azimuth_rad = 0.0;
  double stddev_rad = 0.0;
};

std::string DescribeNorth(const Sequence& sequence,
                          double stated_stddev_rad,
                          const NorthEvidence& evidence) {
  return fmt::format(
      "north: the model's +Y is taken to point to true azimuth {:+.2f} deg (sigma {:.2f}); {} "
      "{:+.2f} (sigma {:.2f}), the sequence 0 (sigma {:.2f})",
      DegFromRad(sequence.site->model_north_azimuth_rad),
      DegFromRad(sequence.north_stddev_rad),
      evidence.from,
      DegFromRad(evidence.azimuth_rad),
      DegFromRad(evidence.stddev_rad),
      DegFromRad(stated_stddev_rad));
}

// Sets north by the sun in the map, and returns what that says; none where it contradicts the
// stated deviation.
std::optional<MapNorth> TakeNorthOfMap(Sequence& sequence) {
  const std::optional<MapNorth> map = NorthOfMap(sequence);
  if (!map) return std::nullopt;
  const auto north = WeighNorth(map->azimuth_rad, map->stddev_rad, sequence.north_stddev_rad);
  if (!north) return std::nullopt;
  sequence.site->model_north_azimuth_rad = north->azimuth_rad;
  sequence.north_stddev_rad = north->stddev_rad;
  return map;
}

// Corrects north where the model's orientation is stated as uncertain, by shadows in the frames or
// else by the sun in the map. Returns a note for the report.
std::string CorrectNorthOf(const SessionOptions& options, LoadedSequence& loaded) {
  Sequence& sequence = loaded.sequence;
  if (!sequence.site || !(sequence.north_stddev_rad > 0.0)) return {};
  const double stated_stddev_rad = sequence.north_stddev_rad;
  bool is_contradicted = false;
  std::string no_shadows = "no recorded frames show shadows";
  if (sequence.HasPictures()) {
    std::vector<std::string> unused_notes;
    const NorthCorrection north =
        CorrectNorth([&] { return FramesOf(options, loaded, unused_notes); },
                     *sequence.site,
                     LoadMesh(sequence.folder / sequence.scene_mesh).mesh,
                     sequence.diffuse_regions,
                     stated_stddev_rad);
    if (north.determined) {
      sequence.site->model_north_azimuth_rad = north.north_azimuth_rad;
      sequence.north_stddev_rad = north.stddev_rad;
      return DescribeNorth(sequence,
                           stated_stddev_rad,
                           {fmt::format("shadows in {} frame(s) say", north.frames),
                            north.shadows_azimuth_rad,
                            north.shadows_stddev_rad});
    }
    no_shadows =
        fmt::format("the shadows in {} frame(s) do not correct it: {}", north.frames, north.reason);
  }
  const auto map = is_contradicted ? std::nullopt : TakeNorthOfMap(sequence);
  if (map) {
    return DescribeNorth(sequence,
                         stated_stddev_rad,
                         {"the map's own sun says", map->azimuth_rad, map->stddev_rad}) +
           "; " + no_shadows;
  }
  return fmt::format(
      "north: {}; it stays as stated, +/- {:.2f} deg", no_shadows, DegFromRad(stated_stddev_rad));
}

void CalibrateAlbedo(const SessionOptions& options, LoadedSequence& loaded) {
  SelfCalibrationOptions calibration = options.calibration;
  calibration.seed = options.light.seed;
  calibration.sky_shapes = options.light.sky_shapes;
  calibration.joint.expected_stddev = loaded.site.model.material_albedo_stddev;
  // Ground and walls, from asphalt to bright plaster (Oke, Boundary Layer Climates, 1987,
  // table 8.1: 0.05 to 0.5). A default Kd is less accurate.
  constexpr double kUsualAlbedo = 0.3;
  if (!loaded.site.albedo_is_a_guess && !loaded.sequence.albedos_known) {
    calibration.mean_albedo = kUsualAlbedo;
  }
  // Deviation of the scale, where Kd is measured but to be found again.
  constexpr double kKnownAlbedoStddev = 0.05;
  if (loaded.sequence.albedos_known) calibration.joint.expected_stddev = kKnownAlbedoStddev;
  std::vector<std::string> unused_notes;
  SelfCalibrateAlbedo([&] { return FramesOf(options, loaded, unused_notes); },
                      loaded.sequence.site,
                      calibration,
                      loaded.scene);
}

void Prepare(const SessionOptions& options, const Progress& progress, LoadedSequence& loaded) {
  const PrepareOptions prepare = PrepareOptionsFor(loaded.site, options.prepare);
  if (options.store) {
    loaded.scene = PrepareScene(loaded.site.model, prepare, *options.store, progress);
  } else {
    FileBlobStore files(options.cache);
    loaded.scene = PrepareScene(loaded.site.model, prepare, files, progress);
    if (!files.SaveFailure().empty()) {
      loaded.site.notes.push_back("this site will be prepared again by the next run: " +
                                  files.SaveFailure());
    }
  }
  if (!options.haze) return;
  loaded.scene.aerosol_optical_depth_500nm = *options.haze;
  loaded.site.notes.push_back(fmt::format(
      "clear skies are bright around the sun by the stated haze: {:.2f} at 500 nm", *options.haze));
}

// Throws std::runtime_error where a frame's pictures, transport and composite do not fit. A note
// for the report where they take much.
std::string NoteMemoryOf(const Sequence& sequence) {
  // Measured on frames of 0.2 to 48 million pixels.
  constexpr double kBytesPerPixel = 260.0;
  constexpr double kWorthANoteBytes = 2e9;
  const CameraIntrinsics& camera = sequence.intrinsics;
  const double bytes = kBytesPerPixel * camera.width_px * camera.height_px;
  const std::string frames =
      fmt::format("frames of {}x{} pixels", camera.width_px, camera.height_px);
  RequireMemory(static_cast<std::size_t>(bytes),
                (sequence.file.string() + ": " + frames).c_str(),
                "expected smaller ones");
  return bytes > kWorthANoteBytes
             ? fmt::format("{} need some {:.1f} GB of memory", frames, bytes / 1e9)
             : std::string();
}

void Load(const SessionOptions& options, const Progress& progress, LoadedSequence& loaded) {
  const std::string note_on_memory = NoteMemoryOf(loaded.sequence);
  const std::vector<std::string> notes_on_sun = FindSunInMap(loaded.sequence);
  const AlbedoSource albedo = AlbedoSourceOf(options, loaded.sequence);
  if (albedo == AlbedoSource::kSurvey && !loaded.sequence.environment) {
    throw std::runtime_error(loaded.sequence.file.string() +
                             ": albedo survey: expected the key environment, with an image");
  }
  if (albedo != AlbedoSource::kSurvey) LeaveOutEnvironment(loaded.sequence);
  const std::string note_on_north = CorrectNorthOf(options, loaded);
  loaded.site = LoadSequenceSite(loaded.sequence);
  for (const SiteWarning& warning : loaded.site.warnings) {
    loaded.site.notes.push_back(InOneLine(warning));
  }
  // After what the stated pose decides (where patches are finest), so that prepared parts are the
  // same with and without it. North's search over degrees does not need it.
  const bool is_tracked = loaded.board || loaded.poses;
  const std::string note_on_pose =
      is_tracked ? std::string() : CorrectPose(options, loaded.site.model.mesh, loaded.sequence);
  if (!note_on_memory.empty()) loaded.site.notes.push_back(note_on_memory);
  if (!note_on_pose.empty()) loaded.site.notes.push_back(note_on_pose);
  if (!note_on_north.empty()) loaded.site.notes.push_back(note_on_north);
  loaded.site.notes.insert(loaded.site.notes.end(), notes_on_sun.begin(), notes_on_sun.end());
  if (albedo == AlbedoSource::kMaterials && !loaded.site.materials_note.empty()) {
    loaded.site.notes.push_back(loaded.site.materials_note);
  }
  // A source that there are no data for is refused before the work begins.
  MakeSourceFor(options, loaded.sequence, kStandardAerosolDepth500nm);
  Prepare(options, progress, loaded);
  if (albedo == AlbedoSource::kSelfCalibrated) CalibrateAlbedo(options, loaded);
}

std::shared_ptr<LoadedSequence> WithOutsidePoses(const SessionOptions& options,
                                                 std::optional<PoseTrack> poses) {
  if (!options.markers.empty() && !options.poses.empty()) {
    throw std::invalid_argument("markers and poses exclude each other: expected one of them");
  }
  auto loaded = std::make_shared<LoadedSequence>();
  if (!options.markers.empty()) loaded->board = ReadMarkerBoard(options.markers);
  if (poses) {
    poses->SetOptions(options.pose_track);
    loaded->poses = std::move(poses);
  } else if (!options.poses.empty()) {
    loaded->poses = ReadPoses(options.poses, options.pose_track);
  }
  return loaded;
}

}  // namespace

std::unique_ptr<FrameSource> WithPoses(std::unique_ptr<FrameSource> frames,
                                       const SessionOptions& options,
                                       const LoadedSequence& loaded,
                                       const PoseNote& note,
                                       PoseAtTime live) {
  if (!live && loaded.poses) {
    live = [poses = *loaded.poses](UtcTime time) { return poses.At(time); };
  }
  const bool are_from_elsewhere = loaded.board || live;
  if (loaded.board) {
    MarkerFrameOptions markers;
    markers.on_frame = [note](const MarkerFrameReport& frame) {
      if (!frame.used || frame.used->origin == PoseOrigin::kFound) return;
      note(fmt::format("frame {}: the camera pose of {} frame(s) before: {}",
                       frame.index,
                       frame.used->carried_frames,
                       frame.reason));
    };
    frames = MakeMarkerFrameSource(std::move(frames), *loaded.board, std::move(markers));
  } else if (live) {
    frames = MakePosedFrameSource(
        std::move(frames), std::move(live), [note](const Frame& frame, double held_s) {
          note(fmt::format(
              "frame {}: the camera pose of {:.3f} s away: none is nearer", frame.index, held_s));
        });
  }
  if (!options.steady_poses.value_or(are_from_elsewhere)) return frames;
  return MakeSteadyFrameSource(std::move(frames));
}

std::unique_ptr<FrameSource> FramesOf(const SessionOptions& options,
                                      const LoadedSequence& loaded,
                                      std::vector<std::string>& notes) {
  const bool has_own = !loaded.board && !loaded.poses;
  return WithPoses(
      MakeRecordedFrameSource(has_own ? loaded.sequence : WithoutPoses(loaded.sequence),
                              options.frames,
                              options.camera_noise),
      options,
      loaded,
      [&notes](const std::string& line) { notes.push_back(line); });
}

std::shared_ptr<const LoadedSequence> LoadSequence(const SessionOptions& options,
                                                   const Progress& progress,
                                                   std::optional<PoseTrack> poses) {
  auto loaded = WithOutsidePoses(options, std::move(poses));
  loaded->sequence = ReadSequenceOf(options, *loaded);
  Load(options, progress, *loaded);
  return loaded;
}

std::shared_ptr<const LoadedSequence> LoadSite(const SessionOptions& options,
                                               UtcTime time,
                                               const Progress& progress,
                                               std::optional<PoseTrack> poses) {
  auto loaded = WithOutsidePoses(options, std::move(poses));
  loaded->sequence = ReadSite(options.sequence, time, SequencePoses::kRequired, options.weather);
  Load(options, progress, *loaded);
  return loaded;
}

}  // namespace pleinair
