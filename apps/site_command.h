// The arguments of `pleinair site` and its subcommands.
#pragma once

#include "apps/arguments.h"

namespace pleinair {

// Adds the command to `app`; `work` is set when the command is given.
void AddSite(CLI::App& app, Work& work);

}  // namespace pleinair
