#include "sunmodel/clear_sky.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sunmodel/angles.h"
#include "sunmodel/internal/clear_sky_bands.h"
#include "sunmodel/internal/number_text.h"
#include "sunmodel/internal/optical_depth.h"
#include "sunmodel/refraction.h"

namespace pleinair {
namespace {

constexpr double kSolarConstantWm2 = 1361.0;  // Kopp and Lean, GRL 38, 2011: 1360.8.
constexpr double kDiscDiameterDeg = 0.533;
// Clear twilight falls from 410 to 585 lx at sunset (centre at -0.833 deg) to 2 to 3.5 lx at -6 deg
// (Glossary of Meteorology, AMS, "civil twilight"): ln(490 / 2.65) / 5.17 deg.
constexpr double kTwilightPerDeg = 1.01;

constexpr std::array<Band, 3> kBands{
    {{kBandWavelengthUm[0], 0.126}, {kBandWavelengthUm[1], 0.079}, {kBandWavelengthUm[2], 0.003}}};

// Rural aerosol of the source.
constexpr double kScatteringAlbedoAt400nm = 0.945;
constexpr double kScatteringAlbedoVariation = 0.095;
// Where the source evaluates the light that the ground sends up: sky reflectance is that at this
// air mass.
constexpr double kUpwardAirMass = 1.8;

struct Transmittances {
  double rayleigh = 1.0;
  double ozone = 1.0;
  double aerosol_scattering = 1.0;
  double aerosol_absorption = 1.0;
};

// Equations 2-4 (Rayleigh), 2-7 (aerosol), 2-9 (ozone), 3-9, 3-10, 3-16 (the aerosol's two parts).
Transmittances TransmittancesAt(const Band& band,
                                double air_mass,
                                double ozone_mass,
                                double pressure_hpa,
                                const ClearSkyConditions& conditions) {
  const double um = band.wavelength_um;
  const double rayleigh_depth = RayleighOpticalDepth(um);
  const double aerosol_depth = AerosolOpticalDepth(conditions.aerosol_optical_depth_500nm, um);
  const double log_um = std::log(um / 0.4);
  const double scattering_albedo =
      kScatteringAlbedoAt400nm * std::exp(-kScatteringAlbedoVariation * log_um * log_um);
  return {std::exp(-rayleigh_depth * air_mass * pressure_hpa / kSeaLevelPressureHpa),
          std::exp(-band.ozone_per_atm_cm * conditions.ozone_atm_cm * ozone_mass),
          std::exp(-scattering_albedo * aerosol_depth * air_mass),
          std::exp(-(1.0 - scattering_albedo) * aerosol_depth * air_mass)};
}

// The ozone layer is 22 km up, so that slant paths through it are shorter (equation 2-10).
double OzoneMass(double sin_elevation) {
  constexpr double kLayer = 22.0 / 6370.0;
  return (1.0 + kLayer) / std::sqrt(sin_elevation * sin_elevation + 2.0 * kLayer);
}

// The share of what aerosol scatters that goes down (equations 3-11 to 3-15).
double AerosolForwardShare(double cos_zenith) {
  const double a = std::log(1.0 - kAerosolAsymmetry);
  const double first = a * (1.459 + a * (0.1595 + a * 0.4129));
  const double second = a * (0.0783 + a * (-0.3824 - a * 0.5874));
  return 1.0 - 0.5 * std::exp((first + second * cos_zenith) * cos_zenith);
}

// Reflectance of the sky for light from below (equation 3-8).
double SkyReflectance(const Transmittances& up) {
  return up.ozone * up.aerosol_absorption *
         (0.5 * (1.0 - up.rayleigh) + (1.0 - AerosolForwardShare(1.0 / kUpwardAirMass)) *
                                          up.rayleigh * (1.0 - up.aerosol_scattering));
}

double BeamFade(double elevation_deg) {
  const double t = std::clamp(elevation_deg / kDiscDiameterDeg, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

}  // namespace

void ClearSkyConditions::Validate() const {
  CheckRange("clear sky: aerosol_optical_depth_500nm", aerosol_optical_depth_500nm, 0.0, 5.0);
  CheckRange("clear sky: ozone_atm_cm", ozone_atm_cm, 0.0, 1.0);
  CheckRange("clear sky: ground_albedo", ground_albedo, 0.0, 1.0);
  CheckRange("clear sky: sun_distance_au", sun_distance_au, 0.9, 1.1);
}

ClearSkyIrradiance ComputeClearSky(const Site& site,
                                   double apparent_elevation_rad,
                                   const ClearSkyConditions& conditions) {
  return ComputeClearSkyAt(kBands, site, apparent_elevation_rad, conditions);
}

ClearSkyIrradiance ComputeClearSkyAt(const std::array<Band, 3>& bands,
                                     const Site& site,
                                     double apparent_elevation_rad,
                                     const ClearSkyConditions& conditions) {
  site.Validate();
  conditions.Validate();
  const double air_mass = RelativeAirMass(apparent_elevation_rad);
  const double elevation_deg = DegFromRad(apparent_elevation_rad);
  const double sin_elevation = std::max(std::sin(apparent_elevation_rad), 0.0);
  // Replaces the cosine of the zenith angle for scattered light: the same above 10 deg (2 %),
  // but not zero at the horizon, where the curved atmosphere is still lit.
  const double cos_zenith = 1.0 / air_mass;
  const double ozone_mass = OzoneMass(sin_elevation);
  const double pressure_hpa = StandardAtmosphere(site.height_m).pressure_hpa;
  const double twilight = std::exp(kTwilightPerDeg * std::min(elevation_deg, 0.0));
  const double above_wm2 =
      kSolarConstantWm2 / (conditions.sun_distance_au * conditions.sun_distance_au);

  ClearSkyIrradiance sky;
  for (int c = 0; c < 3; ++c) {
    const Transmittances t =
        TransmittancesAt(bands[c], air_mass, ozone_mass, pressure_hpa, conditions);
    const double beam = above_wm2 * t.rayleigh * t.ozone * t.aerosol_scattering *
                        t.aerosol_absorption * BeamFade(elevation_deg);
    const double lit = above_wm2 * cos_zenith * t.ozone * t.aerosol_absorption;
    const double from_air = lit * (1.0 - std::pow(t.rayleigh, 0.95)) * 0.5;
    const double from_aerosol = lit * std::pow(t.rayleigh, 1.5) * (1.0 - t.aerosol_scattering) *
                                AerosolForwardShare(cos_zenith);
    const double back = SkyReflectance(TransmittancesAt(
                            bands[c], kUpwardAirMass, kUpwardAirMass, pressure_hpa, conditions)) *
                        conditions.ground_albedo;
    const double down = beam * sin_elevation + from_air + from_aerosol;
    sky.beam_rgb[c] = beam;
    sky.diffuse_rgb[c] = (from_air + from_aerosol + down * back / (1.0 - back)) * twilight;
  }
  return sky;
}

}  // namespace pleinair
