// The arguments of `pleinair site import`.
#pragma once

#include "apps/arguments.h"

namespace pleinair {

// Adds the command to `site`; `work` is set when the command is given.
void AddSiteImportCommand(CLI::App& site, Work& work);

}  // namespace pleinair
