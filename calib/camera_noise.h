// The noise of one pixel of an 8-bit camera.
#pragma once

#include <array>
#include <cstddef>

#include "calib/response.h"

namespace pleinair {

// Noise of a pixel's value as a share of a full well, which is the value 1. By default that of a
// consumer camera at its base sensitivity.
struct CameraNoise {
  double full_well_electrons = 16000.0;
  double read_noise_electrons = 7.0;

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
  // Variance of a measurement whose true value is `linear`, without the rounding to a code.
  double Variance(double linear) const;
};

// Shot noise, read noise and the rounding to a code, by EMVA 1288's linear camera model:
//   variance(signal) = (signal * full_well + read_noise^2) / full_well^2 + step(signal)^2 / 12,
// in units of the signal, 0 to 1; step is the width of the code there. Neighbouring pixels are
// treated as independent; demosaicing and compression correlate them.
class SignalNoise {
 public:
  explicit SignalNoise(const ResponseCurve& response, const CameraNoise& camera = {});

  // Variance of a pixel whose mean signal is `signal`. Do not pass noisy values: weights from these
  // would favour the dark ones. Signals outside [0, 1] count as its ends.
  double Variance(int channel, double signal) const;

  // Signals from here on are clipped (kClippedFromCode).
  double ClippedFrom(int channel) const {
    return clipped_from_.at(static_cast<std::size_t>(channel));
  }

 private:
  static constexpr std::size_t kLevels = 4096;  // sRGB's narrowest code is 1.2 of them.

  CameraNoise camera_;
  std::array<double, 3> clipped_from_{};
  std::array<std::array<float, kLevels>, 3> rounding_variance_{};  // By signal.
};

}  // namespace pleinair
