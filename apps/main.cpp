// The command line: arguments in, one line and exit code 2 on bad input. The work is in
// *_command.cpp.

#include <algorithm>
#include <cstdio>
#include <exception>
#include <map>
#include <regex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "apps/arguments.h"
#include "apps/calibrate_arguments.h"
#include "apps/command_line.h"
#include "apps/doctor_command.h"
#include "apps/evaluation_arguments.h"
#include "apps/irradiance_command.h"
#include "apps/number_pair.h"
#include "apps/run_command.h"
#include "apps/score_command.h"
#include "apps/shared_ranks.h"
#include "apps/sun_command.h"

namespace {

using pleinair::Print;
using pleinair::Work;

constexpr int kBadInput = 2;

void AddBounces(CLI::App& command, int& bounces) {
  command
      .add_option_function<std::string>(
          "--bounces",
          [&bounces](const std::string& text) {
            bounces = text == "all" ? pleinair::kAllBounces : std::stoi(text);
          },
          "Reflections between surfaces: 0 (as jensen-2006), 1, ..., all")
      ->check(CLI::IsMember({"all"}) | CLI::Range(0, 100))
      ->type_name("N|all")
      ->default_str("all");
}

// "8x8x8", or a spacing in metres.
void ReadProbes(const std::string& text, pleinair::PrepareSettings& settings) {
  static const std::regex kCounts("([0-9]{1,3})x([0-9]{1,3})x([0-9]{1,3})");
  std::smatch counts;
  if (std::regex_match(text, counts, kCounts)) {
    settings.probe_counts =
        glm::ivec3(std::stoi(counts[1]), std::stoi(counts[2]), std::stoi(counts[3]));
    return;
  }
  try {
    std::size_t end = 0;
    settings.probe_spacing_m = std::stod(text, &end);
    if (end == text.size()) return;
  } catch (const std::exception&) {
  }
  throw CLI::ValidationError("--probes", text + ": expected XxYxZ or a spacing in metres");
}

void AddGroundAlbedo(CLI::App& command, double& albedo) {
  command
      .add_option("--ground-albedo",
                  albedo,
                  "Lay a ground of this albedo at the mesh's foot, out to the horizon: light from "
                  "below the horizon; 0: none")
      ->check(CLI::Range(0.0, 0.99))
      ->capture_default_str();
}

// Of the offline part.
void AddPrepareSettings(CLI::App& command, pleinair::PrepareSettings& settings) {
  AddBounces(command, settings.bounces);
  command
      .add_option(
          "--patch-size", settings.patch_size_m, "Longest edge of patches near the objects, metres")
      ->check(pleinair::Positive());
  command.add_option("--rays", settings.rays, "Rays that each receiver of light casts")
      ->check(CLI::Range(1, 65536));
  AddGroundAlbedo(command, settings.ground_albedo);
  command
      .add_option_function<std::string>(
          "--probes",
          [&settings](const std::string& text) { ReadProbes(text, settings); },
          "Grid of the irradiance volume: XxYxZ probes, or their spacing in metres")
      ->type_name("XxYxZ|M")
      ->default_str("8x8x8");
  command.add_option("--probe-rays", settings.probe_rays, "Rays that each probe casts")
      ->check(CLI::Range(1, 1 << 20));
}

void AddCache(CLI::App& command, std::filesystem::path& cache) {
  command.add_option(
      "--cache", cache, "Folder for prepared data (default: pleinair in the user's cache folder)");
}

void AddSun(CLI::App& app, Work& work) {
  auto options = std::make_shared<pleinair::SunCommandOptions>();
  CLI::App& sun = *app.add_subcommand("sun", "Sun position for a place and time");
  sun.footer("Example: pleinair sun --site 57.0488,9.9217,15 --time 2005-06-21T09:50:00Z");
  sun.add_option(
         "--site", options->site, "LAT,LON[,H] in degrees (north, east positive) and metres")
      ->required();
  sun.add_option("--time", options->time, "UTC, ISO 8601: 2005-06-21T09:50:00Z")->required();
  sun.add_option("--ut1-utc", options->ut1_minus_utc_s, "UT1 - UTC in seconds (default 0)");
  sun.add_option(
      "--delta-t", options->tt_minus_ut1_s, "TT - UT1 in seconds (default: the library's)");
  sun.add_option("--pressure-hpa",
                 options->pressure_hpa,
                 "For refraction (default: standard atmosphere at the site's height)");
  sun.add_option("--temperature-c", options->temperature_c, "For refraction (default: likewise)");
  sun.add_flag("--json", options->json, "Print JSON");
  sun.callback([options, &work] {
    work = [options] {
      if (const auto warning = SunCommandWarning(*options)) spdlog::warn("{}", *warning);
      return Print(RunSunCommand(*options));
    };
  });
}

void AddPrepare(CLI::App& app, Work& work) {
  auto options = std::make_shared<pleinair::PrepareCommandOptions>();
  CLI::App& prepare =
      *app.add_subcommand("prepare", "The offline part of a site, kept in the cache");
  prepare.footer("Example: pleinair prepare datasets/samples/courtyard --maps maps");
  prepare.add_option("sequence", options->sequence, "Folder with sequence.json")->required();
  prepare.add_option(
      "--maps", options->maps, "Write albedo, normal, ambient weight, ... as EXR and PNG");
  AddPrepareSettings(prepare, options->prepare);
  AddCache(prepare, options->cache);
  prepare.callback([options, &work] {
    work = [options] {
      RunPrepareCommand(*options);
      return 0;
    };
  });
}

// Effects by name are on, and the others off, or left to the plan where `plan` is named too.
void ChooseEffects(const std::vector<std::string>& names, pleinair::EffectSettings& effects) {
  using pleinair::Effect;
  using pleinair::EffectSettings;
  using pleinair::EffectSwitch;
  const auto is_named = [&names](std::string_view name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const EffectSwitch others = is_named("all")    ? EffectSwitch::kOn
                              : is_named("plan") ? EffectSwitch::kPlan
                                                 : EffectSwitch::kOff;
  effects.switches = EffectSettings::Filled(others);
  for (const Effect effect : pleinair::kAllEffects) {
    if (is_named(NameOf(effect))) effects[effect] = EffectSwitch::kOn;
  }
  // Their other halves.
  if (is_named("sun-shadow")) effects[Effect::kObjectShadow] = EffectSwitch::kOn;
  if (is_named("probe-shading")) effects[Effect::kDaylight] = EffectSwitch::kOn;
  // Part of all that needs the light on objects; --object-light probe leaves it out.
  if (others == EffectSwitch::kOff) effects[Effect::kLightVariation] = EffectSwitch::kOn;
}

void AddEffects(CLI::App& run, pleinair::EffectSettings& effects) {
  std::vector<std::string> names{"plan", "all"};
  for (const pleinair::Effect effect : pleinair::kAllEffects) {
    names.emplace_back(NameOf(effect));
  }
  run.add_option_function<std::vector<std::string>>(
         "--effects",
         [&effects](const std::vector<std::string>& chosen) { ChooseEffects(chosen, effects); },
         "plan (what can be seen), all, or some of sun-shading,sun-shadow,object-shadow,penumbra,"
         "probe-shading,light-variation,daylight,glossy-reflection,sky-occlusion,colour-bleeding "
         "and, of 8-bit "
         "frames, camera-blur,camera-noise; with plan among them the others are left to it. "
         "sun-shadow brings object-shadow along, probe-shading daylight, and any of them "
         "light-variation")
      ->delimiter(',')
      ->check(CLI::IsMember(names))
      ->default_str("plan");
  run.add_option("--threshold",
                 effects.threshold_code_values,
                 "Of the plan: what the effects that it leaves out may change in all, in 8-bit "
                 "code values")
      ->check(pleinair::NotNegative());
  run.add_option("--budget",
                 effects.budget_ms,
                 "Milliseconds for a frame: the plan picks what can be had for them, and says in "
                 "plan.jsonl what that costs the picture")
      ->check(pleinair::Positive())
      ->excludes("--threshold");
}

void AddSkyShapes(CLI::App& command, std::vector<pleinair::SkyShapeKind>& shapes) {
  std::map<std::string, pleinair::SkyShapeKind> by_name;
  for (const pleinair::SkyShapeKind kind : pleinair::kAllSkyShapeKinds) {
    by_name.emplace(pleinair::NameOf(kind), kind);
  }
  command
      .add_option(
          "--sky-shapes", shapes, "What an outdoor sky is a mix of: some of uniform,overcast,clear")
      ->delimiter(',')
      ->transform(CLI::CheckedTransformer(by_name))
      ->default_str("uniform,overcast,clear");
}

void AddFit(CLI::App& run, pleinair::RunCommandOptions& options) {
  using pleinair::SampleChoice;
  using Loss = pleinair::LightingFitOptions::Loss;
  using Solver = pleinair::LightingFitOptions::Solver;
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

void AddDaylight(CLI::App& run, pleinair::RunCommandOptions& options) {
  using pleinair::Daylight;
  using pleinair::DaylightRestriction;
  run.add_option("--daylight",
                 options.daylight,
                 "Light straight from the sky on the objects, and taken by them from real "
                 "surfaces: gather (as --object-light) or samples (of the sky, for rooms with "
                 "windows)")
      ->transform(CLI::CheckedTransformer(std::map<std::string, Daylight>{
          {"gather", Daylight::kGather}, {"samples", Daylight::kSamples}}))
      ->default_str("gather; samples with volume or map indoors");
  pleinair::DaylightSamplingOptions& sampling = options.direct_daylight.sampling;
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

void AddRun(CLI::App& app, Work& work) {
  auto options = std::make_shared<pleinair::RunCommandOptions>();
  CLI::App& run = *app.add_subcommand("run", "The main job: light and composite, frame by frame");
  run.footer("Example: pleinair run datasets/samples/courtyard --out out");
  run.add_option("sequence", options->sequence, "Folder with sequence.json")->required();
  run.add_option("--out", options->out, "Folder for the results")->default_str("pleinair-out");
  options->out = "pleinair-out";
  run.add_option("--frames", options->frames, "Which frames where there are both: linear or ldr")
      ->transform(CLI::CheckedTransformer(std::map<std::string, pleinair::FrameKind>{
          {"linear", pleinair::FrameKind::kLinear}, {"ldr", pleinair::FrameKind::kLdr}}))
      ->default_str("linear");
  run.add_flag("--ignore-exposure",
               options->ignore_exposure,
               "Take the exposure of 8-bit frames for unknown: light is then relative");
  run.add_option(
         "--full-well",
         options->camera_noise.full_well_electrons,
         "Electrons of the 8-bit camera's brightest signal, for its shot noise; with this "
         "or --read-noise virtual objects get noise by both, else as measured in each frame")
      ->each([options](const std::string&) { options->camera_noise_is_known = true; })
      ->check(pleinair::Positive());
  run.add_option("--read-noise",
                 options->camera_noise.read_noise_electrons,
                 "Electrons of the 8-bit camera's read noise")
      ->each([options](const std::string&) { options->camera_noise_is_known = true; })
      ->check(pleinair::Positive());
  run.add_option("--source",
                 options->source,
                 "What the light is measured from: outdoor (diffuse walls and paving) or fisheye")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, pleinair::SourceKind>{{"outdoor", pleinair::SourceKind::kOutdoor},
                                                      {"fisheye", pleinair::SourceKind::kFisheye}}))
      ->default_str("fisheye where frames have such a picture");
  run.add_option("--markers",
                 options->markers,
                 "Board file of `calibrate markers`: camera poses come from the markers in the "
                 "frames, not from the sequence");
  run.add_option("--samples", options->samples, "Pixels to measure from")
      ->check(CLI::Range(1, 100000));
  run.add_option("--seed", options->seed, "Of the choice of samples");
  AddFit(run, *options);
  AddSkyShapes(run, options->sky_shapes);
  run.add_option("--albedo",
                 options->albedo,
                 "Of real surfaces: survey (the environment map), materials (the mesh's Kd) or "
                 "self-calibrated (found together with the light of the frames)")
      ->transform(CLI::CheckedTransformer(std::map<std::string, pleinair::AlbedoSource>{
          {"survey", pleinair::AlbedoSource::kSurvey},
          {"materials", pleinair::AlbedoSource::kMaterials},
          {"self-calibrated", pleinair::AlbedoSource::kSelfCalibrated}}))
      ->default_str(
          "survey where there is a map; else materials where their albedo is known or assumed, or "
          "light is not measured from it; else self-calibrated");
  run.add_option_function<std::string>(
         "--sky-regions",
         [options](const std::string& text) {
           const auto [bands, sectors] = pleinair::ParsePair<int>(text, 'x', "--sky-regions");
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
      ->transform(CLI::CheckedTransformer(std::map<std::string, pleinair::ObjectLight>{
          {"gather", pleinair::ObjectLight::kGather},
          {"probe", pleinair::ObjectLight::kOnePlace},
          {"volume", pleinair::ObjectLight::kVolume},
          {"map", pleinair::ObjectLight::kVolumeByMap}}))
      ->default_str("gather");
  run.add_option("--object-rays", options->object_rays, "Of gather: rays that a vertex casts")
      ->check(CLI::Range(1, 65536));
  run.add_option("--sh-bands",
                 options->one_place.sh_bands,
                 "Of the light at one place: bands of its spherical harmonics")
      ->check(CLI::Range(1, pleinair::OnePlaceOptions::kMostShBands));
  AddDaylight(run, *options);
  run.add_option("--influence",
                 options->influence_at,
                 "Where it is worked out what objects hide and send on real surfaces: pixels (anew "
                 "for each view) or faces (of the surfaces, kept while the camera moves)")
      ->transform(CLI::CheckedTransformer(std::map<std::string, pleinair::InfluenceAt>{
          {"pixels", pleinair::InfluenceAt::kPixels}, {"faces", pleinair::InfluenceAt::kFaces}}))
      ->default_str("faces where a fish-eye lights a moving camera, else pixels");
  run.add_option("--sun-block",
                 options->sun_block_px,
                 "Side in pixels of blocks that are lit alike when their corners are; 1: each "
                 "pixel looks for the sun itself")
      ->check(CLI::Range(1, 64));
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
  run.callback([options, &work] {
    work = [options] {
      RunRunCommand(*options);
      return 0;
    };
  });
}

void AddScore(CLI::App& app, Work& work) {
  auto options = std::make_shared<pleinair::ScoreCommandOptions>();
  CLI::App& score = *app.add_subcommand("score", "How far a run is from the truth");
  score.footer("Example: pleinair score datasets/samples/courtyard out");
  score.add_option("sequence", options->sequence, "Folder with sequence.json and truth/")
      ->required();
  score.add_option("out", options->out, "What `pleinair run` wrote")->required();
  score.add_flag("--json", options->json, "Print JSON in place of the table");
  score.callback(
      [options, &work] { work = [options] { return Print(RunScoreCommand(*options)); }; });
}

void AddIrradiance(CLI::App& app, Work& work) {
  auto options = std::make_shared<pleinair::IrradianceCommandOptions>();
  CLI::App& irradiance = *app.add_subcommand(
      "irradiance", "Irradiance at given points and normals, to check against other programs");
  irradiance.footer(
      "Example: pleinair irradiance --scene room.obj --points points.json --out out.json "
      "--sky-regions 4x16 --light indirect");
  irradiance.add_option("--scene", options->scene, "Mesh, taken as it is; what misses it is sky");
  irradiance
      .add_option("--points", options->points, R"({"points": [[x,y,z],...], "normals": ...})")
      ->required();
  irradiance.add_option("--out", options->out, "JSON to write")->required();
  irradiance.add_option("--sky-regions",
                        options->sky_regions,
                        "BANDSxSECTORS: unit radiance of each region (default 4x16)");
  irradiance
      .add_option_function<std::string>(
          "--sky",
          [options](const std::string&) { options->uniform_sky = true; },
          "uniform: unit radiance of the whole sky")
      ->check(CLI::IsMember({"uniform"}));
  irradiance.add_option(
      "--sun", options->sun, "AZ,EL in degrees, azimuth from north clockwise: unit irradiance");
  irradiance.add_option("--sequence",
                        options->sequence,
                        "In place of scene and light: a frame's own estimated light");
  irradiance.add_option("--frame", options->frame, "Which frame of the sequence, from 0");
  irradiance
      .add_option("--light", options->light, "direct, indirect (by way of surfaces) or total")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, pleinair::LightPart>{{"direct", pleinair::LightPart::kDirect},
                                                     {"indirect", pleinair::LightPart::kIndirect},
                                                     {"total", pleinair::LightPart::kTotal}}))
      ->default_str("total");
  AddBounces(irradiance, options->gather.bounces);
  irradiance.add_flag("--sh",
                      options->spherical_harmonics,
                      "Write 9 coefficients of incident radiance a point instead");
  irradiance.add_option("--patch-size",
                        options->gather.patch_size_m,
                        "Longest edge of patches at a point, in metres; 0: as short as 16000 "
                        "patches allow");
  irradiance.add_option("--rays", options->gather.rays_per_point, "Gathering, a point and normal")
      ->check(CLI::Range(1, 65536));
  irradiance.add_option("--sky-rays", options->gather.sky_rays_per_point, "To the sky, likewise");
  irradiance.add_option("--patch-rays", options->gather.rays_per_patch, "Of form factors, a patch")
      ->check(CLI::Range(1, 65536));
  irradiance.add_option(
      "--patch-sky-rays", options->gather.sky_rays_per_patch, "To the sky, a patch");
  AddGroundAlbedo(irradiance, options->gather.ground_albedo);
  irradiance.add_option("--seed", options->gather.seed, "Of all rays");
  AddCache(irradiance, options->cache);
  irradiance.callback([options, &work] {
    work = [options] {
      pleinair::RunIrradianceCommand(*options);
      return 0;
    };
  });
}

void AddDoctor(CLI::App& app, Work& work) {
  auto json = std::make_shared<bool>(false);
  CLI::App& doctor =
      *app.add_subcommand("doctor", "GL, cameras, models, clock: what works, what is missing");
  doctor.footer("Example: pleinair doctor");
  doctor.add_flag("--json", *json, "Print JSON");
  doctor.callback([json, &work] {
    work = [json] {
      bool all_well = false;
      Print(pleinair::RunDoctorCommand(*json, &all_well));
      return all_well ? 0 : 1;
    };
  });
}

}  // namespace

int pleinair::RunCommandLine(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("pleinair"));
  spdlog::set_pattern("%^%l%$ %v");
  const bool shared = SharedRanks() != nullptr;
  if (shared && SharedRanks()->Rank() != 0) spdlog::set_level(spdlog::level::off);

  CLI::App app(
      "Virtual objects in the picture of an ordinary camera, lit by the light that is there.");
  app.name("pleinair");
  app.require_subcommand(1);
  app.set_version_flag("--version", PLEINAIR_VERSION);
  app.option_defaults()->always_capture_default();
  Work work;
  AddSun(app, work);
  AddPrepare(app, work);
  AddRun(app, work);
  AddScore(app, work);
  pleinair::AddRegress(app, work);
  pleinair::AddTradeoff(app, work);
  pleinair::AddCalibrate(app, work);
  AddIrradiance(app, work);
  AddDoctor(app, work);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& done) {
    return app.exit(done);  // --help, --version
  } catch (const CLI::Error& error) {
    // A word that nobody knows is the likelier cause of what is then found missing.
    const std::vector<std::string> unknown = app.remaining(true);
    const std::string reason = unknown.empty() ? error.what() : unknown.front() + ": unknown here";
    std::fprintf(stderr, "pleinair: %s (see `pleinair --help`)\n", reason.c_str());
    return kBadInput;
  } catch (
      const std::invalid_argument& error) {  // An argument that reads well, and makes no sense.
    std::fprintf(stderr, "pleinair: %s (see `pleinair --help`)\n", error.what());
    return kBadInput;
  }
  if (shared && SharedRanks()->Count() > 1 && !app.got_subcommand("irradiance")) {
    std::fprintf(stderr, "pleinair: ranks can share the command irradiance alone\n");
    return kBadInput;
  }
  try {
    return work();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "pleinair: %s\n", error.what());
    return kBadInput;
  }
}
