#include "sunmodel/sky_luminance.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <glm/geometric.hpp>

#include "sunmodel/internal/number_text.h"
#include "sunmodel/internal/optical_depth.h"
#include "sunmodel/refraction.h"

namespace pleinair {
namespace {

// The direction of a sun that has set is lifted to the horizon.
glm::dvec3 AboveHorizon(const glm::dvec3& direction_enu) {
  if (direction_enu.z >= 0.0) return direction_enu;
  const double level = std::hypot(direction_enu.x, direction_enu.y);
  if (!(level > 0.0)) return {0.0, 1.0, 0.0};  // At the nadir any azimuth is as good.
  return {direction_enu.x / level, direction_enu.y / level, 0.0};
}

double AirMassTowards(const glm::dvec3& direction_enu) {
  return RelativeAirMass(std::atan2(direction_enu.z, std::hypot(direction_enu.x, direction_enu.y)));
}

// Phase functions: over 4 pi they are the share of the scattered light per steradian at an angle.
double RayleighPhase(double cosine) { return 0.75 * (1.0 + cosine * cosine); }
double HazePhase(double cosine) {
  constexpr double g = kAerosolAsymmetry;
  const double spread = 1.0 + g * g - 2.0 * g * cosine;
  return (1.0 - g * g) / (spread * std::sqrt(spread));
}

// Light that a layer of depth 1 and phase 1 scatters towards the ground: the integral over the
// layer of light that enters by air mass `in` and leaves by `out`,
//   out (e^(-depth in) - e^(-depth out)) / (out - in) / depth, even where the two masses meet.
double ScatteredShare(double depth, double in, double out) {
  const double apart = std::abs(out - in) * depth;
  const double share = apart > 1e-8 ? -std::expm1(-apart) / apart : 1.0;
  return out * std::exp(-depth * std::min(in, out)) * share;
}

}  // namespace

double OvercastSkyLuminance(const glm::dvec3& direction_enu) {
  return direction_enu.z > 0.0 ? (1.0 + 2.0 * direction_enu.z) / 3.0 : 0.0;
}

ClearSkyDistribution::ClearSkyDistribution(const glm::dvec3& sun_direction_enu,
                                           double aerosol_optical_depth_500nm) {
  const double length = glm::length(sun_direction_enu);
  if (!(length > 0.0) || !std::isfinite(length)) {
    throw std::invalid_argument("sun_direction_enu: expected a finite direction that is not zero");
  }
  if (!(aerosol_optical_depth_500nm >= 0.0 && aerosol_optical_depth_500nm <= 5.0)) {
    throw std::invalid_argument("aerosol_optical_depth_500nm is " +
                                NumberText(aerosol_optical_depth_500nm) + ", expected 0 to 5");
  }
  sun_direction_enu_ = AboveHorizon(sun_direction_enu / length);
  sun_air_mass_ = AirMassTowards(sun_direction_enu_);
  for (int c = 0; c < 3; ++c) {
    const double um = kBandWavelengthUm[static_cast<std::size_t>(c)];
    air_depth_[c] = RayleighOpticalDepth(um);
    haze_depth_[c] = AerosolOpticalDepth(aerosol_optical_depth_500nm, um);
  }
}

glm::dvec3 ClearSkyDistribution::Radiance(const glm::dvec3& direction_enu) const {
  if (!(direction_enu.z > 0.0)) return glm::dvec3(0.0);
  const double cosine = glm::dot(direction_enu, sun_direction_enu_);
  const double air_mass = AirMassTowards(direction_enu);
  const glm::dvec3 scattered = air_depth_ * RayleighPhase(cosine) + haze_depth_ * HazePhase(cosine);
  glm::dvec3 radiance;
  for (int c = 0; c < 3; ++c) {
    radiance[c] =
        scattered[c] * ScatteredShare(air_depth_[c] + haze_depth_[c], sun_air_mass_, air_mass);
  }
  return radiance;
}

}  // namespace pleinair
