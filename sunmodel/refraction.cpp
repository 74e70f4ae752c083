#include "sunmodel/refraction.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include <glm/geometric.hpp>

#include "sunmodel/angles.h"
#include "sunmodel/internal/number_text.h"

namespace pleinair {
namespace {

constexpr double kFadeStartDeg = -1.0;
constexpr double kFadeEndDeg = -2.0;

void CheckElevation(const char* field, double elevation_rad) {
  CheckRange(field, elevation_rad, -std::numbers::pi / 2.0, std::numbers::pi / 2.0);
}

// Refraction in degrees, at 1010 hPa and 10 C.
double SaemundssonDeg(double airless_deg) {
  return 1.02 / 60.0 / std::tan(RadFromDeg(airless_deg + 10.3 / (airless_deg + 5.11)));
}

double SmoothStep(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

}  // namespace

void Atmosphere::Validate() const {
  CheckRange("atmosphere: pressure_hpa", pressure_hpa, 0.0, 1200.0);
  CheckRange("atmosphere: temperature_c", temperature_c, -150.0, 100.0);
}

Atmosphere StandardAtmosphere(double height_m) {
  Site{0.0, 0.0, height_m}.Validate();
  // Geopotential height: gravity weakens with height (ISO 2533, equation 8 and its radius).
  constexpr double kEarthRadiusM = 6356766.0;
  const double h_m = kEarthRadiusM * height_m / (kEarthRadiusM + height_m);

  constexpr double kSeaTemperatureK = 288.15;
  constexpr double kLapseKPerM = 0.0065;
  constexpr double kTropopauseM = 11000.0;
  constexpr double kGravityTimesMassOverGasConstantKPerM = 9.80665 / 287.05287;
  constexpr double kKelvin = 273.15;

  const double troposphere_m = std::min(h_m, kTropopauseM);
  const double temperature_k = kSeaTemperatureK - kLapseKPerM * troposphere_m;
  const double lapse_pressure_hpa =
      kSeaLevelPressureHpa * std::pow(temperature_k / kSeaTemperatureK,
                                      kGravityTimesMassOverGasConstantKPerM / kLapseKPerM);
  const double above_m = h_m - troposphere_m;
  return {lapse_pressure_hpa *
              std::exp(-kGravityTimesMassOverGasConstantKPerM * above_m / temperature_k),
          temperature_k - kKelvin};
}

double RefractionRad(double airless_elevation_rad, const Atmosphere& atmosphere) {
  CheckElevation("airless_elevation_rad", airless_elevation_rad);
  atmosphere.Validate();
  const double airless_deg = DegFromRad(airless_elevation_rad);
  if (airless_deg <= kFadeEndDeg) return 0.0;
  // Saemundsson's form is -0.1 arc seconds at the zenith. Taking that off everywhere leaves none
  // there, and a refraction proportional to the zenith distance near it.
  const double lift_deg = SaemundssonDeg(airless_deg) - SaemundssonDeg(90.0);
  const double density =
      atmosphere.pressure_hpa / 1010.0 * 283.0 / (273.0 + atmosphere.temperature_c);
  const double lift_rad =
      RadFromDeg(density * lift_deg * SmoothStep(kFadeEndDeg, kFadeStartDeg, airless_deg));
  return std::clamp(lift_rad, 0.0, std::numbers::pi / 2.0 - airless_elevation_rad);
}

glm::dvec3 ApparentDirection(const glm::dvec3& airless_direction_enu,
                             const Atmosphere& atmosphere) {
  const double length = glm::length(airless_direction_enu);
  if (!(length > 0.0) || !std::isfinite(length)) {
    throw std::invalid_argument("airless_direction_enu has length " + NumberText(length) +
                                ", expected a unit direction");
  }
  const glm::dvec3 airless = airless_direction_enu / length;
  const double horizontal = std::hypot(airless.x, airless.y);
  const double lift_rad = RefractionRad(std::atan2(airless.z, horizontal), atmosphere);
  if (lift_rad == 0.0 || horizontal == 0.0) return airless;
  const double c = std::cos(lift_rad);
  const double s = std::sin(lift_rad);
  const double scale = (horizontal * c - airless.z * s) / horizontal;
  return glm::normalize(
      glm::dvec3(airless.x * scale, airless.y * scale, airless.z * c + horizontal * s));
}

double RelativeAirMass(double apparent_elevation_rad) {
  CheckElevation("apparent_elevation_rad", apparent_elevation_rad);
  const double elevation_rad = std::max(apparent_elevation_rad, 0.0);
  return 1.0 / (std::sin(elevation_rad) +
                0.50572 * std::pow(DegFromRad(elevation_rad) + 6.07995, -1.6364));
}

}  // namespace pleinair
