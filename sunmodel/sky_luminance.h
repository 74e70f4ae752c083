// How bright a sky is in one direction relative to others: overcast and cloudless skies.
#pragma once

#include <array>

#include <glm/vec3.hpp>

namespace pleinair {

// The CIE's overcast sky: three times as bright at the zenith as at the horizon. Relative; 0 below
// the horizon. A vertical wall before it gets 0.396 of the horizontal irradiance.
//
// Source     Moon and Spencer, Illuminating Engineering 37, 1942; ISO 15469, type 16.
double OvercastSkyLuminance(const glm::dvec3& direction_enu);

// A cloudless sky in three channels: darkest a right angle from the sun, brighter and whiter
// towards the horizon and around the sun.
//
// Source     The form of Perez, Seals and Michalsky, Solar Energy 50(3), 1993, equation 1, with the
//            coefficients of Preetham, Shirley and Smits, SIGGRAPH 1999, appendix A.2, for
//            luminance and chromaticity, taken to linear Rec.709.
// Accuracy   Real cloudless skies differ by their haze, most within 30 deg of the sun.
// Continuous in the sun's direction; a sun below the horizon counts as one on it.
class ClearSkyDistribution {
 public:
  // Clear, dry air; 1 would be air without any haze.
  static constexpr double kDefaultTurbidity = 2.5;
  // Throws std::invalid_argument for a direction that is not finite or zero, or a turbidity outside
  // [1.8, 10], where the coefficients hold.
  explicit ClearSkyDistribution(const glm::dvec3& sun_direction_enu,
                                double turbidity = kDefaultTurbidity);

  // Relative within and between channels, >= 0; 0 on and below the horizon. `direction_enu` is
  // unit.
  glm::dvec3 Radiance(const glm::dvec3& direction_enu) const;

 private:
  // Of one of Y, x, y.
  struct Perez {
    std::array<double, 5> abcde{};
    double zenith_value = 0.0;  // Divided by the form's own value at the zenith.
    double At(double cos_zenith, double cos_to_sun, double angle_to_sun_rad) const;
  };
  glm::dvec3 sun_direction_enu_;
  std::array<Perez, 3> luminance_and_chromaticity_;
};

}  // namespace pleinair
