#include "calib/marker_board.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "calib/json_cursor.h"
#include "tests/calib/marker_scene.h"

namespace pleinair::marker_board_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const glm::dmat4 kPose = LookAt({0.2, -1.6, 1.1}, {0.05, 0.2, 0.1});

class MarkerBoardFile : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(file_); }
  MarkerBoard Read(const std::string& text) {
    std::ofstream(file_, std::ios::binary) << text;
    return ReadMarkerBoard(file_);
  }
  std::string Refusal(const nlohmann::json& document) {
    try {
      Read(document.dump());
    } catch (const JsonError& error) {
      EXPECT_THAT(error.what(), HasSubstr(file_.string()));
      return error.what();
    }
    return "accepted";
  }
  std::filesystem::path file_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string("pleinair_markers_") +
       testing::UnitTest::GetInstance()->current_test_info()->name() + ".json");
};

TEST_F(MarkerBoardFile, ComesBackAsWritten) {
  const MarkerBoard board = RoomBoard();
  const MarkerBoard back = Read(MarkerBoardText(board));
  EXPECT_EQ(back.dictionary, board.dictionary);
  ASSERT_EQ(back.markers.size(), board.markers.size());
  for (std::size_t i = 0; i < back.markers.size(); ++i) {
    EXPECT_EQ(back.markers[i].id, board.markers[i].id);
    EXPECT_EQ(back.markers[i].corners_world_m, board.markers[i].corners_world_m);
  }
}

TEST_F(MarkerBoardFile, RefusalsNameFileAndKey) {
  const nlohmann::json good = nlohmann::json::parse(MarkerBoardText(RoomBoard()));
  EXPECT_EQ(Refusal(good), "accepted");
  const auto changed = [&](const char* pointer, const nlohmann::json& value) {
    nlohmann::json document = good;
    document[nlohmann::json::json_pointer(pointer)] = value;
    return Refusal(document);
  };
  EXPECT_THAT(changed("/format", "pleinair-sequence"), HasSubstr("format"));
  EXPECT_THAT(changed("/version", 2), HasSubstr("version"));
  EXPECT_THAT(changed("/dictionary", "apriltag_99h1"), HasSubstr("apriltag_36h11"));
  EXPECT_THAT(changed("/markers", nlohmann::json::array()), HasSubstr("markers"));
  EXPECT_THAT(changed("/markers/1/id", 587), HasSubstr("markers[1].id"));
  EXPECT_THAT(changed("/markers/1/id", 3), HasSubstr("markers[1].id: expected each id once"));
  EXPECT_THAT(changed("/markers/1/size", 3), HasSubstr("size"));
  EXPECT_THAT(changed("/units", "m"), HasSubstr("units"));
  EXPECT_THAT(changed("/markers/0/corners_world_m/2", {0, 0}), HasSubstr("corners_world_m[2]"));
  EXPECT_THAT(changed("/markers/0/corners_world_m/2/0", "x"), HasSubstr("corners_world_m[2][0]"));
  // Two corners in the wrong order; a square of no size.
  nlohmann::json crossed = good;
  std::swap(crossed["markers"][2]["corners_world_m"][0],
            crossed["markers"][2]["corners_world_m"][1]);
  EXPECT_THAT(Refusal(crossed), HasSubstr("markers[2].corners_world_m: expected the corners of a"));
  const nlohmann::json point = nlohmann::json::array({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}});
  EXPECT_THAT(changed("/markers/0/corners_world_m", point), HasSubstr("square"));
  for (const char* key : {"format", "version", "dictionary", "markers"}) {
    nlohmann::json document = good;
    document.erase(key);
    EXPECT_THAT(Refusal(document), HasSubstr(key));
  }
}

// Corners to 0.1 px over 500 px of picture and 1.9 m of distance, 16 of them: 0.5 mm, 0.3 mrad.
TEST(MarkerBoardPose, IsThatOfThePicture) {
  const MarkerBoard board = RoomBoard();
  const auto seen = DetectMarkers(RenderMarkers(board, MarkerCamera(), kPose), board.dictionary);
  const auto found = FindBoardPose(Lens(MarkerCamera()), board, seen);
  ASSERT_TRUE(found) << found.error().reason;
  EXPECT_THAT(found->markers, ElementsAre(3, 7, 11, 20));
  EXPECT_THAT(found->left_out, ElementsAre());
  EXPECT_LT(found->pose.rms_px, 0.15);
  EXPECT_LT(RotationBetweenRad(found->pose.camera_from_world, kPose), 5e-4);
  EXPECT_LT(glm::distance(CentreOfPose(found->pose.camera_from_world), CentreOfPose(kPose)), 1e-3);
}

// One was moved by 30 cm since the board was measured: named, and the pose is the others'.
TEST(MarkerBoardPose, LeavesOutAMarkerThatWasMoved) {
  const MarkerBoard board = RoomBoard();
  const auto seen = DetectMarkers(RenderMarkers(board, MarkerCamera(), kPose), board.dictionary);
  MarkerBoard measured = board;
  for (glm::dvec3& corner : measured.markers[1].corners_world_m) corner.x += 0.3;
  const auto found = FindBoardPose(Lens(MarkerCamera()), measured, seen);
  ASSERT_TRUE(found) << found.error().reason;
  EXPECT_THAT(found->left_out, ElementsAre(7));
  EXPECT_THAT(found->markers, ElementsAre(3, 11, 20));
  EXPECT_LT(RotationBetweenRad(found->pose.camera_from_world, kPose), 1e-3);
}

TEST(MarkerBoardPose, SaysWhyThereIsNone) {
  const Lens lens(MarkerCamera());
  const MarkerBoard board = RoomBoard();
  const auto nothing = FindBoardPose(lens, board, {});
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().reason, "no marker is seen");
  const std::vector<DetectedMarker> stranger{{99, {}}};
  EXPECT_THAT(FindBoardPose(lens, board, stranger).error().reason, HasSubstr("of the board"));
}

}  // namespace
}  // namespace pleinair::marker_board_test
