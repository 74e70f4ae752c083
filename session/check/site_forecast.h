// Forecast of the light's estimate over a day at a prepared site.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <vector>

#include "pipeline/light_forecast.h"
#include "scene/utc_time.h"
#include "session/loaded_sequence.h"
#include "session/session_options.h"
#include "sunmodel/sunrise_sunset.h"

namespace pleinair {

// One time of the day.
struct SiteHour {
  LightForecast light;
  // Share of the objects' surface that faces the sun and is in no shadow of the real mesh; none
  // without objects, or with the sun below the horizon.
  std::optional<double> sun_on_objects;
};

// The day, step by step.
struct SiteDay {
  SolarDay sun;                 // Sunrise, noon, sunset.
  std::vector<SiteHour> hours;  // From sunrise to sunset, or all day where there are none.
};

// At most this many hours, evenly chosen, keep their picture.
inline constexpr std::size_t kMostDayPictures = 24;

// Whether an hour's picture alone determines the sun: see LightingEstimate::sun_observable.
bool SunWillBeKnown(const SiteHour& hour);

// Forecasts the solar day whose noon has the date of `day` at the site, under a clear sky. The
// times are full multiples of `step` (of UTC), or solar noon where the sun is up at none of them.
// The camera has the pose of the first frame. Source and settings of the estimate are those of
// `options`; where a fish-eye camera measures the light, estimates are left out. Throws
// std::runtime_error without a place; std::invalid_argument for a step outside 1 min to 1 day.
SiteDay ForecastDay(const LoadedSequence& loaded,
                    const SessionOptions& options,
                    UtcTime day,
                    std::chrono::minutes step);

}  // namespace pleinair
