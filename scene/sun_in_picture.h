// What a sun looks like in a picture of the sky, for whatever measures one.
#pragma once

#include <numbers>

namespace pleinair {

// Ratio of a disc's pixels to the sky around it, from which on a lens's glare is seen.
inline constexpr double kMuchBrighterThanSky = 10.0;
// Lenses spread a disc of 10^4 times the sky over some degrees. Light above twice the sky farther
// off, up to 10 deg, is the disc's.
inline constexpr double kGlareRad = 5.0 * std::numbers::pi / 180.0;
inline constexpr double kAroundGlareRad = 10.0 * std::numbers::pi / 180.0;
inline constexpr double kMostAureole = 2.0;

// Values as near as this are one level: above float's step, below any noise.
inline constexpr double kOneLevel = 1e-5;
// A top that a sensor cuts off is steep: few pixels are lower by less than this share. Steps of
// shared-exponent files are 0.4 to 0.8 %, so that a bright cloud's smooth top has some pixels equal
// and as many a step below.
inline constexpr double kFewSteps = 0.025;

}  // namespace pleinair
