// The table of settings.
#pragma once

#include <vector>

#include "session/settings.h"

namespace pleinair::internal {

// See Settings().
std::vector<Setting> MakeSettings();

}  // namespace pleinair::internal
