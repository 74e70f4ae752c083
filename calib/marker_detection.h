// ArUco and AprilTag markers in a picture.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/vec2.hpp>

#include "scene/image.h"

namespace pleinair {

// OpenCV's predefined dictionaries, by their names in lower case without "DICT_": "apriltag_36h11",
// "4x4_50", "aruco_original".
struct MarkerDictionary {
  std::string name;
  int marker_count = 0;  // Ids are 0 to marker_count - 1.
};
// None for an unknown name.
std::optional<MarkerDictionary> FindMarkerDictionary(std::string_view name);
std::vector<std::string> MarkerDictionaryNames();

// A marker in a picture.
struct DetectedMarker {
  int id = 0;
  // Outer corners of the black border, integer coordinates at pixel centres: the marker's own top
  // left (as it is printed), top right, bottom right, bottom left.
  std::array<glm::dvec2, 4> corners_px{};
};

// All markers found, by id and then from left to right. A marker needs a white rim of one cell, and
// some 3 pixels for each cell. Pictures of up to a megapixel are also searched at twice their size.
//
// Accuracy  corners are crossings of lines along the sides: 0.1 px rms on sharp synthetic pictures;
//           within 0.5 px of another program's (median of 31) on tags of 12 to 34 px in
//           photographs.
// Source    Garrido-Jurado et al., Pattern Recognition 47(6), 2014 (cv::aruco), except for the
//           corners.
// Throws    std::invalid_argument for a dictionary that FindMarkerDictionary does not know.
std::vector<DetectedMarker> DetectMarkers(const Gray8Image& picture, const std::string& dictionary);

// A picture as DetectMarkers takes it: the mean of its code values.
Gray8Image MarkerPicture(const Rgb8Image& codes);
// An 8-bit picture of `radiance`: white is its 98th percentile, and codes are sRGB's, so that
// markers in shade keep their contrast. Values that are not finite or negative become black.
Gray8Image MarkerPicture(const RgbImage& radiance);

}  // namespace pleinair
