// OpenCV's own dictionaries of markers.
#pragma once

#include <string>

#include <opencv2/aruco/dictionary.hpp>

namespace pleinair {

// By the names of calib/marker_detection.h. Throws std::invalid_argument for any other.
cv::Ptr<cv::aruco::Dictionary> OpenCvDictionary(const std::string& name);

}  // namespace pleinair
