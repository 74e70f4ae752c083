// The arguments of `pleinair regress` and `pleinair tradeoff`.
#pragma once

#include "apps/arguments.h"

namespace pleinair {

// Add the command to `app`; `work` is set when the command is given.
void AddRegress(CLI::App& app, Work& work);
void AddTradeoff(CLI::App& app, Work& work);

}  // namespace pleinair
