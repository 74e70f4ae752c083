// Colours that daylight can have: no light whose estimate lost a channel is drawn.
#pragma once

#include <optional>

#include "scene/lighting.h"

namespace pleinair {

// The smallest channel of the light of all of the sky over its largest. In linear sRGB the bluest
// black body, an infinitely hot one, has 0.30, and one at 4000 K, redder than skies are, 0.38; the
// rest is left to a camera's own primaries and white balance.
inline constexpr double kLeastSkyChannel = 0.25;

// What is scattered out of the sun's beam comes from the sky, or is lost to both: sky over sun
// rises from red to green and from green to blue, by 1.1 (thin cloud) to 2.2 times (clear, the sun
// at 20 degrees) where it is measured well. In any white balance, as that divides out. A shadow
// that is redder than the sunlight around it is wrong.
inline constexpr double kLeastRiseOfSkyOverSun = 1.0 / 1.2;
// From 30 degrees of elevation on; below, each air mass takes e^0.1 more of the beam.
inline constexpr double kMostRiseOfSkyOverSun = 2.5;

// `lighting` where it has none of these colours: with channels of the sky raised to
// kLeastSkyChannel of the largest, in the shape of that one; then with channels of sky or sun
// raised, whichever takes less, until sky over sun rises as above. A sun below a fiftieth of the
// sky is left as it is. None where all of it holds already.
std::optional<Lighting> WithDaylightColours(const Lighting& lighting);

}  // namespace pleinair
