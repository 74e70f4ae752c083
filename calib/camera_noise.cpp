#include "calib/camera_noise.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace pleinair {

void CameraNoise::Validate() const {
  if (!(full_well_electrons > 0.0) || !std::isfinite(full_well_electrons)) {
    throw std::invalid_argument("full_well_electrons " + std::to_string(full_well_electrons) +
                                ": expected a positive number");
  }
  // Without any noise a measurement of 0 would have an infinite weight.
  if (!(read_noise_electrons > 0.0) || !std::isfinite(read_noise_electrons)) {
    throw std::invalid_argument("read_noise_electrons " + std::to_string(read_noise_electrons) +
                                ": expected a positive number");
  }
}

double CameraNoise::Variance(double linear) const {
  return (linear * full_well_electrons + read_noise_electrons * read_noise_electrons) /
         (full_well_electrons * full_well_electrons);
}

SignalNoise::SignalNoise(const ResponseCurve& response, const CameraNoise& camera)
    : camera_(camera) {
  camera.Validate();
  for (int c = 0; c < 3; ++c) {
    const std::array<float, 256>& linear = response.LinearOfCode(c);
    const auto channel = static_cast<std::size_t>(c);
    clipped_from_[channel] = double{linear[kClippedFromCode]};
    for (std::size_t level = 0; level < kLevels; ++level) {
      const float signal = static_cast<float>(level) / static_cast<float>(kLevels - 1);
      const std::size_t code = response.CodeFromLinear(glm::vec3(signal))[c];
      // From halfway to the code below to halfway to the one above.
      const std::size_t below = std::max<std::size_t>(code, 1) - 1;
      const std::size_t above = std::min<std::size_t>(code + 1, 255);
      const float step = (linear[above] - linear[below]) / static_cast<float>(above - below);
      rounding_variance_[channel][level] = step * step / 12.0f;
    }
  }
}

double SignalNoise::Variance(int channel, double signal) const {
  // Negated so that NaN is caught, too.
  const double inside = !(signal > 0.0) ? 0.0 : std::min(signal, 1.0);
  const auto level = static_cast<std::size_t>(std::lround(inside * double{kLevels - 1}));
  return camera_.Variance(inside) +
         double{rounding_variance_.at(static_cast<std::size_t>(channel))[level]};
}

}  // namespace pleinair
