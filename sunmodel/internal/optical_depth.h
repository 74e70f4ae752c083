// Optical depth of a cloudless atmosphere for a vertical beam, in our three bands.
#pragma once

#include <array>
#include <cmath>

namespace pleinair {

inline constexpr std::array<double, 3> kBandWavelengthUm{0.610, 0.550, 0.460};

// Optical depth of the air itself at sea level. Source: Bird and Riordan, SERI/TR-215-2436, 1984,
// equation 2-4.
inline double RayleighOpticalDepth(double wavelength_um) {
  const double um2 = wavelength_um * wavelength_um;
  return 1.0 / (um2 * um2 * (115.6406 - 1.335 / um2));
}

// Optical depth of rural haze. Source: the same, equation 2-7.
inline double AerosolOpticalDepth(double depth_500nm, double wavelength_um) {
  constexpr double kAngstromExponent = 1.14;
  return depth_500nm * std::pow(wavelength_um / 0.5, -kAngstromExponent);
}

// Mean cosine of the angle that such haze scatters by; the same source.
inline constexpr double kAerosolAsymmetry = 0.65;

}  // namespace pleinair
