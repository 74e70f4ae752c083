#include "calib/marker_detection.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

#include <glm/geometric.hpp>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/internal/marker_corners.h"
#include "calib/internal/marker_dictionary.h"
#include "calib/internal/opencv_types.h"
#include "scene/srgb.h"

namespace pleinair {
namespace {

struct NamedDictionary {
  const char* name;
  cv::aruco::PREDEFINED_DICTIONARY_NAME id;
};
constexpr std::array<NamedDictionary, 21> kDictionaries{{
    {"apriltag_16h5", cv::aruco::DICT_APRILTAG_16h5},
    {"apriltag_25h9", cv::aruco::DICT_APRILTAG_25h9},
    {"apriltag_36h10", cv::aruco::DICT_APRILTAG_36h10},
    {"apriltag_36h11", cv::aruco::DICT_APRILTAG_36h11},
    {"aruco_original", cv::aruco::DICT_ARUCO_ORIGINAL},
    {"4x4_50", cv::aruco::DICT_4X4_50},
    {"4x4_100", cv::aruco::DICT_4X4_100},
    {"4x4_250", cv::aruco::DICT_4X4_250},
    {"4x4_1000", cv::aruco::DICT_4X4_1000},
    {"5x5_50", cv::aruco::DICT_5X5_50},
    {"5x5_100", cv::aruco::DICT_5X5_100},
    {"5x5_250", cv::aruco::DICT_5X5_250},
    {"5x5_1000", cv::aruco::DICT_5X5_1000},
    {"6x6_50", cv::aruco::DICT_6X6_50},
    {"6x6_100", cv::aruco::DICT_6X6_100},
    {"6x6_250", cv::aruco::DICT_6X6_250},
    {"6x6_1000", cv::aruco::DICT_6X6_1000},
    {"7x7_50", cv::aruco::DICT_7X7_50},
    {"7x7_100", cv::aruco::DICT_7X7_100},
    {"7x7_250", cv::aruco::DICT_7X7_250},
    {"7x7_1000", cv::aruco::DICT_7X7_1000},
}};

std::vector<DetectedMarker> Search(const cv::Mat& picture,
                                   double scale,
                                   const cv::Ptr<cv::aruco::Dictionary>& dictionary) {
  const auto parameters = cv::aruco::DetectorParameters::create();
  // Away from OpenCV's defaults, as counted on photographs of tags of 20 px a side:
  // - perimeters from 4 x 4 px in a picture of 800, not 4 x 6;
  // - 8 pixels a cell when cells are read, not 4;
  // - squares nearer to one another than a marker and the outline of its white rim, as otherwise
  //   the rim stands for both, and no marker is found;
  // - in enlarged pictures also thresholds over wider windows.
  parameters->minMarkerPerimeterRate = 0.02;
  parameters->perspectiveRemovePixelPerCell = 8;
  parameters->minMarkerDistanceRate = 0.02;
  if (scale > 1.0) parameters->adaptiveThreshWinSizeMax = 53;
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  cv::aruco::detectMarkers(picture, dictionary, corners, ids, parameters);
  std::vector<DetectedMarker> markers;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    DetectedMarker marker;
    marker.id = ids[i];
    for (std::size_t c = 0; c < 4; ++c) {
      // Pixel centres are integers at either size.
      marker.corners_px[c] = (glm::dvec2(corners[i][c].x, corners[i][c].y) + 0.5) / scale - 0.5;
    }
    markers.push_back(marker);
  }
  return markers;
}

glm::dvec2 Centre(const DetectedMarker& marker) {
  const auto& c = marker.corners_px;
  return 0.25 * (c[0] + c[1] + c[2] + c[3]);
}

bool IsSameMarker(const DetectedMarker& a, const DetectedMarker& b) {
  return a.id == b.id && glm::distance(Centre(a), Centre(b)) <
                             0.5 * glm::distance(a.corners_px[0], a.corners_px[2]);
}

}  // namespace

cv::Ptr<cv::aruco::Dictionary> OpenCvDictionary(const std::string& name) {
  for (const NamedDictionary& entry : kDictionaries) {
    if (name == entry.name) return cv::aruco::getPredefinedDictionary(entry.id);
  }
  throw std::invalid_argument("marker dictionary: expected one of OpenCV's, such as " +
                              std::string(kDictionaries[3].name) + ", found " + name);
}

std::optional<MarkerDictionary> FindMarkerDictionary(std::string_view name) {
  for (const NamedDictionary& entry : kDictionaries) {
    if (name != entry.name) continue;
    const auto dictionary = cv::aruco::getPredefinedDictionary(entry.id);
    return MarkerDictionary{entry.name, dictionary->bytesList.rows};
  }
  return std::nullopt;
}

std::vector<std::string> MarkerDictionaryNames() {
  std::vector<std::string> names;
  names.reserve(std::size(kDictionaries));
  for (const NamedDictionary& entry : kDictionaries) names.emplace_back(entry.name);
  return names;
}

std::vector<DetectedMarker> DetectMarkers(const Gray8Image& picture,
                                          const std::string& dictionary) {
  constexpr std::size_t kEnlargeUpToPx = 1024 * 1024;
  const auto known = OpenCvDictionary(dictionary);
  if (picture.width < 8 || picture.height < 8) return {};
  const cv::Mat image = MatOf(picture);
  std::vector<DetectedMarker> markers = Search(image, 1.0, known);
  if (picture.pixels.size() <= kEnlargeUpToPx) {
    cv::Mat enlarged;
    cv::resize(image, enlarged, {}, 2.0, 2.0, cv::INTER_CUBIC);
    for (const DetectedMarker& marker : Search(enlarged, 2.0, known)) {
      if (std::none_of(markers.begin(), markers.end(), [&](const DetectedMarker& other) {
            return IsSameMarker(marker, other);
          })) {
        markers.push_back(marker);
      }
    }
  }
  const int cells = known->markerSize + 2;
  for (DetectedMarker& marker : markers) {
    marker.corners_px = RefinedMarkerCorners(picture, marker.corners_px, cells);
  }
  std::sort(markers.begin(), markers.end(), [](const DetectedMarker& a, const DetectedMarker& b) {
    return std::pair(a.id, Centre(a).x) < std::pair(b.id, Centre(b).x);
  });
  return markers;
}

Gray8Image MarkerPicture(const Rgb8Image& codes) {
  Gray8Image grey(codes.width, codes.height);
  for (std::size_t i = 0; i < codes.pixels.size(); ++i) {
    const glm::ivec3 code(codes.pixels[i]);
    grey.pixels[i] = static_cast<std::uint8_t>((code.x + code.y + code.z + 1) / 3);
  }
  return grey;
}

Gray8Image MarkerPicture(const RgbImage& radiance) {
  constexpr double kWhiteShare = 0.98;
  std::vector<float> light;
  light.reserve(radiance.pixels.size());
  for (const glm::vec3& pixel : radiance.pixels) {
    const float sum = pixel.x + pixel.y + pixel.z;
    light.push_back(sum > 0.0f && std::isfinite(sum) ? sum : 0.0f);
  }
  Gray8Image grey(radiance.width, radiance.height);
  if (light.empty()) return grey;
  std::vector<float> sorted = light;
  const auto white_at = sorted.begin() + static_cast<std::ptrdiff_t>(
                                             kWhiteShare * static_cast<double>(light.size() - 1));
  std::nth_element(sorted.begin(), white_at, sorted.end());
  const float white = *white_at;
  if (!(white > 0.0f)) return grey;
  for (std::size_t i = 0; i < light.size(); ++i) {
    const double code = 255.0 * SrgbFromLinear(std::min(1.0f, light[i] / white));
    grey.pixels[i] = static_cast<std::uint8_t>(std::lround(code));
  }
  return grey;
}

}  // namespace pleinair
