// The faults that `--fault` names.
#pragma once

#include <string>
#include <vector>

#include "apps/camera_stand_in/device_state.h"

namespace pleinair::stand_in {

// The names that `--fault` takes, for its help text.
std::string FaultNames();

// NAME@SECONDS,... and random:SEED:COUNT@SECONDS, which stands for COUNT faults of all kinds but
// stall-forever at random moments before SECONDS. By time.
// Throws std::invalid_argument naming the part that is wrong.
std::vector<Fault> ParseFaults(const std::string& text);

}  // namespace pleinair::stand_in
