// Markers to print.
#pragma once

#include <string>

#include <opencv2/aruco.hpp>

#include "calib/internal/marker_dictionary.h"
#include "calib/internal/opencv_types.h"
#include "scene/image.h"

namespace pleinair {

// `pixels_per_cell` pixels for each cell, with a white rim of one cell.
inline Gray8Image DrawMarker(const std::string& dictionary, int id, int pixels_per_cell) {
  const auto known = OpenCvDictionary(dictionary);
  const int side = (known->markerSize + 2) * pixels_per_cell;
  cv::Mat marker;
  cv::aruco::drawMarker(known, id, side, marker);
  Gray8Image drawn(side + 2 * pixels_per_cell, side + 2 * pixels_per_cell, 255);
  marker.copyTo(MatOf(drawn)({pixels_per_cell, pixels_per_cell, side, side}));
  return drawn;
}

}  // namespace pleinair
