// Where on earth, and how a model of the place is turned: as plain data and as text.
#pragma once

#include <string_view>

namespace pleinair {

// A place on earth, and the orientation of its model.
struct Site {
  double latitude_rad = 0.0;   // WGS84, [-pi/2, pi/2], north positive.
  double longitude_rad = 0.0;  // East positive; any turn.
  double height_m = 0.0;       // Over the ellipsoid, -11 000 to 1 000 000.
  // True azimuth of +Y of the world frame that the site's model is in; finite. Sun positions are
  // relative to true north.
  double model_north_azimuth_rad = 0.0;

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// Parses "LAT,LON" or "LAT,LON,H": decimal degrees, north and east positive, and metres. Longitudes
// of up to a full turn are accepted. Throws std::invalid_argument naming the text and the field.
Site ParseSite(std::string_view text);

}  // namespace pleinair
