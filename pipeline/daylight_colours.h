// Colours that daylight can have: a light whose estimate lost a channel is corrected before it is
// drawn.
#pragma once

#include <optional>

#include "scene/lighting.h"

namespace pleinair {

// The smallest channel of the entire sky's light over its largest. In linear sRGB the bluest black
// body, an infinitely hot one, has 0.30. One at 4000 K, redder than skies are, has 0.38. The margin
// is for a camera's own primaries and white balance.
inline constexpr double kLeastSkyChannel = 0.25;

// Green over the geometric mean of red and blue: 1.07 for a black body at 4000 K, 0.89 at 10,000 K,
// and 0.80 for the bluest one. The margin is again for white balance; a sensor's own green, before
// any, is larger.
inline constexpr double kLeastGreen = 0.75;

// Half-way between a black body at 4000 K and at 10,000 K. Where nobody set the white balance, each
// channel's gain is assumed to be off by a logarithm of 0.12, and this ratio by sqrt(1.5) times
// that. So a magenta light beyond kLeastGreen may be the camera's colour of daylight.
inline constexpr double kUsualGreen = 0.98;
inline constexpr double kGreenLogStddev = 0.15;
// Four and a half deviations below.
inline constexpr double kLeastGreenOfAnyCamera = 0.5;

// Light that is scattered out of the sun's beam comes from the sky, or is lost to both. So sky over
// sun rises from red to green and from green to blue. Where it is measured well, it rises by 1.1
// (thin cloud) to 2.2 times (clear, the sun at 20 degrees), and by 2.8 at most in air without any
// haze (clear_sky.h). This holds in any white balance, as that divides out. A shadow that is redder
// than the sunlight around it is wrong.
inline constexpr double kLeastRiseOfSkyOverSun = 1.0 / 1.2;
// From 30 degrees of elevation on.
inline constexpr double kMostRiseOfSkyOverSun = 2.9;
// Below, each air mass takes more blue than green out of the beam: Rayleigh's optical depth is 0.24
// at 440 nm and 0.10 at 544 nm, and haze adds 0.03. A measured sunrise, the sun at 8 degrees, rises
// by 5.0.
inline constexpr double kMoreRisePerAirMass = 0.17;

// Returns `lighting` with corrected colours; none where the limits above hold already. First,
// channels of the sky are raised to kLeastSkyChannel of the largest one, with that one's shape.
// Then green of sky and sun is raised to kLeastGreen, but no farther than to the mean of the
// estimate and usual daylight, weighed by their deviations. So a tint that surveyed surfaces show
// to be the camera's is kept, down to kLeastGreenOfAnyCamera. Last, channels of sky or sun,
// whichever needs less, are raised until sky over sun rises as above. A sun below a fiftieth of the
// sky is not changed.
std::optional<Lighting> WithDaylightColours(const Lighting& lighting);

}  // namespace pleinair
