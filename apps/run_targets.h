// What a run writes to, opened before it prepares anything: a target that is wrong is said at once.
#pragma once

#include <optional>
#include <stop_token>

#include "apps/line_stream.h"
#include "apps/picture_stream.h"
#include "apps/run_command.h"
#include "apps/run_folder.h"

namespace pleinair {

// What an earlier run left there stays.
struct RunTargets {
  // `camera_rate`: frames a second, where a camera states it. Throws std::runtime_error, one line
  // with the target.
  explicit RunTargets(const RunCommandOptions& options,
                      std::optional<double> camera_rate = std::nullopt);

  FolderLock folder;
  std::stop_source end_of_readers;  // Once requested, a reader has a second to read.
  std::optional<PictureStream> pictures;
  std::optional<LineStream> lines;
};

}  // namespace pleinair
