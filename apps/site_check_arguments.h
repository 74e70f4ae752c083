// The arguments of `pleinair site check`.
#pragma once

#include "apps/arguments.h"

namespace pleinair {

void AddSiteCheckCommand(CLI::App& site, Work& work);

}  // namespace pleinair
