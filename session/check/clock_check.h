// Whether times and place are those of the pictures: one minute is 0.25 deg of sun.
#pragma once

#include <chrono>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "datasets/sequence.h"
#include "scene/utc_time.h"
#include "session/check/site_warning.h"
#include "sunmodel/site.h"

namespace pleinair {

// Frames' times against what their JPEGs' EXIF data say, and against daylight where the exposure is
// known.
SiteWarnings CheckFrameTimes(const Sequence& sequence);

// The sun as a picture shows it, in the model's frame.
struct SeenSun {
  UtcTime time{};
  glm::dvec3 direction_enu{0.0, 0.0, 1.0};
  double stddev_rad = 0.0;
};

// Between two directions of any length, radians.
double AngleApart(const glm::dvec3& a, const glm::dvec3& b);

// What would bring the computed sun to where it is seen, in words, the best first: a clock or time
// zone, an east for a west, a model's north. With how far each leaves the two apart. Empty where
// nothing simple does.
std::vector<std::string> ExplanationsOf(std::span<const SeenSun> suns, const Site& site);

}  // namespace pleinair
