#include "session/session_choices.h"

#include <algorithm>
#include <stdexcept>

#include "datasets/fisheye_setup.h"
#include "datasets/frame_source.h"
#include "estimation/fisheye_lighting_source.h"
#include "estimation/given_lighting_source.h"
#include "session/given_lighting.h"

namespace pleinair {
namespace {

bool CameraMoves(const Sequence& sequence) {
  for (std::size_t i = 1; i < sequence.frames.size(); ++i) {
    if (!(sequence.CameraOfFrame(i) == sequence.CameraOfFrame(0))) return true;
  }
  return false;
}

OutdoorLightingOptions OutdoorOptionsFor(const SessionOptions& options,
                                         double aerosol_optical_depth_500nm) {
  OutdoorLightingOptions outdoor = options.light;
  outdoor.aerosol_optical_depth_500nm = aerosol_optical_depth_500nm;
  return outdoor;
}

}  // namespace

void SetSeed(std::uint64_t seed, SessionOptions& options) {
  options.light.seed = seed;
  options.pipeline.object_light.gather.seed = seed;
  options.pipeline.object_light.single_probe.seed = seed;
  options.pipeline.object_light.direct_daylight.sampling.seed = seed;
}

ResponseCurve ResponseOf(const SessionOptions& options, const Sequence& sequence) {
  return options.response ? *options.response : ResponseOf(sequence);
}

SourceKind SourceOf(const SessionOptions& options, const Sequence& sequence) {
  return options.source.value_or(HasFisheyePictures(sequence) ? SourceKind::kFisheye
                                                              : SourceKind::kOutdoor);
}

AlbedoSource AlbedoSourceOf(const SessionOptions& options, const Sequence& sequence) {
  if (options.albedo) return *options.albedo;
  if (sequence.environment) return AlbedoSource::kSurvey;
  const bool estimated =
      SourceOf(options, sequence) == SourceKind::kOutdoor && options.lighting.empty();
  const bool is_given =
      sequence.albedos_known || sequence.albedos_assumed || !sequence.HasPictures();
  return is_given || !estimated ? AlbedoSource::kMaterials : AlbedoSource::kSelfCalibrated;
}

Daylight DaylightOf(const SessionOptions& options, const SequenceSite& site) {
  const ObjectLight light = options.pipeline.object_light.route;
  const bool smooth = light == ObjectLight::kVolume || light == ObjectLight::kVolumeByMap;
  return options.daylight.value_or(site.is_indoors && smooth ? Daylight::kSamples
                                                             : Daylight::kGather);
}

std::unique_ptr<LightingSource> MakeSourceFor(const SessionOptions& options,
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
      throw std::runtime_error(sequence.file.string() +
                               ": source fisheye: expected the key fisheye, and frames that name "
                               "a fish-eye picture");
    }
    FisheyeLightingOptions fisheye;
    fisheye.samples = options.light.samples;
    fisheye.seed = options.light.seed;
    if (options.sky_regions) {
      fisheye.regions = *options.sky_regions;
      fisheye.detail = SkyDetail::kRegions;
    }
    return MakeFisheyeLightingSource(MakeFisheyeSetup(*sequence.fisheye, sequence.folder).camera,
                                     fisheye);
  }
  return MakeOutdoorLightingSource(OutdoorOptionsFor(options, aerosol_optical_depth_500nm));
}

FramePipelineOptions PipelineOptionsFor(const SessionOptions& options,
                                        const LoadedSequence& loaded) {
  const Sequence& sequence = loaded.sequence;
  FramePipelineOptions pipeline = options.pipeline;
  if (options.camera_moves || loaded.board || loaded.poses || CameraMoves(sequence)) {
    pipeline.view.receivers_at = SurfaceViewOptions::ReceiversAt::kSurfaces;
    pipeline.influence_at = InfluenceAt::kFaces;
  }
  if (options.camera_noise_is_known) pipeline.camera_matching.camera_noise = options.camera_noise;
  pipeline.display_response = ResponseOf(options, sequence);
  if (SourceOf(options, sequence) != SourceKind::kOutdoor) pipeline.daylight_colours = false;
  if (options.receivers_at) pipeline.view.receivers_at = *options.receivers_at;
  if (options.influence_at) pipeline.influence_at = *options.influence_at;
  if (options.light_in_steps) pipeline.light_in_steps = *options.light_in_steps;
  pipeline.object_light.daylight = DaylightOf(options, loaded.site);
  for (const WindowEntry& window : sequence.windows) {
    pipeline.object_light.direct_daylight.windows.push_back({window.name, window.polygon_world_m});
  }
  if (!options.lighting.empty()) pipeline.filter.reset();
  return pipeline;
}

}  // namespace pleinair
