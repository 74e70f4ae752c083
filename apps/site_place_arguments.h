// The arguments of `pleinair site place`.
#pragma once

#include "apps/arguments.h"

namespace pleinair {

void AddSitePlaceCommand(CLI::App& site, Work& work);

}  // namespace pleinair
