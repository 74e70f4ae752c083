// When the shutter is open, for frames that do not state it.
#pragma once

namespace pleinair {

// In seconds.
struct MotionBlurOptions {
  double exposure_s = 0.0;  // 0: no motion blur.
  double readout_s = 0.0;   // From the first row's exposure to the last one's; 0: all at once.
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

}  // namespace pleinair
