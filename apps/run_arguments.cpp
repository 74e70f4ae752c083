#include "apps/run_arguments.h"

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "apps/effect_names.h"
#include "apps/number_pair.h"
#include "apps/quality.h"
#include "apps/run_command.h"

namespace pleinair {
namespace {

void AddEffects(CLI::App& run, EffectSettings& effects) {
  run.add_option_function<std::vector<std::string>>(
         "--effects",
         [&effects](const std::vector<std::string>& names) {
           effects.switches = SwitchesOf(names);
         },
         "plan (what can be seen), all, or some of sun-shading,sun-shadow,object-shadow,penumbra,"
         "probe-shading,light-variation,self-occlusion,current-light,daylight,glossy-reflection,"
         "sky-occlusion,"
         "colour-bleeding,camera-blur and, of 8-bit frames, camera-noise; with plan among them the "
         "others are left to it. sun-shadow brings object-shadow along, probe-shading and "
         "sky-occlusion daylight, and any of them light-variation, self-occlusion and "
         "current-light. no-NAME "
         "leaves "
         "one out of the others")
      ->delimiter(',')
      ->check(CLI::Validator(
          [](const std::string& name) {
            const std::vector<std::string> known = NamesOfSwitches();
            if (std::find(known.begin(), known.end(), name) != known.end()) return std::string();
            return "expected plan, all, the name of an effect or no- before it, found '" + name +
                   "'";
          },
          "plan|all|NAME|no-NAME"))
      ->default_str("plan");
  run.add_option("--threshold",
                 effects.threshold_code_values,
                 "Of the plan: what the effects that it leaves out may change in all, in 8-bit "
                 "code values")
      ->check(NotNegative());
  run.add_option("--budget",
                 effects.budget_ms,
                 "Milliseconds for a frame: the plan picks what can be had for them, and says in "
                 "plan.jsonl what that costs the picture")
      ->check(Positive())
      ->excludes("--threshold");
}

std::map<std::string, Weather> Weathers() {
  std::map<std::string, Weather> by_name;
  for (const Weather weather : kAllWeathers) by_name.emplace(NameOf(weather), weather);
  return by_name;
}

void AddSkyShapes(CLI::App& command, std::vector<SkyShapeKind>& shapes) {
  std::map<std::string, SkyShapeKind> by_name;
  for (const SkyShapeKind kind : kAllSkyShapeKinds) {
    by_name.emplace(NameOf(kind), kind);
  }
  command
      .add_option(
          "--sky-shapes", shapes, "What an outdoor sky is a mix of: some of uniform,overcast,clear")
      ->delimiter(',')
      ->transform(CLI::CheckedTransformer(by_name))
      ->default_str("uniform,overcast,clear");
}

void AddFit(CLI::App& run, RunCommandOptions& options) {
  using Loss = LightingFitOptions::Loss;
  using Solver = LightingFitOptions::Solver;
  run.add_option("--sample-choice",
                 options.sample_choice,
                 "Which pixels: balanced (as many lit as shaded, of each region and facing), "
                 "proportional (evenly over what is seen) or random")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, SampleChoice>{{"balanced", SampleChoice::kBalanced},
                                              {"proportional", SampleChoice::kProportional},
                                              {"random", SampleChoice::kRandom}}))
      ->default_str("balanced");
  run.add_option("--loss",
                 options.loss,
                 "What a sample far from the model counts: tukey (nothing), huber (less) or "
                 "squares (as much as any)")
      ->transform(CLI::CheckedTransformer(std::map<std::string, Loss>{
          {"tukey", Loss::kTukey}, {"huber", Loss::kHuber}, {"squares", Loss::kSquares}}))
      ->default_str("tukey");
  run.add_option("--solver", options.solver, "Of the fit: ceres or closed (an independent check)")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, Solver>{{"ceres", Solver::kCeres}, {"closed", Solver::kClosed}}))
      ->default_str("ceres");
}

void AddDaylight(CLI::App& run, RunCommandOptions& options) {
  run.add_option("--daylight",
                 options.daylight,
                 "Light straight from the sky on the objects, and taken by them from real "
                 "surfaces: gather (as --object-light) or samples (of the sky, for rooms with "
                 "windows)")
      ->transform(CLI::CheckedTransformer(std::map<std::string, Daylight>{
          {"gather", Daylight::kGather}, {"samples", Daylight::kSamples}}))
      ->default_str("gather; samples with volume or map indoors");
  DaylightSamplingOptions& sampling = options.direct_daylight.sampling;
  run.add_option("--daylight-samples", sampling.samples, "Of each shape of the sky")
      ->check(CLI::Range(1, 65536));
  run.add_option("--daylight-sampling",
                 sampling.restriction,
                 "Where samples are drawn: windows (what they let through to the objects), "
                 "rejection (the whole sky, until enough come through) or whole-sky")
      ->transform(CLI::CheckedTransformer(std::map<std::string, DaylightRestriction>{
          {"windows", DaylightRestriction::kWindows},
          {"rejection", DaylightRestriction::kRejection},
          {"whole-sky", DaylightRestriction::kWholeSky}}))
      ->default_str("windows");
  run.add_option("--daylight-map-size",
                 options.direct_daylight.shadows.map_size_px,
                 "Side of a sample's shadow map in pixels; 0: rays in place of maps")
      ->check(CLI::Range(0, 1024));
}

// Once all is read, so that what is given wins wherever it stands.
void AddQuality(CLI::App& run, RunCommandOptions& options) {
  auto quality = std::make_shared<Quality>(Quality::kBalanced);
  CLI::Option* option = run.add_option("--quality",
                                       *quality,
                                       fmt::format("fast ({}), balanced (as said at each option) "
                                                   "or best ({}); an option that is given wins",
                                                   QualityInWords(Quality::kFast),
                                                   QualityInWords(Quality::kBest)));
  std::map<std::string, Quality> by_name;
  for (const Quality each : kAllQualities) by_name.emplace(NameOf(each), each);
  option->transform(CLI::CheckedTransformer(by_name))->default_str("balanced");
  run.parse_complete_callback([&run, &options, quality, option] {
    if (option->count() == 0) return;
    ApplyQuality(
        *quality,
        [&run](const std::string& name) { return run.get_option("--" + name)->count() > 0; },
        options);
  });
}

}  // namespace

void AddRun(CLI::App& app, Work& work) {
  auto options = std::make_shared<RunCommandOptions>();
  CLI::App& run = *app.add_subcommand("run", "The main job: light and composite, frame by frame");
  run.footer("Example: pleinair run datasets/samples/courtyard --out out");
  run.add_option("sequence", options->sequence, "Folder with sequence.json")->required();
  run.add_option("--out", options->out, "Folder for the results")->default_str("pleinair-out");
  options->out = "pleinair-out";
  run.add_option("--frames", options->frames, "Which frames where there are both: linear or ldr")
      ->transform(CLI::CheckedTransformer(std::map<std::string, FrameKind>{
          {"linear", FrameKind::kLinear}, {"ldr", FrameKind::kLdr}}))
      ->default_str("linear");
  run.add_flag("--ignore-exposure",
               options->ignore_exposure,
               "Take the exposure of 8-bit frames for unknown: light is then relative");
  run.add_option(
         "--weather",
         options->weather,
         "What the sky was like in all frames, as you saw it: overcast, broken or clear; in "
         "place of what the sequence says of any")
      ->transform(CLI::CheckedTransformer(Weathers()))
      ->default_str("as the sequence says");
  run.add_option(
         "--full-well",
         options->camera_noise.full_well_electrons,
         "Electrons of the 8-bit camera's brightest signal, for its shot noise; with this "
         "or --read-noise virtual objects get noise by both, else as measured in each frame")
      ->each([options](const std::string&) { options->camera_noise_is_known = true; })
      ->check(Positive());
  run.add_option("--read-noise",
                 options->camera_noise.read_noise_electrons,
                 "Electrons of the 8-bit camera's read noise")
      ->each([options](const std::string&) { options->camera_noise_is_known = true; })
      ->check(Positive());
  run.add_option("--source",
                 options->source,
                 "What the light is measured from: outdoor (diffuse walls and paving) or fisheye")
      ->transform(CLI::CheckedTransformer(std::map<std::string, SourceKind>{
          {"outdoor", SourceKind::kOutdoor}, {"fisheye", SourceKind::kFisheye}}))
      ->default_str("fisheye where frames have such a picture");
  run.add_option("--markers",
                 options->markers,
                 "Board file of `calibrate markers`: camera poses come from the markers in the "
                 "frames, not from the sequence");
  run.add_option("--samples", options->samples, "Pixels to measure from")
      ->check(CLI::Range(1, 100000));
  run.add_option("--seed", options->seed, "Of the choice of samples")->check(WholeNumber());
  AddFit(run, *options);
  AddSkyShapes(run, options->sky_shapes);
  run.add_option("--albedo",
                 options->albedo,
                 "Of real surfaces: survey (the environment map), materials (the mesh's Kd) or "
                 "self-calibrated (found together with the light of the frames)")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, AlbedoSource>{{"survey", AlbedoSource::kSurvey},
                                              {"materials", AlbedoSource::kMaterials},
                                              {"self-calibrated", AlbedoSource::kSelfCalibrated}}))
      ->default_str(
          "survey where there is a map; else materials where their albedo is known or assumed, or "
          "light is not measured from it; else self-calibrated");
  run.add_option_function<std::string>(
         "--sky-regions",
         [options](const std::string& text) {
           const auto [bands, sectors] = ParsePair<int>(text, 'x', "--sky-regions");
           options->sky_regions.emplace(bands, sectors);
         },
         "Average a fish-eye's sky over regions before it lights the scene (default: its picture "
         "does)")
      ->type_name("BANDSxSECTORS");
  AddPrepareSettings(run, options->prepare);
  run.add_option("--object-light",
                 options->object_light,
                 "Light on the objects: gather (rays at their vertices), probe (rays at one place "
                 "among them, which gather takes by itself where it looks the same), volume (of "
                 "probes) or map (the same volume by way of an environment map)")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, ObjectLight>{{"gather", ObjectLight::kGather},
                                             {"probe", ObjectLight::kOnePlace},
                                             {"volume", ObjectLight::kVolume},
                                             {"map", ObjectLight::kVolumeByMap}}))
      ->default_str("gather");
  run.add_option("--object-rays", options->object_rays, "Of gather: rays that a vertex casts")
      ->check(CLI::Range(1, 65536));
  run.add_option("--sh-bands",
                 options->one_place.sh_bands,
                 "Of the light at one place: bands of its spherical harmonics")
      ->check(CLI::Range(1, OnePlaceOptions::kMostShBands));
  AddDaylight(run, *options);
  run.add_option("--influence",
                 options->influence_at,
                 "Where it is worked out what objects hide and send on real surfaces: pixels (anew "
                 "for each view) or faces (of the surfaces, kept while the camera moves)")
      ->transform(CLI::CheckedTransformer(std::map<std::string, InfluenceAt>{
          {"pixels", InfluenceAt::kPixels}, {"faces", InfluenceAt::kFaces}}))
      ->default_str("faces where a fish-eye lights a moving camera, else pixels");
  run.add_option("--sun-block",
                 options->sun_block_px,
                 "Side in pixels of blocks that are lit alike when their corners are; 1: each "
                 "pixel looks for the sun itself")
      ->check(CLI::Range(1, 64));
  run.add_option("--receiver-block",
                 options->receiver_block_px,
                 "Side in pixels of the blocks for which light from the sky and by reflection is "
                 "gathered")
      ->check(CLI::Range(1, 64));
  run.add_option("--object-samples",
                 options->object_samples_per_side,
                 "Side n of the n^2 + 1 samples of a pixel that shows an object: 2, 4, 6 or 8")
      ->check(CLI::IsMember({2, 4, 6, 8}));
  AddEffects(run, options->effects);
  run.add_option("--penumbra-samples",
                 options->penumbra_samples,
                 "Points of the sun's disc for a pixel near the edge of a virtual shadow")
      ->check(CLI::Range(4, 65536));
  run.add_option("--lighting",
                 options->lighting,
                 "A lighting.jsonl whose light to use instead of estimating it; a line may name "
                 "sky_shape or sky_image, or leave the shape to be fitted")
      ->excludes("--source");
  run.add_flag_function(
      "--no-filter",
      [options](std::int64_t) { options->filter = false; },
      "Report each frame's own estimate, not filtered over time");
  run.add_flag("--measure-shadows",
               options->measure_shadows,
               "Compare the real shadows' direction with the sun's; about 0.5 s a frame");
  run.add_flag("--video", options->video, "Write composite.mp4 as well");
  run.add_flag("--write-environment",
               options->write_environment,
               "Write the light around the objects as lat-long EXRs, with and without the sun");
  run.add_option("--video-rate", options->video_frames_per_second, "Frames a second of the video")
      ->check(CLI::Range(0.1, 240.0))
      ->capture_default_str();
  run.add_flag(
      "--strict", options->stop_on_bad_frame, "Stop at the first frame that can't be done");
  AddCache(run, options->cache);
  AddQuality(run, *options);
  run.callback([options, &work] {
    work = [options] {
      RunRunCommand(*options);
      return 0;
    };
  });
}

}  // namespace pleinair
