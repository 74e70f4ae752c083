// Checks whether times and place agree with the pictures: one minute is 0.25 deg of sun.
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

// Compares frames' times with their JPEGs' EXIF data, and with daylight where the exposure is
// known.
SiteWarnings CheckFrameTimes(const Sequence& sequence);

// Checks that the frames' times increase, and that no shutter is open for longer than a frame
// lasts.
SiteWarnings CheckFrameOrder(const Sequence& sequence);

// The sun's direction by a picture, in the model's frame.
struct SeenSun {
  UtcTime time{};
  glm::dvec3 direction_enu{0.0, 0.0, 1.0};
  double stddev_rad = 0.0;
};

// Returns explanations, in words, for the computed sun not being where it is seen, the best first:
// a clock or time zone, east instead of west, a model's north. Each has the remaining angle. Empty
// where there is no simple one.
std::vector<std::string> ExplanationsOf(std::span<const SeenSun> suns, const Site& site);

}  // namespace pleinair
