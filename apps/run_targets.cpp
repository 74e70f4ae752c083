#include "apps/run_targets.h"

namespace pleinair {

RunTargets::RunTargets(const RunCommandOptions& options, std::optional<double> camera_rate)
    : folder(options.out) {
  // Under a result's name it would be removed with the earlier run's.
  RequireKept(
      options.picture_stream.substr(options.picture_stream.find(':') + 1), options.out, "--stream");
  RequireKept(options.lighting_stream, options.out, "--lighting-stream");
  if (!options.picture_stream.empty()) {
    constexpr double kUsualRate = 30.0;
    pictures.emplace(
        options.picture_stream, camera_rate.value_or(kUsualRate), end_of_readers.get_token());
  }
  if (!options.lighting_stream.empty()) {
    lines.emplace(options.lighting_stream, end_of_readers.get_token());
  }
}

}  // namespace pleinair
