#include "objects/object_light_options.h"

#include <stdexcept>
#include <string>

namespace pleinair {

void SingleProbeOptions::Validate() const {
  if (rays < 1 || rays > (1 << 20)) {
    throw std::invalid_argument("SingleProbeOptions::rays is " + std::to_string(rays) +
                                ": expected 1 to 1048576");
  }
  if (sh_bands < 1 || sh_bands > kMostShBands) {
    throw std::invalid_argument("SingleProbeOptions::sh_bands is " + std::to_string(sh_bands) +
                                ": expected 1 to " + std::to_string(kMostShBands));
  }
}

void ObjectLightOptions::Validate() const {
  if (daylight == Daylight::kSamples) {
    direct_daylight.Validate();
    if (route == ObjectLight::kSingleProbe) {
      throw std::invalid_argument(
          "object_light is at a single probe with daylight by samples: expected gathered daylight");
    }
  }
  single_probe.Validate();
}

}  // namespace pleinair
