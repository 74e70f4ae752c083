#include "pipeline/motion_blur_options.h"

#include <stdexcept>
#include <string>

namespace pleinair {

void MotionBlurOptions::Validate() const {
  const auto require = [](const char* name, double seconds) {
    if (seconds >= 0.0 && seconds <= 60.0) return;
    throw std::invalid_argument(std::string("motion_blur.") + name + " is " +
                                std::to_string(seconds) + ": expected 0 to 60 seconds");
  };
  require("exposure_s", exposure_s);
  require("readout_s", readout_s);
}

}  // namespace pleinair
