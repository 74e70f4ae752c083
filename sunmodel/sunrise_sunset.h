// When the sun rises, stands highest and sets.
#pragma once

#include <optional>

#include "scene/utc_time.h"
#include "sunmodel/refraction.h"
#include "sunmodel/site.h"
#include "sunmodel/sun_position.h"

namespace pleinair {

// One solar day: from twelve hours before the sun's passage over the meridian to twelve after.
struct SolarDay {
  UtcTime noon;                    // The sun's centre crosses the meridian plane.
  bool sun_up_at_noon = false;     // Where nothing rises or sets: midnight sun, or polar night.
  std::optional<UtcTime> sunrise;  // First appearance of the upper limb; none in the day: empty.
  std::optional<UtcTime> sunset;   // Its last disappearance. Near a pole one may be there alone.
};

// Returns the solar day whose mean solar date, at the site's longitude, is that of `time`.
//
// Accuracy   0.001 s of the model. The horizon is the site's horizontal plane, without the dip seen
//            from a height; real refraction there moves rising and setting by tens of seconds, in
//            high latitudes by minutes. A sun that only grazes the horizon, by less than 0.01 deg,
//            may be missed.
// Throws     std::invalid_argument for a bad site, atmosphere or rotation, or a time outside the
//            years 1678 to 2261.
SolarDay FindSolarDay(const Site& site,
                      UtcTime time,
                      const Atmosphere& atmosphere,
                      const EarthRotation& rotation = {});

}  // namespace pleinair
