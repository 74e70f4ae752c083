// The faults that `--fault` names.
#pragma once

#include <string>
#include <vector>

#include "apps/camera_stand_in/device_state.h"

namespace pleinair::stand_in {

// The names that `--fault` takes, for its help text.
std::string FaultNames();

// In the order in which they strike.
struct FaultList {
  std::vector<Fault> faults;
  bool count_pictures = false;  // Their clock is the number of pictures taken, and not time in ns.
};

// NAME@SECONDS,..., or NAME@Np,... for after N pictures; and random:SEED:COUNT in place of NAME,
// which stands for COUNT faults of all kinds but stall-forever at random moments before that.
// Throws std::invalid_argument naming the part that is wrong.
FaultList ParseFaults(const std::string& text);

}  // namespace pleinair::stand_in
