// The north of a site's model, from the sun that its survey map shows.
#pragma once

#include <optional>

#include "datasets/sequence.h"

namespace pleinair {

struct MapNorth {
  double azimuth_rad = 0.0;  // Of the model's +Y, clockwise from true north.
  double stddev_rad = 0.0;
};

// The map is taken to be turned as the model is, to 0.7 deg. None without a map or a place, where
// the sun of the map is stated, and where the map shows no disc at the height that place and time
// give it: then these, or the map's level, are wrong, too. None, either, where the map's sun stands
// where true north has it: the map may have been turned to true north, which does not say how the
// model stands. Throws as ReadRadianceImage.
std::optional<MapNorth> NorthOfMap(const Sequence& sequence);

}  // namespace pleinair
