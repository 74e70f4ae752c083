#include "sunmodel/internal/earth_time.h"

#include <array>
#include <span>

#include "sunmodel/internal/day_split.h"
#include "sunmodel/internal/leap_seconds.h"

namespace pleinair {
namespace {

constexpr double kSecondsPerDay = 86400.0;
constexpr double kJulianDateOf1970 = 2440587.5;
constexpr double kJulianDateOf2000 = 2451544.5;
constexpr double kDaysPerYear = 365.25;
constexpr double kTtMinusTaiS = 32.184;  // By definition of TT (IAU 1991).

// Lowest power first.
double Polynomial(std::span<const double> coefficients, double x) {
  double value = 0.0;
  for (auto term = coefficients.rbegin(); term != coefficients.rend(); ++term) {
    value = value * x + *term;
  }
  return value;
}

constexpr std::array k1600{120.0, -0.9808, -0.01532, 1.0 / 7129.0};
constexpr std::array k1700{8.83, 0.1603, -0.0059285, 0.00013336, -1.0 / 1174000.0};
constexpr std::array k1800{13.72,
                           -0.332447,
                           0.0068612,
                           0.0041116,
                           -0.00037436,
                           0.0000121272,
                           -0.0000001699,
                           0.000000000875};
constexpr std::array k1860{7.62, 0.5737, -0.251754, 0.01680668, -0.0004473624, 1.0 / 233174.0};
constexpr std::array k1900{-2.79, 1.494119, -0.0598939, 0.0061966, -0.000197};
constexpr std::array k1920{21.20, 0.84493, -0.076100, 0.0020936};
constexpr std::array k1941{29.07, 0.407, -1.0 / 233.0, 1.0 / 2547.0};
constexpr std::array k1961{45.45, 1.067, -1.0 / 260.0, -1.0 / 718.0};

}  // namespace

double PublishedDeltaTS(double decimal_year) {
  const double y = decimal_year;
  if (y < 1700.0) return Polynomial(k1600, y - 1600.0);
  if (y < 1800.0) return Polynomial(k1700, y - 1700.0);
  if (y < 1860.0) return Polynomial(k1800, y - 1800.0);
  if (y < 1900.0) return Polynomial(k1860, y - 1860.0);
  if (y < 1920.0) return Polynomial(k1900, y - 1900.0);
  if (y < 1941.0) return Polynomial(k1920, y - 1920.0);
  if (y < 1961.0) return Polynomial(k1941, y - 1950.0);
  return Polynomial(k1961, y - 1975.0);
}

EarthTime EarthTimeAt(UtcTime time, const EarthRotation& rotation) {
  const DaySplit split = SplitAtMidnight(time);
  const std::chrono::sys_days day = split.day;
  const double day_number = kJulianDateOf1970 + double(day.time_since_epoch().count());
  const double utc_s = std::chrono::duration<double>(split.passed).count();
  const double ut1_s = utc_s + rotation.ut1_minus_utc_s.value_or(0.0);
  const auto tt_s = [&] {
    if (rotation.tt_minus_ut1_s) return ut1_s + *rotation.tt_minus_ut1_s;
    if (day >= kFirstLeapSecondDay) return utc_s + TaiMinusUtcS(day) + kTtMinusTaiS;
    const double days_since_2000 = day_number - kJulianDateOf2000 + utc_s / kSecondsPerDay;
    return ut1_s + PublishedDeltaTS(2000.0 + days_since_2000 / kDaysPerYear);
  };
  return {{day_number, tt_s() / kSecondsPerDay}, {day_number, ut1_s / kSecondsPerDay}};
}

}  // namespace pleinair
