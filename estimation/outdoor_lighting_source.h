// Sun and sky from the diffuse walls and paving that the camera sees (jensen-2006, section 3.1).
#pragma once

#include <cstdint>
#include <memory>

#include "estimation/lighting_source.h"

namespace pleinair {

struct OutdoorLightingOptions {
  int samples = 500;  // Asked for; fewer where the view does not hold them. 1 .. 100000.
  std::uint64_t seed = 1;
  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

std::unique_ptr<LightingSource> MakeOutdoorLightingSource(const OutdoorLightingOptions& options);

}  // namespace pleinair
