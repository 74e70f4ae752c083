// The arguments of `pleinair site mask`.
#pragma once

#include "apps/arguments.h"

namespace pleinair {

void AddSiteMaskCommand(CLI::App& site, Work& work);

}  // namespace pleinair
