// The arguments of `pleinair calibrate` and its subcommands.
#pragma once

#include "apps/arguments.h"

namespace pleinair {

// Adds the command to `app`; `work` is set when the command is given.
void AddCalibrate(CLI::App& app, Work& work);

}  // namespace pleinair
