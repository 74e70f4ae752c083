// The arguments of `pleinair run`.
#pragma once

#include "apps/arguments.h"

namespace pleinair {

// Adds the command to `app`; `work` is set when the command is given.
void AddRun(CLI::App& app, Work& work);

}  // namespace pleinair
