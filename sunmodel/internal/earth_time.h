// The two clocks that an ephemeris needs: even time for the orbit, the earth's turn for the site.
#pragma once

#include "scene/utc_time.h"
#include "sunmodel/sun_position.h"

namespace pleinair {

// A Julian date in two parts: whole days (exact) and the day's fraction.
struct JulianDate {
  double days = 0.0;
  double fraction = 0.0;
};

struct EarthTime {
  JulianDate terrestrial;  // TT.
  JulianDate universal;    // UT1.
};

EarthTime EarthTimeAt(UtcTime time, const EarthRotation& rotation);

// Delta T = TT - UT1 for years 1600 to 1986 of UT.
//
// Source     Espenak and Meeus, Five Millennium Canon of Solar Eclipses, NASA/TP-2006-214141,
//            section 2.7, the polynomial expressions.
// Accuracy   about 1 s since 1800, 20 s in 1600; its pieces meet to 0.3 s.
double PublishedDeltaTS(double decimal_year);

}  // namespace pleinair
