#include "apps/pose_arguments.h"

#include <CLI/CLI.hpp>

namespace pleinair {

void AddPoseSources(CLI::App& command, SessionOptions& options, const std::string& group) {
  command
      .add_option("--markers",
                  options.markers,
                  "board file of `calibrate markers`: camera poses come from the markers in the "
                  "frames")
      ->type_name("FILE")
      ->group(group);
  command
      .add_option(
          "--poses",
          options.poses,
          "camera poses from outside, a line of JSON each: a file, a pipe or -; while a camera "
          "streams also shm:NAME (docs/live.md)")
      ->type_name("SOURCE")
      ->group(group);
}

}  // namespace pleinair
