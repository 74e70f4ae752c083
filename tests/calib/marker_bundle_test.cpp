#include "calib/marker_bundle.h"

#include <cmath>
#include <random>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/marker_scene.h"

namespace pleinair::marker_bundle_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kSizeM = 0.2;

// The corners as a camera would find them, to `noise_px`; from an arc about the board.
std::vector<MarkerView> Views(const MarkerBoard& board, int count, double noise_px) {
  const Lens lens(MarkerCamera());
  std::mt19937 random(4);
  std::normal_distribution<double> noise(0.0, noise_px);
  std::vector<MarkerView> views;
  for (int i = 0; i < count; ++i) {
    const double azimuth = -0.6 + 1.2 * i / std::max(1, count - 1);
    const glm::dmat4 pose = LookAt(
        {1.7 * std::sin(azimuth), -1.7 * std::cos(azimuth), 0.9 + 0.1 * (i % 3)}, {0.05, 0.2, 0.1});
    MarkerView& view = views.emplace_back();
    view.name = "picture " + std::to_string(i);
    for (const BoardMarker& marker : board.markers) {
      DetectedMarker seen{marker.id, {}};
      for (std::size_t c = 0; c < 4; ++c) {
        const glm::dvec4 corner(marker.corners_world_m[c], 1.0);
        seen.corners_px[c] = lens.ProjectToPixel(glm::dvec3(pose * corner)).value() +
                             glm::dvec2(noise(random), noise(random));
      }
      view.markers.push_back(seen);
    }
  }
  return views;
}

double WorstCornerM(const MarkerBoard& a, const MarkerBoard& b) {
  double worst = 0.0;
  EXPECT_EQ(a.markers.size(), b.markers.size());
  for (std::size_t i = 0; i < a.markers.size(); ++i) {
    EXPECT_EQ(a.markers[i].id, b.markers[i].id);
    for (std::size_t c = 0; c < 4; ++c) {
      worst = std::max(
          worst, glm::distance(a.markers[i].corners_world_m[c], b.markers[i].corners_world_m[c]));
    }
  }
  return worst;
}

TEST(MarkerBundle, GivesTheBoardBackThatMadeExactCorners) {
  const MarkerBoard board = RoomBoard();
  const auto fit =
      FitMarkerBoard(Lens(MarkerCamera()), board.dictionary, kSizeM, Views(board, 5, 0.0), 3);
  EXPECT_LT(fit.rms_px, 1e-4);
  EXPECT_EQ(fit.fitted.size(), 5u);
  EXPECT_TRUE(fit.rejected.empty());
  // Marker 3 is the room's origin.
  EXPECT_LT(WorstCornerM(fit.board, board), 1e-6);
}

// Noise of 0.2 px a coordinate is 0.6 mm at 1.8 m, and a marker's tilt 0.2 px over its 60 px: 0.2
// degrees, which over 0.7 m of board is 2.5 mm; ten pictures halve that and more, twice it for the
// worst of 16 corners. Tying it to where two markers are known takes out the first one's tilt.
TEST(MarkerBundle, StandsNoise) {
  const MarkerBoard board = RoomBoard();
  auto fit =
      FitMarkerBoard(Lens(MarkerCamera()), board.dictionary, kSizeM, Views(board, 10, 0.2), 3);
  // 320 residuals, 78 of them spent on poses; 3 standard deviations of that.
  EXPECT_NEAR(fit.rms_px, 0.2 * std::sqrt(2.0 * 242.0 / 320.0), 0.035);
  EXPECT_LT(WorstCornerM(fit.board, board), 3e-3);
  EXPECT_LT(MoveBoardTo(board, fit.board), 1e-3);
  EXPECT_LT(WorstCornerM(fit.board, board), 2e-3);
}

// No picture shows all: 3 with 7, 7 with 11, 11 with 20.
TEST(MarkerBundle, GoesFromMarkerToMarker) {
  const MarkerBoard board = RoomBoard();
  std::vector<MarkerView> views = Views(board, 9, 0.05);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto first = views[i].markers.begin() + static_cast<std::ptrdiff_t>(i % 3);
    views[i].markers = {first, first + 2};
  }
  const auto fit = FitMarkerBoard(Lens(MarkerCamera()), board.dictionary, kSizeM, views, 3);
  ASSERT_EQ(fit.board.markers.size(), 4u);
  EXPECT_EQ(fit.placed[1].views, 6);
  // Three links of two markers each: the tilt of each adds to the next.
  EXPECT_LT(WorstCornerM(fit.board, board), 0.01);
}

TEST(MarkerBundle, MovesToWhereAMarkerIsKnown) {
  const MarkerBoard board = RoomBoard();
  auto fit =
      FitMarkerBoard(Lens(MarkerCamera()), board.dictionary, kSizeM, Views(board, 5, 0.0), 11);
  EXPECT_EQ(fit.reference_id, 11);
  MarkerBoard anchor = board;
  anchor.markers = {board.markers[3]};
  EXPECT_LT(MoveBoardTo(anchor, fit.board), 1e-6);
  EXPECT_LT(WorstCornerM(fit.board, board), 1e-5);
  anchor.markers[0].id = 40;
  EXPECT_THROW(MoveBoardTo(anchor, fit.board), std::runtime_error);
  anchor.dictionary = "4x4_50";
  EXPECT_THROW(MoveBoardTo(anchor, fit.board), std::runtime_error);
}

TEST(MarkerBundleHardCases, NamesThePicturesThatAreOfNoUse) {
  const MarkerBoard board = RoomBoard();
  std::vector<MarkerView> views = Views(board, 8, 0.1);
  views[0].markers.clear();
  views[1].markers.resize(1);
  views[2].markers[1].id = views[2].markers[0].id;
  // A marker moved while this one was taken.
  for (glm::dvec2& corner : views[5].markers[2].corners_px) corner.x += 15.0;
  views[6].markers.push_back({99, views[6].markers[0].corners_px});
  views[6].markers.erase(views[6].markers.begin());
  const auto fit = FitMarkerBoard(Lens(MarkerCamera()), board.dictionary, kSizeM, views, 3);
  std::vector<std::string> names;
  for (const RejectedMarkerView& view : fit.rejected) names.push_back(view.name);
  EXPECT_THAT(names, ElementsAre("picture 0", "picture 1", "picture 2", "picture 5"));
  EXPECT_THAT(fit.rejected[2].reason, HasSubstr("2 times"));
  EXPECT_NEAR(fit.rms_px, 0.14, 0.04);
}

TEST(MarkerBundleHardCases, ReportsWhyItFails) {
  const Lens lens(MarkerCamera());
  const MarkerBoard board = RoomBoard();
  std::vector<MarkerView> views = Views(board, 3, 0.1);
  const auto refusal = [&](std::span<const MarkerView> some, std::optional<int> reference) {
    try {
      FitMarkerBoard(lens, board.dictionary, kSizeM, some, reference);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal({}, {}), HasSubstr("two markers or more"));
  EXPECT_THAT(refusal(views, 500), HasSubstr("marker 500"));
  // Each picture of another arrangement.
  std::mt19937 random(1);
  std::uniform_real_distribution<double> anywhere(50.0, 400.0);
  for (MarkerView& view : views) {
    for (DetectedMarker& marker : view.markers) {
      const glm::dvec2 at(anywhere(random), anywhere(random));
      marker.corners_px = {
          at, at + glm::dvec2(60, 5), at + glm::dvec2(50, 55), at + glm::dvec2(-4, 60)};
    }
  }
  EXPECT_THAT(refusal(views, {}), HasSubstr("miss one board by"));
  EXPECT_THROW(FitMarkerBoard(lens, board.dictionary, 0.0, views), std::invalid_argument);
  EXPECT_THROW(FitMarkerBoard(lens, "none", kSizeM, views), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::marker_bundle_test
