// What can be asked of a session; a default-constructed one is an ordinary run.
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

// What the light is measured from.
enum class SourceKind { kOutdoor, kFisheye };

// Where the albedo of real surfaces comes from.
enum class AlbedoSource {
  kSurvey,          // The environment map.
  kMaterials,       // The mesh's materials.
  kSelfCalibrated,  // Found together with the light of the sequence's frames.
};

struct SessionOptions {
  std::filesystem::path sequence;
  std::filesystem::path cache;       // Folder of what was prepared; empty: the user's cache folder.
  std::shared_ptr<BlobStore> store;  // In place of `cache`, where set.
  FrameKind frames = FrameKind::kLinear;
  // Of captured 8-bit pictures; none: the sequence's. The sequence's own frames keep theirs: a
  // session that has this takes captured pictures alone.
  std::optional<ResponseCurve> response;
  std::filesystem::path markers;  // Board file that camera poses come from; empty: none.
  bool camera_moves = false;      // Whatever the sequence says: its poses come as it streams.
  std::filesystem::path poses;    // File of lines with camera poses (pose_lines.h); empty: none.
  PoseTrackOptions pose_track;    // Of `poses`, and of those that come while a camera streams.
  double pose_wait_s = 0.05;      // That a camera's frame waits for the latter; 0 or more.
  // Steadies poses while the camera is at rest. None: where they do not come from the sequence.
  std::optional<bool> steady_poses;
  std::optional<SourceKind> source;  // None: fish-eye where frames have such a picture.
  // A lighting.jsonl to use instead of estimating; empty: estimate.
  std::filesystem::path lighting;
  std::optional<AlbedoSource> albedo;  // None: as AlbedoSourceOf has it.
  std::optional<Weather> weather;      // Of all frames, in place of what the sequence says.
  bool ignore_exposure = false;        // Of 8-bit frames: light is then relative.
  CameraNoise camera_noise;
  // That camera_noise is not the default but this camera's: virtual objects get it, too.
  bool camera_noise_is_known = false;
  // That a fish-eye's sky is averaged over before it lights the scene. None: its picture lights it.
  std::optional<SkyRegions> sky_regions;

  OutdoorLightingOptions
      light;  // Its haze is the survey's. Samples and seed are a fish-eye's, too.
  SelfCalibrationOptions calibration;  // Its seed and sky shapes are those of `light`.
  PrepareSettings prepare;
  // What a sequence decides is set by PipelineOptionsFor: display, windows, camera noise, and where
  // receivers are.
  FramePipelineOptions pipeline;
  // In place of the pipeline's. None: gathered, but for the irradiance volume indoors, which is too
  // smooth for windows.
  std::optional<Daylight> daylight;
  // In place of the pipeline's. None: on surfaces and faces where the camera moves.
  std::optional<SurfaceViewOptions::ReceiversAt> receivers_at;
  std::optional<InfluenceAt> influence_at;
  // In place of the pipeline's. None: as the program that shows the frames sets it.
  std::optional<bool> light_in_steps;
  CompositorOptions compositor;
  bool measure_shadows = false;  // Compares the real shadows' direction with the sun's.
  bool with_objects = true;      // False: the light alone, composites are the frames.
};

// Of all that is drawn at random.
void SetSeed(std::uint64_t seed, SessionOptions& options);

}  // namespace pleinair
