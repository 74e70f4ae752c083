// What can be asked of a session; a default-constructed one is an ordinary run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "calib/camera_noise.h"
#include "calib/response.h"
#include "datasets/frame_source.h"
#include "estimation/lighting_fit_options.h"
#include "estimation/outdoor_lighting_source.h"
#include "pipeline/frame_pipeline.h"
#include "relight/blob_store.h"
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
  std::optional<ResponseCurve> response;  // Of the 8-bit camera; none: the sequence's.
  std::filesystem::path markers;  // Board file that camera poses come from; empty: the sequence's.
  std::optional<SourceKind> source;  // None: fish-eye where frames have such a picture.
  // A lighting.jsonl to use instead of estimating; empty: estimate.
  std::filesystem::path lighting;
  std::optional<AlbedoSource> albedo;  // None: as AlbedoSourceOf has it.
  // What an outdoor sky is a mix of.
  std::vector<SkyShapeKind> sky_shapes = OutdoorLightingOptions{}.sky_shapes;
  // That a fish-eye's sky is averaged over before it lights the scene. None: its picture lights it.
  std::optional<SkyRegions> sky_regions;
  int samples = 500;
  std::uint64_t seed = 1;
  SampleChoice sample_choice = SampleChoice::kBalanced;
  LightingFitOptions::Loss loss = LightingFitOptions::Loss::kTukey;
  LightingFitOptions::Solver solver = LightingFitOptions::Solver::kCeres;
  PrepareSettings prepare;
  ObjectLight object_light = ObjectLight::kGather;
  int object_rays = GatherOptions{}.rays_per_receiver;  // At their vertices.
  std::uint64_t object_ray_seed = GatherOptions{}.seed;
  OnePlaceOptions one_place;  // Its seed is object_ray_seed.
  // None: gathered, but for the irradiance volume indoors, which is too smooth for windows.
  std::optional<Daylight> daylight;
  DirectDaylightOptions direct_daylight;    // Its windows are the sequence's.
  std::optional<InfluenceAt> influence_at;  // None: faces where a fish-eye lights a moving camera.
  int sun_block_px = SurfaceViewOptions{}.sun_block_px;
  int receiver_block_px = SurfaceViewOptions{}.receiver_block_px;
  int object_samples_per_side = CompositorOptions{}.object_samples_per_side;
  EffectSettings effects;
  int penumbra_samples = SoftSunOptions{}.disc_samples;
  bool filter = true;  // The light over time.
  bool ignore_exposure = false;
  std::optional<Weather> weather;  // Of all frames, in place of what the sequence says.
  CameraNoise camera_noise;
  // That camera_noise is not the default but this camera's: virtual objects get it, too.
  bool camera_noise_is_known = false;
  bool with_objects = true;  // False: the light alone, composites are the frames.
};

}  // namespace pleinair
