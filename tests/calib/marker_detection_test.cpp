#include "calib/marker_detection.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "scene/image_io.h"
#include "scene/srgb.h"
#include "tests/calib/marker_scene.h"

namespace pleinair::marker_detection_test {
namespace {

const glm::dmat4 kPose = LookAt({0.2, -1.6, 1.1}, {0.05, 0.2, 0.1});

// Every corner where the lens puts it. 0.25 px: a code of noise, rounding to codes, and lines that
// the lens bends by up to 0.1 px over half a side.
TEST(MarkerDetection, FindsMarkersAndTheirCorners) {
  const MarkerBoard board = RoomBoard();
  const Lens lens(MarkerCamera());
  const auto seen = DetectMarkers(RenderMarkers(board, MarkerCamera(), kPose), board.dictionary);
  ASSERT_EQ(seen.size(), board.markers.size());
  double squares = 0.0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    EXPECT_EQ(seen[i].id, board.markers[i].id);
    for (std::size_t c = 0; c < 4; ++c) {
      const glm::dvec4 corner(board.markers[i].corners_world_m[c], 1.0);
      const glm::dvec2 pixel = lens.ProjectToPixel(glm::dvec3(kPose * corner)).value();
      EXPECT_LT(glm::distance(pixel, seen[i].corners_px[c]), 0.25) << "marker " << seen[i].id;
      squares += std::pow(glm::distance(pixel, seen[i].corners_px[c]), 2.0) / 16.0;
    }
  }
  EXPECT_LT(std::sqrt(squares), 0.1);
}

// The same picture as light over six decades of scale, and with a lamp in it.
TEST(MarkerDetection, SeesMarkersInLinearPictures) {
  const MarkerBoard board = RoomBoard();
  const Gray8Image codes = RenderMarkers(board, MarkerCamera(), kPose);
  for (const float scale : {1e-3f, 1.0f, 1e3f}) {
    RgbImage light(codes.width, codes.height);
    for (std::size_t i = 0; i < codes.pixels.size(); ++i) {
      light.pixels[i] =
          glm::vec3(scale * static_cast<float>(LinearFromSrgb(codes.pixels[i] / 255.0)));
    }
    for (int y = 0; y < 20; ++y) {
      for (int x = 0; x < 20; ++x) light.At(x, y) = glm::vec3(1e4f * scale);
    }
    light.At(30, 3) = glm::vec3(std::nanf(""));
    light.At(31, 3) = glm::vec3(-1.0f);
    EXPECT_EQ(DetectMarkers(MarkerPicture(light), board.dictionary).size(), 4u) << scale;
  }
  EXPECT_TRUE(DetectMarkers(MarkerPicture(RgbImage(64, 48)), board.dictionary).empty());
  EXPECT_TRUE(DetectMarkers(Gray8Image(), board.dictionary).empty());
  EXPECT_TRUE(DetectMarkers(Gray8Image(3, 700, 9), board.dictionary).empty());
}

TEST(MarkerDetection, DrawsWhatItFinds) {
  for (const std::string& name : MarkerDictionaryNames()) {
    const int id = FindMarkerDictionary(name).value().marker_count - 1;
    const Gray8Image drawn = DrawMarker(name, id, 12);
    const auto seen = DetectMarkers(drawn, name);
    ASSERT_EQ(seen.size(), 1u) << name;
    EXPECT_EQ(seen[0].id, id);
    // Upright; the border begins half a pixel before its first pixel's centre.
    EXPECT_LT(glm::distance(seen[0].corners_px[0], glm::dvec2(11.5)), 0.1) << name;
    EXPECT_LT(glm::distance(seen[0].corners_px[2], glm::dvec2(drawn.width - 12.5)), 0.1) << name;
  }
  EXPECT_FALSE(FindMarkerDictionary("5x5"));
  EXPECT_THROW(DetectMarkers(Gray8Image(64, 64), "nothing"), std::invalid_argument);
}

// "id, (x y), (x y), (x y), (x y)" a line.
std::vector<std::array<glm::dvec2, 4>> ReadReference(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::vector<std::array<glm::dvec2, 4>> markers;
  for (std::string line; std::getline(stream, line);) {
    for (char& c : line) {
      if (c == '(' || c == ')' || c == ',') c = ' ';
    }
    std::istringstream words(line);
    int id = -1;
    std::array<glm::dvec2, 4> corners;
    words >> id;
    for (glm::dvec2& corner : corners) words >> corner.x >> corner.y;
    EXPECT_EQ(id, 0);
    // The AprilTag library counts from a pixel's corner.
    for (glm::dvec2& corner : corners) corner -= 0.5;
    if (words) markers.push_back(corners);
  }
  return markers;
}

// Robots in sun with the tag of id 0 on several sides of each, 12 to 34 px a side, against the
// AprilTag library's own corners: half of the tags to 0.5 px, which is 1/30 of a side. Two
// tags that it has not found are there, too.
TEST(MarkerDetection, AgreesWithAnotherProgramOnPhotographs) {
  const std::filesystem::path folder =
      std::filesystem::path(PLEINAIR_SHARED_DIR) / "data/markers_apriltag";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no pictures in " << folder;
  std::vector<double> rms_px;
  std::size_t expected = 0;
  for (const char* name : {"33369213973_9d9bb4cc96_c", "34085369442_304b6bafd9_c"}) {
    const auto reference = ReadReference(folder / (std::string(name) + ".txt"));
    const auto seen = DetectMarkers(
        MarkerPicture(ReadDisplayImage(folder / (std::string(name) + ".jpg"))), "apriltag_36h11");
    expected += reference.size();
    EXPECT_LE(seen.size(), reference.size() + 1);
    for (const DetectedMarker& marker : seen) {
      EXPECT_EQ(marker.id, 0);
      // From some corner on, the one way round or the other.
      double best = 1e30;
      for (const auto& corners : reference) {
        for (std::size_t start = 0; start < 4; ++start) {
          for (const std::size_t step : {1u, 3u}) {
            double sum = 0.0;
            for (std::size_t c = 0; c < 4; ++c) {
              const glm::dvec2 off = marker.corners_px[c] - corners[(start + step * c) % 4];
              sum += glm::dot(off, off);
            }
            best = std::min(best, sum);
          }
        }
      }
      if (std::sqrt(best / 4.0) < 2.0) rms_px.push_back(std::sqrt(best / 4.0));
    }
  }
  EXPECT_EQ(expected, 37u);
  // 31 today; the smallest ones come and go with the version of OpenCV.
  ASSERT_GE(rms_px.size(), 28u);
  std::sort(rms_px.begin(), rms_px.end());
  EXPECT_LT(rms_px[rms_px.size() / 2], 0.5);
}

}  // namespace
}  // namespace pleinair::marker_detection_test
