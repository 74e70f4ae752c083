#include "apps/run_arguments.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "apps/camera_arguments.h"
#include "apps/effect_names.h"
#include "apps/help_text.h"
#include "apps/picture_times_arguments.h"
#include "apps/pose_arguments.h"
#include "apps/run_command.h"
#include "apps/settings_arguments.h"
#include "session/quality.h"

namespace pleinair {
namespace {

constexpr const char* kInput = "Input";
constexpr const char* kOutput = "Output";
constexpr const char* kLight = "Light";
constexpr const char* kPicture = "Picture";
// By --help-all.
constexpr const char* kFromOutside = "Poses and light from outside";
constexpr const char* kTimes = "Times of pictures";
constexpr const char* kFurtherOutput = "Further output";
constexpr const char* kFurtherLight = "Further light";

void AddEffects(CLI::App& run, EffectSettings& effects) {
  run.add_option_function<std::vector<std::string>>(
         "--effects",
         [&effects](const std::vector<std::string>& names) {
           effects.switches = SwitchesOf(names);
         },
         "plan (what is visible), all, or names with commas between them (`pleinair settings` "
         "lists "
         "them); no-NAME leaves one out (default: plan)")
      ->delimiter(',')
      ->check(CLI::Validator(
          [](const std::string& name) {
            const std::vector<std::string> known = NamesOfSwitches();
            if (std::find(known.begin(), known.end(), name) != known.end()) return std::string();
            return "expected plan, all, the name of an effect or no- before it, found '" + name +
                   "'";
          },
          ""))
      ->type_name("NAME,...")
      ->group(kPicture);
}

void AddQuality(CLI::App& run, GivenSettings& given) {
  run.add_option_function<std::string>(
         "--quality",
         [&given](const std::string& text) {
           const auto* found = std::find_if(
               std::begin(kAllQualities), std::end(kAllQualities), [&](Quality quality) {
                 return text == NameOf(quality);
               });
           if (found == std::end(kAllQualities)) {
             throw std::invalid_argument("--quality: expected fast, balanced or best, found '" +
                                         text + "'");
           }
           given.before = [quality = *found](SessionOptions& options) {
             ApplyQuality(quality, options);
           };
         },
         "accuracy against time per frame: fast, balanced or best; other given settings take "
         "precedence (docs/settings.md lists what each sets; default: balanced)")
      ->type_name("")
      ->group(kPicture);
}

WrittenPictures WrittenNamed(const std::string& text) {
  if (text == "all") return WrittenPictures::kAll;
  if (text == "shown") return WrittenPictures::kShown;
  if (text == "none") return WrittenPictures::kNone;
  throw std::invalid_argument("--pictures: expected all, shown or none, found '" + text + "'");
}

double ParseVideoRate(const std::string& text) {
  double rate = 0.0;
  if (CLI::detail::lexical_cast(text, rate) && rate >= 0.1 && rate <= 240.0) return rate;
  throw std::invalid_argument("--video: expected frames a second from 0.1 to 240, found '" + text +
                              "'");
}

void AddOutput(CLI::App& run, RunCommandOptions& options) {
  run.add_option("--out", options.out, "folder for the results (default: pleinair-out)")
      ->type_name("FOLDER")
      ->default_str("")
      ->group(kOutput);
  run.add_flag("--video{auto}")
      ->description(
          "composite.mp4 as well; --video=RATE at so many frames a second (0.1 to 240; default: a "
          "camera's own, else 10)")
      ->each([&options](const std::string& rate) {
        options.video = true;
        if (rate != "auto") options.video_frames_per_second = ParseVideoRate(rate);
      })
      ->type_name("RATE")
      ->default_str("")
      ->group(kOutput);
  run.add_flag("--write-environment",
               options.write_environment,
               "the light around the objects as lat-long EXRs, with and without the sun")
      ->group(kFurtherOutput);
  run.add_option_function<std::string>(
         "--pictures",
         [&options](const std::string& text) { options.written = WrittenNamed(text); },
         "which pictures of each frame are written: all, shown (without the scene-linear ones) or "
         "none (default: all; of a camera's frames: shown)")
      ->type_name("WHICH")
      ->group(kOutput);
  run.add_option("--stream",
                 options.picture_stream,
                 "composites to other programs: y4m:- (standard output), y4m:PATH or "
                 "v4l2:/dev/videoN, a loopback device")
      ->type_name("TARGET")
      ->group(kFurtherOutput);
  run.add_option("--lighting-stream",
                 options.lighting_stream,
                 "lines of lighting.jsonl to other programs: -, PATH or unix:PATH, a socket")
      ->type_name("TARGET")
      ->group(kFurtherOutput);
  run.add_option("--record",
                 options.record,
                 "folder to make: a sequence of the camera's frames that were composited")
      ->type_name("FOLDER")
      ->group(kFurtherOutput);
  run.add_option("--duration", options.duration_s, "seconds of a camera's time")
      ->check(Positive().description(""))
      ->type_name("SECONDS")
      ->group(kOutput);
  run.add_option("--frames-limit", options.frames_limit, "frames at most, failed ones included")
      ->check(CLI::Range(1, 1'000'000'000).description(""))
      ->type_name("N")
      ->group(kOutput);
  run.add_flag("--strict", options.stop_on_bad_frame, "stops at the first frame that fails")
      ->group(kOutput);
}

}  // namespace

void AddRun(CLI::App& app, Work& work) {
  auto options = std::make_shared<RunCommandOptions>();
  auto given = std::make_shared<GivenSettings>();
  options->out = "pleinair-out";
  CLI::App& run = *app.add_subcommand("run", "The main job: light and composite, frame by frame");
  run.set_help_all_flag("--help-all", "all options");
  run.formatter(std::make_shared<HelpText>(
      std::set<std::string>{kFromOutside, kTimes, kFurtherOutput, kFurtherLight, kCameraOptions}));
  run.footer("Example: pleinair run datasets/samples/courtyard --out out");
  run.add_option("input",
                 options->input,
                 "folder with sequence.json; with --site a camera (`pleinair cameras` lists them), "
                 "a video, a picture or a folder of pictures")
      ->type_name("INPUT")
      ->required();
  run.add_option("--site",
                 options->sequence,
                 "folder with site.json, or a sequence's: where the input was taken")
      ->type_name("FOLDER")
      ->group(kInput);
  AddOutput(run, *options);
  AddSettingOption(run, "--frames", "frames", *given, kInput);
  AddSettingOption(run, "--source", "source", *given, kInput);
  AddSettingOption(run, "--weather", "weather", *given, kInput);
  AddPoseSources(run, *options, kFromOutside);
  CLI::Option* lighting =
      run.add_option("--lighting",
                     options->lighting,
                     "a lighting.jsonl whose light is used in place of an estimate")
          ->type_name("FILE")
          ->group(kFromOutside);
  AddCache(run, options->cache)->group(kInput);
  AddSettingOption(run, "--samples", "light.samples", *given, kLight);
  AddSettingOption(run, "--seed", "light.seed", *given, kFurtherLight);
  AddSettingOption(run, "--sky-shapes", "light.sky_shapes", *given, kFurtherLight);
  AddSettingOption(run, "--bounces", "prepare.bounces", *given, kFurtherLight);
  run.add_flag_function(
         "--no-filter",
         [given](std::int64_t) { given->assignments.emplace_back("pipeline.filter=off"); },
         "each frame's own light, not averaged over time")
      ->group(kLight);
  // They would have no effect, but for frames whose line gives no sky or no sun's direction: for
  // these there is --set.
  for (const char* estimates : {"--weather", "--samples", "--no-filter"}) {
    lighting->excludes(run.get_option(estimates));
  }
  AddQuality(run, *given);
  AddEffects(run, options->pipeline.effects);
  AddSettingOption(run, "--budget", "pipeline.effects.budget_ms", *given, kPicture);
  AddSettings(run, *given);
  AddCameraOptions(run, options->camera);
  AddPictureTimes(run, options->times, kTimes);
  run.parse_complete_callback([options, given] {
    given->ApplyTo(*options);
    if (options->picture_stream == "y4m:-" && options->lighting_stream == "-") {
      throw std::invalid_argument("--stream and --lighting-stream: both are standard output");
    }
    if (options->sequence.empty()) {
      if (IsCameraName(options->input)) {
        throw std::invalid_argument(options->input +
                                    ": expected --site, the folder that describes where this "
                                    "camera stands");
      }
      options->sequence = std::exchange(options->input, {});
    }
  });
  run.callback([options, &work] {
    work = [options] {
      RunRunCommand(*options);
      return 0;
    };
  });
}

}  // namespace pleinair
