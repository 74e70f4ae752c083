#include "sunmodel/sunrise_sunset.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <stdexcept>

#include "sunmodel/angles.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

using namespace std::chrono_literals;

using Ticks = std::chrono::nanoseconds;

// Half the day is an integer number of steps. A sun that is up for less than a step is still found
// at noon, which is one of the steps' ends.
constexpr Ticks kStep = 10min;
constexpr Ticks kHalfDay = 12h;
// The equation of time stays within 17 minutes.
constexpr Ticks kNoonBracket = 1h;
constexpr Ticks kResolution = 1ms;

// The time in [low, high] where `value`, of opposite signs there, changes sign.
template <typename Function>
UtcTime Bisect(const Function& value, UtcTime low, UtcTime high) {
  const bool low_is_positive = value(low) > 0.0;
  while (high - low > kResolution) {
    const UtcTime middle = low + (high - low) / 2;
    ((value(middle) > 0.0) == low_is_positive ? low : high) = middle;
  }
  return low + (high - low) / 2;
}

// How many steps the limb, at this apparent elevation, certainly stays on its side of the horizon;
// one where it may not. The earth turns 2.51 deg in a step, and refraction is below 2 deg.
std::int64_t StepsWithoutCrossing(double limb_rad) {
  const double spare_rad = std::abs(limb_rad) - RadFromDeg(2.0);
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(spare_rad / RadFromDeg(2.52)));
}

UtcTime MeanNoon(const Site& site, UtcTime time) {
  // Local mean solar time is UTC ahead by the longitude's share of a day.
  const double turns =
      std::remainder(site.longitude_rad, 2.0 * std::numbers::pi) / (2.0 * std::numbers::pi);
  const auto ahead =
      std::chrono::duration_cast<Ticks>(std::chrono::duration<double>(turns * 86400.0));
  return std::chrono::floor<std::chrono::days>(time + ahead) + kHalfDay - ahead;
}

}  // namespace

SolarDay FindSolarDay(const Site& site,
                      UtcTime time,
                      const Atmosphere& atmosphere,
                      const EarthRotation& rotation) {
  using std::chrono::January;
  using std::chrono::year;
  constexpr std::chrono::sys_days kFirst = year{1678} / January / 1;
  constexpr std::chrono::sys_days kEnd = year{2262} / January / 1;
  if (time < kFirst || time >= kEnd) {
    throw std::invalid_argument("time " + FormatUtcTime(time) +
                                ": expected a year from 1678 to 2261");
  }
  site.Validate();
  atmosphere.Validate();

  const auto sun_at = [&](UtcTime t) { return ComputeSunPosition(site, t, rotation); };
  // Apparent elevation of the disc's upper limb.
  const auto limb_rad = [&](UtcTime t) {
    const SunPosition sun = sun_at(t);
    const double airless_rad =
        std::min(sun.ElevationRad() + sun.angular_radius_rad, std::numbers::pi / 2.0);
    return airless_rad + RefractionRad(airless_rad, atmosphere);
  };

  SolarDay day;
  const UtcTime mean_noon = MeanNoon(site, time);
  day.noon = Bisect([&](UtcTime t) { return sun_at(t).direction_enu.x; },
                    mean_noon - kNoonBracket,
                    mean_noon + kNoonBracket);
  day.sun_up_at_noon = limb_rad(day.noon) > 0.0;

  const UtcTime end = day.noon + kHalfDay;
  UtcTime before = day.noon - kHalfDay;
  double before_rad = limb_rad(before);
  while (before < end) {
    const UtcTime after = std::min(end, before + StepsWithoutCrossing(before_rad) * kStep);
    const double after_rad = limb_rad(after);
    if (before_rad <= 0.0 && after_rad > 0.0 && !day.sunrise) {
      day.sunrise = Bisect(limb_rad, before, after);
    }
    if (before_rad > 0.0 && after_rad <= 0.0) day.sunset = Bisect(limb_rad, before, after);
    before = after;
    before_rad = after_rad;
  }
  return day;
}

}  // namespace pleinair
