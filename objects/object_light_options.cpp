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

void GatherInMotionOptions::Validate() const {
  const auto require = [](const char* name, int value) {
    if (value >= 0) return;
    throw std::invalid_argument(std::string("GatherInMotionOptions::") + name + " is " +
                                std::to_string(value) + ": expected 0 or more");
  };
  require("vertices_per_frame", vertices_per_frame);
  require("vertices_at_rest", vertices_at_rest);
  require("rays_at_first", rays_at_first);
}

void ObjectLightOptions::Validate() const {
  in_motion.Validate();
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
