#include "apps/record_arguments.h"

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>

#include "apps/camera_arguments.h"
#include "apps/one_of.h"
#include "apps/picture_times_arguments.h"
#include "apps/record_command.h"

namespace pleinair {

void AddRecord(CLI::App& app, Work& work) {
  auto options = std::make_shared<RecordCommandOptions>();
  CLI::App& record = *app.add_subcommand(
      "record", "A camera's pictures at a site as a sequence, which `run` plays");
  record.footer("Example: pleinair record /dev/video0 --site mysite --out monday --every 10s");
  record
      .add_option("camera",
                  options->camera,
                  "device, as `pleinair cameras` lists it; or a site that names its camera")
      ->type_name("DEVICE|SITE")
      ->required();
  record
      .add_option("--site",
                  options->site,
                  "folder with site.json, or a sequence's: its camera, place and mesh make the "
                  "recording a sequence; they are copied")
      ->type_name("FOLDER");
  record.add_option("--out", options->recorder.recording.folder, "folder to make for the sequence")
      ->type_name("FOLDER")
      ->required();
  record
      .add_option("--store",
                  options->recorder.recording.store,
                  "raw: a file a picture (MJPEG and Bayer as they come, else PNG); ffv1: lossless "
                  "video; h264: video to look at (default: raw)")
      ->transform(OneOf<PictureStore>({{"raw", PictureStore::kRaw},
                                       {"ffv1", PictureStore::kFfv1},
                                       {"h264", PictureStore::kH264}}))
      ->type_name("FORM")
      ->default_str("");
  record
      .add_option_function<std::string>(
          "--every",
          [options](const std::string& text) {
            options->recorder.interval = ParseInterval(text, "--every");
          },
          "time from a recorded picture to the next, such as 10s or 2min (default: all pictures)")
      ->type_name("TIME");
  record
      .add_option("--duration", options->duration_s, "seconds to record (default: until stopped)")
      ->check(Positive().description(""))
      ->type_name("SECONDS");
  record.add_option("--frames-limit", options->frames_limit, "pictures to record at most")
      ->check(CLI::Range(1, 1'000'000'000).description(""))
      ->type_name("N");
  AddCameraOptions(record, options->request);
  record.parse_complete_callback([options] {
    if (!options->site.empty()) return;
    if (IsCameraName(options->camera)) {
      throw std::invalid_argument(
          "record: expected --site FOLDER, as a sequence needs its camera's calibration, its place "
          "and a mesh");
    }
    options->site = std::exchange(options->camera, {});
  });
  record.callback([options, &work] { work = [options] { return RunRecordCommand(*options); }; });
}

}  // namespace pleinair
