#include "session/internal/settings_table.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "session/internal/setting_kinds.h"

namespace pleinair::internal {
namespace {

Setting SkyRegionsSetting() {
  Setting setting{"sky_regions",
                  "regions of elevation and azimuth that a fish-eye's sky is averaged over before "
                  "it lights the scene",
                  "BANDSxSECTORS, or picture",
                  "picture",
                  {}};
  setting.set = [setting](const std::string& text, Options& options) {
    if (text == "picture") return options.sky_regions.reset();
    constexpr int kMost = 1024;
    const auto counts = ParseCounts<2>(text, kMost);
    if (!counts) Refuse(setting, text);
    options.sky_regions.emplace((*counts)[0], (*counts)[1]);
  };
  return setting;
}

Setting SkyShapesSetting() {
  std::vector<std::string_view> names;
  for (const SkyShapeKind kind : kAllSkyShapeKinds) names.push_back(NameOf(kind));
  Setting setting{"light.sky_shapes",
                  "what an outdoor sky is a mix of; jensen-2006 has uniform alone",
                  fmt::format("some of {}, with commas between them", fmt::join(names, ", ")),
                  fmt::format("{}", fmt::join(names, ",")),
                  {}};
  setting.set = [setting](const std::string& text, Options& options) {
    std::vector<SkyShapeKind> shapes;
    for (std::size_t from = 0; from <= text.size();) {
      const std::size_t end = std::min(text.find(',', from), text.size());
      const std::string_view name = std::string_view(text).substr(from, end - from);
      const auto* found = std::find_if(std::begin(kAllSkyShapeKinds),
                                       std::end(kAllSkyShapeKinds),
                                       [&](SkyShapeKind kind) { return name == NameOf(kind); });
      const bool is_new = found != std::end(kAllSkyShapeKinds) &&
                          std::find(shapes.begin(), shapes.end(), *found) == shapes.end();
      if (!is_new) Refuse(setting, text);
      shapes.push_back(*found);
      from = end + 1;
    }
    options.light.sky_shapes = std::move(shapes);
  };
  return setting;
}

Setting BouncesSetting() {
  constexpr int kMost = 100;
  Setting setting{"prepare.bounces",
                  "reflections between surfaces; jensen-2006 has 0",
                  fmt::format("0 to {}, or all", kMost),
                  "all",
                  {}};
  setting.set = [setting](const std::string& text, Options& options) {
    const auto bounces = text == "all" ? std::optional(kAllBounces) : ParseNumber<int>(text);
    const bool is_known = bounces && (text == "all" || (*bounces >= 0 && *bounces <= kMost));
    if (!is_known) Refuse(setting, text);
    options.prepare.bounces = *bounces;
  };
  return setting;
}

Setting ProbeCountsSetting() {
  Setting setting{
      "prepare.probe_counts", "grid of the irradiance volume", "XxYxZ, up to 64 each", "8x8x8", {}};
  setting.set = [setting](const std::string& text, Options& options) {
    constexpr int kMost = 64;
    const auto counts = ParseCounts<3>(text, kMost);
    if (!counts) Refuse(setting, text);
    options.prepare.probe_counts = glm::ivec3((*counts)[0], (*counts)[1], (*counts)[2]);
  };
  return setting;
}

Setting FilterSetting() {
  Setting setting{"pipeline.filter",
                  "averages the light over frames while it is steady",
                  "on or off",
                  "on",
                  {}};
  setting.set = [setting](const std::string& text, Options& options) {
    if (text != "on" && text != "off") Refuse(setting, text);
    options.pipeline.filter = text == "on" ? std::optional(LightingFilterOptions{}) : std::nullopt;
  };
  return setting;
}

void AddInput(std::vector<Setting>& settings) {
  settings.push_back(ChoiceSetting("frames",
                                   "which frames where there are both",
                                   [](Options & o) -> auto& { return o.frames; },
                                   {{"linear", FrameKind::kLinear}, {"ldr", FrameKind::kLdr}}));
  settings.push_back(ChoiceSetting(
      "source",
      "what the light is measured from: diffuse walls and paving, or a "
      "fish-eye picture of the sky",
      [](Options & o) -> auto& { return o.source; },
      {{"outdoor", SourceKind::kOutdoor}, {"fisheye", SourceKind::kFisheye}},
      "fisheye where frames have such a picture"));
  settings.push_back(ChoiceSetting(
      "albedo",
      "albedo of real surfaces: from the environment map, the mesh's "
      "materials, or the frames themselves",
      [](Options & o) -> auto& { return o.albedo; },
      {{"survey", AlbedoSource::kSurvey},
       {"materials", AlbedoSource::kMaterials},
       {"self-calibrated", AlbedoSource::kSelfCalibrated}},
      "survey where there is a map; else materials where their albedo "
      "is known or assumed; else self-calibrated"));
  settings.push_back(ChoiceSetting(
      "weather",
      "the sky in all frames, as a person saw it",
      [](Options & o) -> auto& { return o.weather; },
      {{std::string(NameOf(Weather::kOvercast)), Weather::kOvercast},
       {std::string(NameOf(Weather::kBroken)), Weather::kBroken},
       {std::string(NameOf(Weather::kClear)), Weather::kClear}},
      "as the sequence says"));
  settings.push_back(SwitchSetting(
      "correct_pose",
      "moves a fixed camera's stated pose where the mesh's edges in the sequence's frames "
      "contradict it",
      [](Options & o) -> auto& { return o.correct_pose; }));
  settings.push_back(ChoiceSetting(
      "steady_poses",
      "averages the camera's poses while it is at rest",
      [](Options & o) -> auto& { return o.steady_poses; },
      {{"on", true}, {"off", false}},
      "on for poses from markers or from outside, off for the sequence's own"));
  settings.push_back(NumberSetting(
      "pose_track.most_gap_s",
      "time between two poses from outside that a frame's is found between",
      From(0.0, "seconds"),
      [](Options & o) -> auto& { return o.pose_track.most_gap_s; }));
  settings.push_back(NumberSetting(
      "pose_track.hold_s",
      "time that a pose from outside stands for frames without one",
      From(0.0, "seconds"),
      [](Options & o) -> auto& { return o.pose_track.hold_s; }));
  settings.push_back(NumberSetting(
      "pose_wait_s",
      "time that a camera's frame waits for a pose from outside",
      From(0.0, "seconds"),
      [](Options & o) -> auto& { return o.pose_wait_s; }));
  settings.push_back(SwitchSetting(
      "ignore_exposure",
      "treats the exposure of 8-bit frames as unknown: light is then "
      "relative",
      [](Options & o) -> auto& { return o.ignore_exposure; }));
  settings.push_back(NoiseSetting(
      "camera_noise.full_well_electrons",
      "brightest signal of the 8-bit camera, for its shot noise; where "
      "it is given, objects have this noise and not the measured one",
      [](Options & o) -> auto& { return o.camera_noise.full_well_electrons; }));
  settings.push_back(NoiseSetting(
      "camera_noise.read_noise_electrons", "read noise of the 8-bit camera; as above", [
      ](Options & o) -> auto& { return o.camera_noise.read_noise_electrons; }));
  settings.push_back(NumberSetting(
      "pipeline.motion_blur.exposure_s",
      "how long the shutter is open in frames that do not state it; 0: they "
      "are not blurred by motion",
      Between(0.0, 60.0, "seconds"),
      [](Options & o) -> auto& { return o.pipeline.motion_blur.exposure_s; }));
  settings.push_back(NumberSetting(
      "pipeline.motion_blur.readout_s",
      "rolling shutter: time from the first row's exposure to the last one's",
      Between(0.0, 60.0, "seconds"),
      [](Options & o) -> auto& { return o.pipeline.motion_blur.readout_s; }));
  settings.push_back(SkyRegionsSetting());
}

void AddLight(std::vector<Setting>& settings) {
  using Loss = LightingFitOptions::Loss;
  using Solver = LightingFitOptions::Solver;
  settings.push_back(NumberSetting(
      "light.samples", "pixels that the light is measured from", Between(1, 100000), [
      ](Options & o) -> auto& { return o.light.samples; }));
  settings.push_back(NumberSetting(
      "light.seed", "seed of the choice of pixels", From<std::uint64_t>(0), [
      ](Options & o) -> auto& { return o.light.seed; }));
  settings.push_back(ChoiceSetting("light.choice",
                                   "which pixels: as many lit as shaded of each region and facing, "
                                   "evenly over the view, or at random",
                                   [](Options & o) -> auto& { return o.light.choice; },
                                   {{"balanced", SampleChoice::kBalanced},
                                    {"proportional", SampleChoice::kProportional},
                                    {"random", SampleChoice::kRandom}}));
  settings.push_back(ChoiceSetting(
      "light.fit.loss",
      "what a sample far from the model counts: nothing, less, or as "
      "much as any",
      [](Options & o) -> auto& { return o.light.fit.loss; },
      {{"tukey", Loss::kTukey}, {"huber", Loss::kHuber}, {"squares", Loss::kSquares}}));
  settings.push_back(ChoiceSetting("light.fit.solver",
                                   "solver of the fit; closed is an independent check",
                                   [](Options & o) -> auto& { return o.light.fit.solver; },
                                   {{"ceres", Solver::kCeres}, {"closed", Solver::kClosed}}));
  settings.push_back(SkyShapesSetting());
  settings.push_back(NumberSetting(
      "haze",
      "how much brighter a clear sky is around the sun: its aerosol optical depth at 500 nm",
      Between(0.0, 5.0),
      [](Options & o) -> auto& { return o.haze; },
      "the survey map's own, else 0.084"));
  settings.push_back(FilterSetting());
  settings.push_back(NumberSetting(
      "calibration.frames", "frames that self-calibration takes albedos from", Between(1, 100000), [
      ](Options & o) -> auto& { return o.calibration.frames; }));
  settings.push_back(NumberSetting(
      "calibration.samples", "samples of each of these frames", Between(1, 100000), [
      ](Options & o) -> auto& { return o.calibration.samples; }));
  settings.push_back(NumberSetting(
      "calibration.rounds",
      "times that self-calibration recomputes the light between "
      "surfaces",
      Between(1, 100),
      [](Options & o) -> auto& { return o.calibration.rounds; }));
}

void AddPrepare(std::vector<Setting>& settings) {
  settings.push_back(BouncesSetting());
  settings.push_back(NumberSetting(
      "prepare.patch_size_m",
      "longest edge of patches near what the cameras look at",
      Above(0.0, "metres"),
      [](Options & o) -> auto& { return o.prepare.patch_size_m; },
      "0.5, indoors 0.25"));
  settings.push_back(NumberSetting(
      "prepare.rays",
      "rays that each receiver of light casts",
      Between(16, 65536),
      [](Options & o) -> auto& { return o.prepare.rays; },
      std::to_string(GatherOptions{}.rays_per_receiver)));
  settings.push_back(NumberSetting(
      "prepare.ground_albedo",
      "albedo of a ground at the mesh's foot, out to the horizon; 0: "
      "none",
      Between(0.0, 0.99),
      [](Options & o) -> auto& { return o.prepare.ground_albedo; }));
  settings.push_back(ProbeCountsSetting());
  settings.push_back(NumberSetting(
      "prepare.probe_spacing_m",
      "the same grid, by the distance between its probes",
      Above(0.0, "metres"),
      [](Options & o) -> auto& { return o.prepare.probe_spacing_m; },
      "by prepare.probe_counts"));
  settings.push_back(NumberSetting(
      "prepare.probe_rays",
      "rays that each probe casts",
      Between(1, 1 << 20),
      [](Options & o) -> auto& { return o.prepare.probe_rays; },
      std::to_string(ProbeOptions{}.rays_per_probe)));
  settings.push_back(NumberSetting(
      "prepare.map_width",
      "width of the environment map: its own or a part of that",
      Between(1, 1 << 16, "pixels"),
      [](Options & o) -> auto& { return o.prepare.map_width; },
      "its own"));
}

void AddObjects(std::vector<Setting>& settings) {
  settings.push_back(ChoiceSetting(
      "pipeline.object_light.route",
      "light on objects: rays at their vertices, rays at a single probe among them, an irradiance "
      "volume, or the same volume through an environment map",
      [](Options & o) -> auto& { return o.pipeline.object_light.route; },
      {{"gather", ObjectLight::kGather},
       {"probe", ObjectLight::kSingleProbe},
       {"volume", ObjectLight::kVolume},
       {"map", ObjectLight::kVolumeByMap}}));
  settings.push_back(NumberSetting(
      "pipeline.object_light.gather.rays_per_receiver",
      "rays at each vertex of an object",
      Between(1, 65536),
      [](Options & o) -> auto& { return o.pipeline.object_light.gather.rays_per_receiver; }));
  settings.push_back(ChoiceSetting(
      "light_in_steps",
      "light of objects that move is coarse, and refined in frames after that",
      [](Options & o) -> auto& { return o.light_in_steps; },
      {{"on", true}, {"off", false}},
      "on in the viewer and for a camera's pictures, off for a recording's"));
  settings.push_back(NumberSetting(
      "pipeline.object_light.in_motion.vertices_per_frame",
      "vertices of moving objects whose rays are cast in a frame; 0: all",
      Between(0, 1 << 30),
      [](Options & o) -> auto& { return o.pipeline.object_light.in_motion.vertices_per_frame; }));
  settings.push_back(NumberSetting(
      "pipeline.object_light.in_motion.vertices_at_rest",
      "the same in frames after a motion, until all have been; 0: all",
      Between(0, 1 << 30),
      [](Options & o) -> auto& { return o.pipeline.object_light.in_motion.vertices_at_rest; }));
  settings.push_back(NumberSetting(
      "pipeline.object_light.in_motion.rays_at_first",
      "rays of a vertex in the first frame of all, where light is in steps; 0: as in others",
      Between(0, 65536),
      [](Options & o) -> auto& { return o.pipeline.object_light.in_motion.rays_at_first; }));
  settings.push_back(NumberSetting(
      "pipeline.object_light.single_probe.rays", "rays at a single probe", Between(1, 1 << 20), [
      ](Options & o) -> auto& { return o.pipeline.object_light.single_probe.rays; }));
  settings.push_back(NumberSetting(
      "pipeline.object_light.single_probe.sh_bands",
      "bands of the spherical harmonics of the light at a single probe",
      Between(1, SingleProbeOptions::kMostShBands),
      [](Options & o) -> auto& { return o.pipeline.object_light.single_probe.sh_bands; }));
  settings.push_back(ChoiceSetting(
      "daylight",
      "light straight from the sky on objects: gathered with the rest, "
      "or by samples of the sky, for rooms with windows",
      [](Options & o) -> auto& { return o.daylight; },
      {{"gather", Daylight::kGather}, {"samples", Daylight::kSamples}},
      "gather; samples indoors with an irradiance volume"));
  settings.push_back(NumberSetting(
      "pipeline.object_light.direct_daylight.sampling.samples",
      "samples of each shape of the sky",
      Between(1, 65536),
      [](Options & o) -> auto& {
        return o.pipeline.object_light.direct_daylight.sampling.samples;
      }));
  settings.push_back(ChoiceSetting(
      "pipeline.object_light.direct_daylight.sampling.restriction",
      "where they are drawn: what windows let through, the sky until enough come through, or the "
      "complete sky",
      [](Options & o) -> auto& {
        return o.pipeline.object_light.direct_daylight.sampling.restriction;
      },
      {{"windows", DaylightRestriction::kWindows},
       {"rejection", DaylightRestriction::kRejection},
       {"whole-sky", DaylightRestriction::kWholeSky}}));
  settings.push_back(NumberSetting(
      "pipeline.object_light.direct_daylight.shadows.map_size_px",
      "side of a sample's shadow map; 0: rays in place of maps",
      Between(0, 1024, "pixels"),
      [](Options & o) -> auto& {
        return o.pipeline.object_light.direct_daylight.shadows.map_size_px;
      }));
  settings.push_back(ChoiceSetting(
      "receivers_at",
      "where light from sky and bounces is gathered: at pixels of each view, or on the surfaces, "
      "kept while the camera moves",
      [](Options & o) -> auto& { return o.receivers_at; },
      {{"pixels", SurfaceViewOptions::ReceiversAt::kPixels},
       {"surfaces", SurfaceViewOptions::ReceiversAt::kSurfaces}},
      "surfaces where the camera moves, else pixels"));
  settings.push_back(ChoiceSetting(
      "influence_at",
      "where it is computed what objects occlude and reflect: at "
      "pixels of each view, or on the surfaces, kept while the camera "
      "moves",
      [](Options & o) -> auto& { return o.influence_at; },
      {{"pixels", InfluenceAt::kPixels}, {"faces", InfluenceAt::kFaces}},
      "faces where the camera moves, else pixels"));
  settings.push_back(NumberSetting(
      "pipeline.influence.rays_per_receiver",
      "rays from a real surface over each object's bounding sphere",
      Between(1, 65536),
      [](Options & o) -> auto& { return o.pipeline.influence.rays_per_receiver; }));
  settings.push_back(NumberSetting(
      "pipeline.influence.least_spacing",
      "distance of receivers on surfaces near an object, over its radius",
      Above(0.0),
      [](Options & o) -> auto& { return o.pipeline.influence.least_spacing; }));
  settings.push_back(NumberSetting(
      "pipeline.influence.in_motion.rays_per_receiver",
      "rays from a real surface over an object that moves; 0: as over one at rest",
      Between(0, 65536),
      [](Options & o) -> auto& { return o.pipeline.influence.in_motion.rays_per_receiver; }));
  settings.push_back(NumberSetting(
      "pipeline.influence.in_motion.coarseness",
      "distance of receivers on surfaces near an object that moves, over that at rest",
      Above(0.0),
      [](Options & o) -> auto& { return o.pipeline.influence.in_motion.coarseness; }));
  settings.push_back(NumberSetting(
      "pipeline.influence.in_motion.receivers_at_rest",
      "receivers on surfaces whose rays are cast in a frame after a motion; 0: all",
      Between(0, 1 << 30),
      [](Options & o) -> auto& { return o.pipeline.influence.in_motion.receivers_at_rest; }));
  settings.push_back(NumberSetting(
      "pipeline.soft_sun.disc_samples",
      "points of the sun's disc for a pixel near the edge of a virtual shadow",
      Between(4, 65536),
      [](Options & o) -> auto& { return o.pipeline.soft_sun.disc_samples; }));
  settings.push_back(NumberSetting(
      "pipeline.mirror.rays_per_pixel", "rays of a pixel that shows a mirror", Between(1, 65536), [
      ](Options & o) -> auto& { return o.pipeline.mirror.rays_per_pixel; }));
  settings.push_back(NumberSetting(
      "pipeline.mirror.rays_per_place",
      "rays from a mirrored surface to what objects occlude from it; 0: none",
      Between(0, 65536),
      [](Options & o) -> auto& { return o.pipeline.mirror.rays_per_place; }));
}

void AddPicture(std::vector<Setting>& settings) {
  settings.push_back(NumberSetting(
      "pipeline.sun_step_s",
      "age that the sun's transport may reach; 0: none",
      Between(0.0, 86400.0, "seconds"),
      [](Options & o) -> auto& { return o.pipeline.sun_step_s; }));
  settings.push_back(NumberSetting(
      "pipeline.bounce_step_s",
      "the same for the sun's bounces, and sky shapes that turn with it",
      Between(0.0, 86400.0, "seconds"),
      [](Options & o) -> auto& { return o.pipeline.bounce_step_s; }));
  settings.push_back(NumberSetting(
      "pipeline.view.sun_block_px",
      "side of blocks that are lit in the same way when their corners are; 1: none; 0: 4 where the "
      "camera moves, else 1",
      Between(0, 64, "pixels"),
      [](Options & o) -> auto& { return o.pipeline.view.sun_block_px; }));
  settings.push_back(NumberSetting(
      "pipeline.view.geometry_block_px",
      "side of blocks that show one plane when their corners do; 1: none; 0: 4 where the camera "
      "moves, else 1",
      Between(0, 64, "pixels"),
      [](Options & o) -> auto& { return o.pipeline.view.geometry_block_px; }));
  settings.push_back(NumberSetting(
      "pipeline.view.surfaces.spacing",
      "distance of receivers on surfaces over that of what is around them",
      Above(0.0),
      [](Options & o) -> auto& { return o.pipeline.view.surfaces.spacing; }));
  settings.push_back(NumberSetting(
      "pipeline.view.surfaces.most_parts",
      "parts, at most, into which receivers on surfaces divide a patch's edge",
      Between(1, 64),
      [](Options & o) -> auto& { return o.pipeline.view.surfaces.most_parts; }));
  settings.push_back(NumberSetting(
      "pipeline.view.surfaces.rays_per_receiver",
      "rays of each receiver on surfaces",
      Between(1, 65536),
      [](Options & o) -> auto& { return o.pipeline.view.surfaces.rays_per_receiver; }));
  settings.push_back(NumberSetting(
      "pipeline.view.receiver_block_px",
      "side of the blocks for which light from the sky and by reflection is gathered",
      Between(1, 64, "pixels"),
      [](Options & o) -> auto& { return o.pipeline.view.receiver_block_px; }));
  settings.push_back(
      ChoiceSetting("compositor.object_samples_per_side",
                    "side n of the n^2 + 1 samples of a pixel that shows an object",
                    [](Options & o) -> auto& { return o.compositor.object_samples_per_side; },
                    {{"2", 2}, {"4", 4}, {"6", 6}, {"8", 8}}));
  settings.push_back(NumberSetting(
      "pipeline.effects.threshold_code_values",
      "what the effects that the plan leaves out may change in all",
      From(0.0, "8-bit code values"),
      [](Options & o) -> auto& { return o.pipeline.effects.threshold_code_values; }));
  settings.push_back(NumberSetting(
      "pipeline.effects.budget_ms",
      "time for a frame, which the plan then fits, whatever the threshold",
      Above(0.0, "milliseconds"),
      [](Options & o) -> auto& { return o.pipeline.effects.budget_ms; },
      "none"));
  settings.push_back(SwitchSetting(
      "pipeline.daylight_colours",
      "draws pictures in light of colours that daylight has; never where a fish-eye "
      "measures the sky",
      [](Options & o) -> auto& { return o.pipeline.daylight_colours; }));
}

void AddReport(std::vector<Setting>& settings) {
  settings.push_back(SwitchSetting(
      "measure_shadows",
      "compares the direction of the real shadows with the sun's, in "
      "about 0.5 s a frame",
      [](Options & o) -> auto& { return o.measure_shadows; }));
}

}  // namespace

std::vector<Setting> MakeSettings() {
  std::vector<Setting> settings;
  AddInput(settings);
  AddLight(settings);
  AddPrepare(settings);
  AddObjects(settings);
  AddPicture(settings);
  AddReport(settings);
  return settings;
}

}  // namespace pleinair::internal
