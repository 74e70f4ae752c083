// A board's corners as points of its plane and their pixels.
#pragma once

#include <vector>

#include "calib/calibration_board.h"
#include "calib/camera_pose.h"

namespace pleinair {

// In sides of a square in place of metres.
inline std::vector<PointMatch> MatchesOf(const BoardPicture& picture) {
  std::vector<PointMatch> matches;
  matches.reserve(picture.corners.size());
  for (const BoardCorner& corner : picture.corners) {
    matches.push_back({{corner.place_squares, 0.0}, corner.pixel});
  }
  return matches;
}

}  // namespace pleinair
