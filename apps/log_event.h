// Events of a camera in the log.
#pragma once

#include "datasets/event.h"

namespace pleinair {

// A warning, unless it is of those that every run has.
void LogEvent(const Event& event);

}  // namespace pleinair
