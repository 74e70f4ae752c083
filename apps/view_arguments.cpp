#include "apps/view_arguments.h"

#include <memory>
#include <stdexcept>
#include <utility>

#include <CLI/CLI.hpp>

#include "apps/camera_arguments.h"
#include "apps/picture_times_arguments.h"
#include "apps/pose_arguments.h"
#include "apps/settings_arguments.h"
#include "apps/viewer/view_command.h"

namespace pleinair {

void AddView(CLI::App& app, Work& work) {
  constexpr const char* kInput = "Input";
  auto options = std::make_shared<ViewCommandOptions>();
  auto given = std::make_shared<GivenSettings>();
  CLI::App& view = *app.add_subcommand("view", "A window: composites, light over time, objects");
  view.footer("Example: pleinair view datasets/samples/courtyard");
  view.add_option("input",
                  options->input,
                  "folder with sequence.json; with --site a camera (`pleinair cameras` lists "
                  "them), a video, a picture or a folder of pictures")
      ->type_name("INPUT")
      ->required();
  view.add_option("--site",
                  options->sequence,
                  "folder with site.json, or a sequence's: where the input was taken")
      ->type_name("FOLDER")
      ->group(kInput);
  AddSettingOption(view, "--frames", "frames", *given, kInput);
  AddSettingOption(view, "--source", "source", *given, kInput);
  AddSettingOption(view, "--weather", "weather", *given, kInput);
  AddPoseSources(view, *options, kInput);
  view.add_option("--lighting",
                  options->lighting,
                  "a lighting.jsonl whose light is used in place of an estimate")
      ->type_name("FILE")
      ->group(kInput)
      ->excludes(view.get_option("--weather"));
  AddCache(view, options->cache)->group(kInput);
  view.add_option("--out", options->out, "folder for snapshots and recordings (default: here)")
      ->type_name("FOLDER")
      ->default_str("");
  view.add_flag_callback(
      "--as-new",
      [options] { options->restores_state = false; },
      "opens as the first time: neither restores nor keeps the window's state");
  AddSettings(view, *given);
  AddCameraOptions(view, options->camera);
  AddPictureTimes(view, options->times, kInput);
  view.parse_complete_callback([options, given] {
    options->stated_settings = given->ApplyTo(*options);
    if (!options->sequence.empty()) return;
    if (IsCameraName(options->input)) {
      throw std::invalid_argument(options->input +
                                  ": expected --site, the folder that describes where this camera "
                                  "stands");
    }
    options->sequence = std::exchange(options->input, {});
  });
  view.callback([options, &work] {
    work = [options] {
      RunViewCommand(*options);
      return 0;
    };
  });
}

}  // namespace pleinair
