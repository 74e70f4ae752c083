// The survey map that a sequence names, and the sun that it shows.
#pragma once

#include <string>
#include <vector>

#include "datasets/sequence.h"
#include "relight/survey/survey.h"

namespace pleinair {

// Reads the sun's direction from the environment map where neither a site nor
// `environment.sun_direction_enu` gives it. It is used for the map and for frames that do not state
// their own. A map without a sun is overcast, and so are those frames. Returns a note for the
// report. Throws std::runtime_error, one line, for a frame that is stated not to be overcast under
// such a map.
std::vector<std::string> FindSunInMap(Sequence& sequence);

struct LoadedSurveyMap {
  SurveyMap map;
  double turned_rad = 0.0;  // Clockwise, relative to its file.
};

// Reads the map of `sequence.environment`, which it must have, repairs it, and turns it with a
// model that stands off true north. A sun in the map that is 3 deg or more from its stated or
// computed direction is a note. Throws std::runtime_error, one line with the file and what was
// expected.
LoadedSurveyMap LoadSurveyMap(const Sequence& sequence,
                              bool is_indoors,
                              std::vector<std::string>& notes);

}  // namespace pleinair
