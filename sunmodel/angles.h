// Conversions: degrees in text and files, radians everywhere else.
#pragma once

#include <numbers>

namespace pleinair {

constexpr double RadFromDeg(double deg) { return deg * (std::numbers::pi / 180.0); }
constexpr double DegFromRad(double rad) { return rad * (180.0 / std::numbers::pi); }

}  // namespace pleinair
