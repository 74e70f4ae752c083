#include "apps/record_arguments.h"

#include <chrono>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>

#include <CLI/CLI.hpp>

#include "apps/camera_arguments.h"
#include "apps/record_command.h"

namespace pleinair {
namespace {

// "10s", "2min", "0.5": seconds.
double ParseInterval(const std::string& text) {
  double number = 0.0;
  std::size_t end = 0;
  try {
    number = std::stod(text, &end);
  } catch (const std::exception&) {
    end = 0;
  }
  const std::string unit = text.substr(end);
  const double seconds = unit.empty() || unit == "s" ? 1.0
                         : unit == "min"             ? 60.0
                         : unit == "h"               ? 3600.0
                                                     : 0.0;
  // A day at most: what is longer has no picture of each day's light.
  constexpr double kLongest = 86400.0;
  if (end == 0 || !(number * seconds > 0.0) || !(number * seconds <= kLongest)) {
    throw std::invalid_argument("--every '" + text +
                                "': expected a time above 0, of a day at most: 10s, 2min, 1h");
  }
  return number * seconds;
}

}  // namespace

void AddRecord(CLI::App& app, Work& work) {
  auto options = std::make_shared<RecordCommandOptions>();
  CLI::App& record = *app.add_subcommand(
      "record", "A camera's pictures at a site as a sequence, which `run` plays");
  record.footer("Example: pleinair record /dev/video0 --site mysite --out monday --every 10s");
  record.add_option("camera", options->camera, "device, as `pleinair cameras` lists it")
      ->type_name("DEVICE")
      ->required();
  record
      .add_option(
          "--site",
          options->site,
          "folder with site.json, or a sequence's: camera, place and mesh, which a sequence "
          "needs; copied into the recording")
      ->type_name("FOLDER")
      ->required();
  record.add_option("--out", options->recorder.recording.folder, "folder to make for the sequence")
      ->type_name("FOLDER")
      ->required();
  record
      .add_option("--store",
                  options->recorder.recording.store,
                  "raw: a file a picture (MJPEG and Bayer as they come, else PNG); ffv1: lossless "
                  "video; h264: video to look at (default: raw)")
      ->transform(CLI::CheckedTransformer(
                      std::map<std::string, PictureStore>{{"raw", PictureStore::kRaw},
                                                          {"ffv1", PictureStore::kFfv1},
                                                          {"h264", PictureStore::kH264}})
                      .description(""))
      ->type_name("FORM")
      ->default_str("");
  record
      .add_option_function<std::string>(
          "--every",
          [options](const std::string& text) {
            options->recorder.interval =
                std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * ParseInterval(text)));
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
  record.callback([options, &work] { work = [options] { return RunRecordCommand(*options); }; });
}

}  // namespace pleinair
