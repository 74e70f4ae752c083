// `pleinair run` of a camera: composites while it streams.
#pragma once

#include "apps/run_command.h"

namespace pleinair {

// Until the stream ends, the time or number of frames that was asked for is over, or SIGINT or
// SIGTERM comes. The camera is read, frames are composited and results are written on a thread
// each. Throws as RunRunCommand.
void RunLiveCommand(RunCommandOptions options);

}  // namespace pleinair
