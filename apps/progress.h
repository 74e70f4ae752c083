// Progress of long work, on standard error.
#pragma once

#include "relight/prepared_scene.h"

namespace pleinair {

// Prints each stage as it starts and ends, and on a terminal its share done in between.
Progress ProgressOnStandardError();

}  // namespace pleinair
