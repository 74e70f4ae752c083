// Between places on earth and east-north-up coordinates about one of them, in double precision.
#pragma once

#include <glm/vec3.hpp>

#include "sunmodel/site.h"

namespace pleinair {

// `place` in the frame whose origin is `origin` and whose axes are its east, north and up; metres.
//
// Source   GeographicLib's LocalCartesian on WGS84.
// Throws   std::invalid_argument for a bad site.
glm::dvec3 EnuOf(const Site& place, const Site& origin);

// The inverse.
Site PlaceAt(const glm::dvec3& enu_m, const Site& origin);

}  // namespace pleinair
