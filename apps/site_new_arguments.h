// The arguments of `pleinair site new`.
#pragma once

#include "apps/arguments.h"

namespace pleinair {

void AddSiteNewCommand(CLI::App& site, Work& work);

}  // namespace pleinair
