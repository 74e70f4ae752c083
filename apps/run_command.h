// `pleinair run` and `pleinair prepare`: the work behind the arguments.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/sequence_site.h"
#include "datasets/frame_source.h"
#include "estimation/outdoor_lighting_source.h"
#include "pipeline/frame_pipeline.h"

namespace pleinair {

struct PrepareCommandOptions {
  std::filesystem::path sequence;
  std::filesystem::path cache;  // Empty: the user's cache folder.
  PrepareSettings prepare;
  std::optional<std::filesystem::path> maps;  // Where to write the survey's maps.
};

// What the light is measured from.
enum class SourceKind { kOutdoor, kFisheye };

struct RunCommandOptions {
  std::filesystem::path sequence;
  std::filesystem::path out;
  std::filesystem::path cache;  // Empty: the user's cache folder.
  FrameKind frames = FrameKind::kLinear;
  std::filesystem::path markers;  // Board file that camera poses come from; empty: the sequence's.
  std::optional<SourceKind> source;  // None: fish-eye where frames have such a picture.
  // A lighting.jsonl to use instead of estimating; empty: estimate.
  std::filesystem::path lighting;
  // What an outdoor sky is a mix of.
  std::vector<SkyShapeKind> sky_shapes = OutdoorLightingOptions{}.sky_shapes;
  int samples = 500;
  std::uint64_t seed = 1;
  PrepareSettings prepare;
  ObjectLight object_light = ObjectLight::kGather;
  // None: gathered, but for the irradiance volume indoors, which is too smooth for windows.
  std::optional<Daylight> daylight;
  DirectDaylightOptions direct_daylight;    // Its windows are the sequence's.
  std::optional<InfluenceAt> influence_at;  // None: faces where a fish-eye lights a moving camera.
  int sun_block_px = SurfaceViewOptions{}.sun_block_px;
  CompositeEffects effects;
  bool filter = true;  // The light over time.
  bool ignore_exposure = false;
  CameraNoise camera_noise;
  bool measure_shadows = false;
  bool stop_on_bad_frame = false;
};

// The source that `options` asks for, or the sequence calls for. Throws std::runtime_error for one
// that the sequence has no data for.
std::unique_ptr<LightingSource> MakeSourceFor(const RunCommandOptions& options,
                                              const Sequence& sequence);

// Throw std::runtime_error or std::invalid_argument, one line. Progress goes to the log.
void RunPrepareCommand(const PrepareCommandOptions& options);
void RunRunCommand(const RunCommandOptions& options);

}  // namespace pleinair
