// The options of a session; the defaults are an ordinary run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "calib/camera_noise.h"
#include "calib/pose_track.h"
#include "calib/response.h"
#include "datasets/frame_source.h"
#include "estimation/outdoor_lighting_source.h"
#include "pipeline/frame_pipeline.h"
#include "pipeline/self_calibration.h"
#include "relight/blob_store.h"
#include "render/compositor.h"
#include "scene/sky_regions.h"
#include "scene/weather.h"
#include "session/sequence_site.h"

namespace pleinair {

// The source that the light is measured from.
enum class SourceKind { kOutdoor, kFisheye };

// Where the albedo of real surfaces comes from.
enum class AlbedoSource {
  kSurvey,          // The environment map.
  kMaterials,       // The mesh's materials.
  kSelfCalibrated,  // Found together with the light of the sequence's frames.
};

// Options of SequenceSession and LoadSequence.
struct SessionOptions {
  std::filesystem::path sequence;
  std::filesystem::path cache;       // Folder of prepared parts; empty: the user's cache folder.
  std::shared_ptr<BlobStore> store;  // Replaces `cache` where set.
  FrameKind frames = FrameKind::kLinear;
  // For captured 8-bit pictures; none: the sequence's. The sequence's own frames keep theirs, so a
  // session with this option processes only captured pictures.
  std::optional<ResponseCurve> response;
  std::filesystem::path markers;  // Board file that camera poses come from; empty: none.
  // True: poses arrive while the camera streams, independent of the sequence.
  bool camera_moves = false;
  std::filesystem::path poses;  // File of lines with camera poses (pose_lines.h); empty: none.
  PoseTrackOptions pose_track;  // For `poses`, and for poses that arrive while a camera streams.
  double pose_wait_s = 0.05;    // Time that a camera's frame waits for the latter; 0 or more.
  // Corrects the pose of a fixed camera where the frames of the sequence contradict it.
  bool correct_pose = true;
  // Averages poses while the camera is at rest. None: only those that do not come from the
  // sequence.
  std::optional<bool> steady_poses;
  std::optional<SourceKind> source;  // None: fish-eye where frames have such a picture.
  // A lighting.jsonl to use instead of estimating; empty: estimate.
  std::filesystem::path lighting;
  std::optional<AlbedoSource> albedo;  // None: as AlbedoSourceOf.
  std::optional<Weather> weather;      // For all frames; replaces the sequence's.
  bool ignore_exposure = false;        // For 8-bit frames: light is then relative.
  CameraNoise camera_noise;
  // Whether camera_noise is this camera's and not the default: virtual objects then get it, too.
  bool camera_noise_is_known = false;
  // Regions that a fish-eye's sky is averaged over before it lights the scene. None: its picture
  // lights it.
  std::optional<SkyRegions> sky_regions;

  // Haze of the clear sky's shape: aerosol optical depth at 500 nm. None: the survey map's own, or
  // the standard clear day's. Not for a fish-eye, which sees the sky.
  std::optional<double> haze;
  OutdoorLightingOptions light;  // Without its haze. Samples and seed are also used for a fish-eye.
  SelfCalibrationOptions calibration;  // Its seed and sky shapes are those of `light`.
  PrepareSettings prepare;
  // PipelineOptionsFor sets what depends on the sequence: display, windows, camera noise, and the
  // kind of receivers.
  FramePipelineOptions pipeline;
  // Replaces the pipeline's. None: gathered, except for the irradiance volume indoors, which is too
  // smooth for windows.
  std::optional<Daylight> daylight;
  // Replace the pipeline's. None: on surfaces and faces where the camera moves.
  std::optional<SurfaceViewOptions::ReceiversAt> receivers_at;
  std::optional<InfluenceAt> influence_at;
  // Replaces the pipeline's. None: as set by the program that shows the frames.
  std::optional<bool> light_in_steps;
  CompositorOptions compositor;
  bool measure_shadows = false;  // Compares the real shadows' direction with the sun's.
  bool with_objects = true;      // False: only the light; composites are the frames.
};

// Seed of everything random.
void SetSeed(std::uint64_t seed, SessionOptions& options);

}  // namespace pleinair
