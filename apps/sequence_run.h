// A recorded sequence set up to be run, and done frame by frame: what `run`, `regress` and
// `tradeoff` share. Nothing is written but the cache.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>
#include <tl/expected.hpp>

#include "apps/sequence_site.h"
#include "calib/marker_board.h"
#include "datasets/frame_source.h"
#include "estimation/outdoor_lighting_source.h"
#include "pipeline/frame_pipeline.h"
#include "relight/progress.h"
#include "scene/sky_regions.h"
#include "scene/weather.h"

namespace pleinair {

// What the light is measured from.
enum class SourceKind { kOutdoor, kFisheye };

// Where the albedo of real surfaces comes from.
enum class AlbedoSource {
  kSurvey,          // The environment map.
  kMaterials,       // The mesh's materials.
  kSelfCalibrated,  // Found together with the light of the sequence's frames.
};

struct SequenceRunOptions {
  std::filesystem::path sequence;
  std::filesystem::path cache;  // Empty: the user's cache folder.
  FrameKind frames = FrameKind::kLinear;
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

SourceKind SourceOf(const SequenceRunOptions& options, const Sequence& sequence);
// The survey where there is one; else the materials where their albedo is known or assumed, or no
// light is estimated from them; else self-calibration.
AlbedoSource AlbedoSourceOf(const SequenceRunOptions& options, const Sequence& sequence);
Daylight DaylightOf(const SequenceRunOptions& options, const SequenceSite& site);

// The source that `options` asks for, or the sequence calls for. Throws std::runtime_error for one
// that the sequence has no data for.
std::unique_ptr<LightingSource> MakeSourceFor(const SequenceRunOptions& options,
                                              const Sequence& sequence,
                                              double aerosol_optical_depth_500nm);

// What runs of one sequence share while their offline settings are the same.
struct LoadedSequence {
  Sequence sequence;
  SequenceSite site;
  PreparedScene scene;
  std::optional<MarkerBoard> board;
};

// The 8-bit camera's. Throws as ResponseCurve::FromFile.
ResponseCurve ResponseOf(const Sequence& sequence);

// What `options` and the sequence call for.
FramePipelineOptions PipelineOptionsFor(const SequenceRunOptions& options,
                                        const LoadedSequence& loaded);

// Reads and prepares, or loads what is prepared; finds albedos from the frames where
// AlbedoSourceOf says so. Throws as ReadSequence, LoadSequenceSite and
// PrepareScene.
std::shared_ptr<const LoadedSequence> LoadForRun(const SequenceRunOptions& options,
                                                 const Progress& progress);

struct RunStep {
  std::optional<Frame> frame;  // None where it could not be read.
  tl::expected<FrameResult, FrameError> result;
};

// Needs a current GL context while it lives.
class SequenceRun {
 public:
  // Of loaded data only what `options` says of the offline part, markers and exposure has to agree.
  SequenceRun(std::shared_ptr<const LoadedSequence> loaded, const SequenceRunOptions& options);
  ~SequenceRun();

  // None at the end. Frames for which `wanted` is false are passed over.
  std::optional<RunStep> Next();
  std::optional<RunStep> Next(const std::function<bool(int)>& wanted);

  // Of a frame that is not the sequence's, or is so again, at the same place.
  RunStep Process(Frame frame);

  // What was assumed, mended or left out since the last call, marker poses included.
  std::vector<std::string> TakeNotes() { return std::exchange(notes_, {}); }
  // The real light where the objects are, or without any where the survey's map was taken, or the
  // first frame's camera. Lat-long, after a frame that succeeded, with its lighting; the second one
  // has the sun's disc in it.
  struct Environment {
    RgbImage without_sun;
    RgbImage with_sun;
  };
  Environment EnvironmentOf(const Lighting& lighting);
  // Lat-long, of the last frame that succeeded, where the names of its shapes do not tell its sky:
  // that was seen by a fish-eye camera, or given as a picture.
  std::optional<RgbImage> SkyImageOf(const Lighting& lighting) const;
  // See FramePipeline.
  std::string DaylightNote() const { return pipeline_->DaylightNote(); }

 private:
  std::vector<glm::dmat4> PosesAt(UtcTime time) const;

  std::shared_ptr<const LoadedSequence> loaded_;
  bool with_objects_;
  std::vector<std::string> notes_;
  std::map<int, glm::dvec3> given_suns_;  // Directions that a lighting file gives, by frame.
  std::optional<EnvironmentView> environment_view_;  // Made when first asked for.
  Compositor compositor_;
  std::unique_ptr<FramePipeline> pipeline_;
  std::unique_ptr<FrameSource> frames_;
};

}  // namespace pleinair
