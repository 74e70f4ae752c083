#include "sunmodel/sky_luminance.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace pleinair {
namespace {

using Cubic = std::array<double, 4>;  // Coefficients of t^3, t^2, t, 1.

double Value(const Cubic& c, double t) { return ((c[0] * t + c[1]) * t + c[2]) * t + c[3]; }

// Zenith chromaticity: T^2, T and 1 times cubics in the sun's zenith angle.
double ZenithChromaticity(const std::array<Cubic, 3>& rows, double turbidity, double sun_zenith) {
  return (Value(rows[0], sun_zenith) * turbidity + Value(rows[1], sun_zenith)) * turbidity +
         Value(rows[2], sun_zenith);
}

constexpr std::array<Cubic, 3> kZenithX{{{0.00166, -0.00375, 0.00209, 0.0},
                                         {-0.02903, 0.06377, -0.03202, 0.00394},
                                         {0.11693, -0.21196, 0.06052, 0.25886}}};
constexpr std::array<Cubic, 3> kZenithY{{{0.00275, -0.00610, 0.00317, 0.0},
                                         {-0.04214, 0.08970, -0.04153, 0.00516},
                                         {0.15346, -0.26756, 0.06670, 0.26688}}};

// IEC 61966-2-1.
glm::dvec3 Rec709FromXyz(const glm::dvec3& xyz) {
  return {3.2406 * xyz.x - 1.5372 * xyz.y - 0.4986 * xyz.z,
          -0.9689 * xyz.x + 1.8758 * xyz.y + 0.0415 * xyz.z,
          0.0557 * xyz.x - 0.2040 * xyz.y + 1.0570 * xyz.z};
}

// The direction of a sun that has set is lifted to the horizon.
glm::dvec3 AboveHorizon(const glm::dvec3& direction_enu) {
  if (direction_enu.z >= 0.0) return direction_enu;
  const double level = std::hypot(direction_enu.x, direction_enu.y);
  if (!(level > 0.0)) return {0.0, 1.0, 0.0};  // At the nadir any azimuth is as good.
  return {direction_enu.x / level, direction_enu.y / level, 0.0};
}

}  // namespace

double OvercastSkyLuminance(const glm::dvec3& direction_enu) {
  return direction_enu.z > 0.0 ? (1.0 + 2.0 * direction_enu.z) / 3.0 : 0.0;
}

double ClearSkyDistribution::Perez::At(double cos_zenith,
                                       double cos_to_sun,
                                       double angle_to_sun_rad) const {
  const auto& [a, b, c, d, e] = abcde;
  return (1.0 + a * std::exp(b / cos_zenith)) *
         (1.0 + c * std::exp(d * angle_to_sun_rad) + e * cos_to_sun * cos_to_sun);
}

ClearSkyDistribution::ClearSkyDistribution(const glm::dvec3& sun_direction_enu, double turbidity) {
  const double length = glm::length(sun_direction_enu);
  if (!(length > 0.0) || !std::isfinite(length)) {
    throw std::invalid_argument("sun_direction_enu: expected a finite direction that is not zero");
  }
  if (!(turbidity >= 1.8 && turbidity <= 10.0)) {
    throw std::invalid_argument(std::string("turbidity ") + std::to_string(turbidity) +
                                ": expected 1.8 .. 10");
  }
  sun_direction_enu_ = AboveHorizon(sun_direction_enu / length);
  const double t = turbidity;
  const double sun_zenith =
      std::atan2(std::hypot(sun_direction_enu_.x, sun_direction_enu_.y), sun_direction_enu_.z);
  auto& [luminance, x, y] = luminance_and_chromaticity_;
  luminance.abcde = {0.1787 * t - 1.4630,
                     -0.3554 * t + 0.4275,
                     -0.0227 * t + 5.3251,
                     0.1206 * t - 2.5771,
                     -0.0670 * t + 0.3703};
  x.abcde = {-0.0193 * t - 0.2592,
             -0.0665 * t + 0.0008,
             -0.0004 * t + 0.2125,
             -0.0641 * t - 0.8989,
             -0.0033 * t + 0.0452};
  y.abcde = {-0.0167 * t - 0.2608,
             -0.0950 * t + 0.0092,
             -0.0079 * t + 0.2102,
             -0.0441 * t - 1.6537,
             -0.0109 * t + 0.0529};
  luminance.zenith_value = 1.0;  // Only ratios are promised.
  x.zenith_value = ZenithChromaticity(kZenithX, t, sun_zenith);
  y.zenith_value = ZenithChromaticity(kZenithY, t, sun_zenith);
  for (Perez& part : luminance_and_chromaticity_) {
    part.zenith_value /= part.At(1.0, sun_direction_enu_.z, sun_zenith);
  }
}

glm::dvec3 ClearSkyDistribution::Radiance(const glm::dvec3& direction_enu) const {
  if (!(direction_enu.z > 0.0)) return glm::dvec3(0.0);
  const double cos_to_sun = glm::dot(direction_enu, sun_direction_enu_);
  const double angle_to_sun =
      std::atan2(glm::length(glm::cross(direction_enu, sun_direction_enu_)), cos_to_sun);
  const auto at = [&](const Perez& part) {
    return part.zenith_value * part.At(direction_enu.z, cos_to_sun, angle_to_sun);
  };
  const auto& [luminance, chromaticity_x, chromaticity_y] = luminance_and_chromaticity_;
  const double x = at(chromaticity_x);
  const double y = at(chromaticity_y);
  const double big_y = at(luminance);
  const glm::dvec3 xyz(x / y * big_y, big_y, (1.0 - x - y) / y * big_y);
  return glm::max(Rec709FromXyz(xyz), glm::dvec3(0.0));
}

}  // namespace pleinair
