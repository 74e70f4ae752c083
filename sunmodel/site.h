// Where on earth: a place, as plain data.
#pragma once

namespace pleinair {

struct Site {
  double latitude_rad = 0.0;   // WGS84, [-pi/2, pi/2], north positive.
  double longitude_rad = 0.0;  // East positive; any turn.
  double height_m = 0.0;       // Over the ellipsoid.

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

}  // namespace pleinair
