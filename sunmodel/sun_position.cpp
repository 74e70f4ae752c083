#include "sunmodel/sun_position.h"

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <erfa.h>
#include <erfam.h>
#include <GeographicLib/Geocentric.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "sunmodel/angles.h"
#include "sunmodel/internal/earth_time.h"
#include "sunmodel/internal/number_text.h"

namespace pleinair {
namespace {

// The Astronomical Almanac's semidiameter at 1 au, 959.63 arc seconds, is that of this sphere.
constexpr double kSunRadiusM = 696.0e6;
// Turns of the earth per UT1 second, in radians (IERS Conventions 2010, equation 5.15).
constexpr double kEarthRateRadPerS = 1.00273781191135448 * ERFA_D2PI / ERFA_DAYSEC;
constexpr double kMaxUt1MinusUtcS = 60.0;
constexpr double kMaxDeltaTS = 8000.0;

using Rows = double[3][3];  // As ERFA holds a matrix.

glm::dvec3 VectorFrom(const double v[3]) { return {v[0], v[1], v[2]}; }

glm::dmat3 MatrixFromRows(const Rows& rows) {
  return glm::transpose(glm::dmat3(VectorFrom(rows[0]), VectorFrom(rows[1]), VectorFrom(rows[2])));
}

// The true equator and equinox turned by the sidereal angle: polar motion left out.
glm::dmat3 TerrestrialFromEquator(double sidereal_rad) {
  const double c = std::cos(sidereal_rad);
  const double s = std::sin(sidereal_rad);
  return {{c, -s, 0.0}, {s, c, 0.0}, {0.0, 0.0, 1.0}};
}

struct SitePlace {
  glm::dvec3 position_m{0.0};  // Geocentric, turning with the earth.
  glm::dmat3 geocentric_from_enu{1.0};
};

SitePlace PlaceOf(const Site& site) {
  SitePlace place;
  std::vector<double> m(9);
  // A full turn is taken off in radians, so that every turn of a longitude gives the same degrees.
  const double longitude_rad = std::remainder(site.longitude_rad, ERFA_D2PI);
  GeographicLib::Geocentric::WGS84().Forward(DegFromRad(site.latitude_rad),
                                             DegFromRad(longitude_rad),
                                             site.height_m,
                                             place.position_m.x,
                                             place.position_m.y,
                                             place.position_m.z,
                                             m);
  place.geocentric_from_enu =
      glm::transpose(glm::dmat3({m[0], m[1], m[2]}, {m[3], m[4], m[5]}, {m[6], m[7], m[8]}));
  return place;
}

void CheckWithin(const char* field, const std::optional<double>& value, double bound) {
  if (value && !(std::abs(*value) <= bound)) {
    throw std::invalid_argument("earth rotation: " + std::string(field) + " is " +
                                NumberText(*value) + ", expected " + NumberText(-bound) + " to " +
                                NumberText(bound));
  }
}

}  // namespace

double SunPosition::ElevationRad() const {
  return std::atan2(direction_enu.z, std::hypot(direction_enu.x, direction_enu.y));
}

double SunPosition::AzimuthRad() const {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const double azimuth_rad = std::atan2(direction_enu.x, direction_enu.y);
  if (azimuth_rad >= 0.0) return azimuth_rad;
  // Less than 4e-16 rad west of north rounds up to the full turn, which is outside the range.
  return azimuth_rad + kTurn < kTurn ? azimuth_rad + kTurn : 0.0;
}

void EarthRotation::Validate() const {
  CheckWithin("ut1_minus_utc_s", ut1_minus_utc_s, kMaxUt1MinusUtcS);
  CheckWithin("tt_minus_ut1_s", tt_minus_ut1_s, kMaxDeltaTS);
}

SunPosition ComputeSunPosition(const Site& site, UtcTime time, const EarthRotation& rotation) {
  site.Validate();
  rotation.Validate();
  const EarthTime clocks = EarthTimeAt(time, rotation);
  const JulianDate& tt = clocks.terrestrial;  // Stands in for TDB: they differ by 2 ms at most.
  const JulianDate& ut1 = clocks.universal;

  Rows equator_rows;
  eraPnm06a(tt.days, tt.fraction, equator_rows);
  const double sidereal_rad = eraGst06(ut1.days, ut1.fraction, tt.days, tt.fraction, equator_rows);
  const glm::dmat3 terrestrial_from_celestial =
      TerrestrialFromEquator(sidereal_rad) * MatrixFromRows(equator_rows);
  const glm::dmat3 celestial_from_terrestrial = glm::transpose(terrestrial_from_celestial);

  // au and au per day, celestial axes, from the solar system's barycentre.
  double heliocentric[2][3];
  double barycentric[2][3];
  // Status 1, outside 1900 to 2100, is checked by IsInEphemerisSpan.
  eraEpv00(tt.days, tt.fraction, heliocentric, barycentric);
  const glm::dvec3 sun_au = VectorFrom(barycentric[0]) - VectorFrom(heliocentric[0]);
  const glm::dvec3 sun_au_per_day = VectorFrom(barycentric[1]) - VectorFrom(heliocentric[1]);

  const SitePlace place = PlaceOf(site);
  const glm::dvec3 turn_m_per_s =
      glm::cross(glm::dvec3(0.0, 0.0, kEarthRateRadPerS), place.position_m);
  const glm::dvec3 site_au =
      VectorFrom(barycentric[0]) + celestial_from_terrestrial * place.position_m / ERFA_DAU;
  const glm::dvec3 site_au_per_day = VectorFrom(barycentric[1]) + celestial_from_terrestrial *
                                                                      turn_m_per_s *
                                                                      (ERFA_DAYSEC / ERFA_DAU);

  // The light left the sun 8 minutes ago. The sun moves 6 km in that time, so that one step, from
  // the distance now, settles the light's path to 1e-10 of it.
  const double light_days = glm::distance(sun_au, site_au) / ERFA_DC;
  const glm::dvec3 to_sun_au = sun_au - light_days * sun_au_per_day - site_au;
  const double distance_au = glm::length(to_sun_au);

  glm::dvec3 natural = to_sun_au / distance_au;
  glm::dvec3 velocity_c = site_au_per_day / ERFA_DC;
  const double inverse_lorentz = std::sqrt(1.0 - glm::dot(velocity_c, velocity_c));
  std::array<double, 3> proper{};
  eraAb(&natural.x, &velocity_c.x, distance_au, inverse_lorentz, proper.data());

  const glm::dvec3 direction_enu = glm::transpose(place.geocentric_from_enu) *
                                   (terrestrial_from_celestial * VectorFrom(proper.data()));
  return {glm::normalize(direction_enu),
          std::asin(kSunRadiusM / (distance_au * ERFA_DAU)),
          distance_au};
}

bool IsInEphemerisSpan(UtcTime time) {
  using std::chrono::January;
  using std::chrono::sys_days;
  using std::chrono::year;
  return time >= sys_days(year{1900} / January / 1) && time < sys_days(year{2101} / January / 1);
}

}  // namespace pleinair
