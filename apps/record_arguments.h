// The arguments of `pleinair record`.
#pragma once

#include "apps/arguments.h"

namespace pleinair {

// Adds the command to `app`; `work` is set when the command is given.
void AddRecord(CLI::App& app, Work& work);

}  // namespace pleinair
