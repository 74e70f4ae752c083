#include "apps/calibrate_markers_command.h"

#include <filesystem>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "apps/calibrate_pose_command.h"
#include "datasets/sequence.h"
#include "scene/image_io.h"
#include "tests/calib/marker_scene.h"
#include "tests/session/command_folder.h"

namespace pleinair::calibrate_markers_command_test {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::filesystem::path kShared = PLEINAIR_SHARED_DIR;
constexpr int kFrames = 5;

// Pictures from an arc about the board, which are the frames of a sequence as well; the third shows
// no marker.
class CalibrateMarkers : public CommandFolder {
 protected:
  void SetUp() override {
    CommandFolder::SetUp();
    Write("scene.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const CameraIntrinsics camera = MarkerCamera();
    nlohmann::json document = nlohmann::json::parse(R"json({
      "format": "pleinair-sequence", "version": 1, "note_made": "by hand",
      "site": {"latitude_deg": 57.0, "longitude_deg": 9.9, "height_m": 15.0},
      "scene": {"mesh": "scene.obj"}, "frames": []})json");
    document["camera"] = {{"width", camera.width_px},
                          {"height", camera.height_px},
                          {"fx", camera.fx_px},
                          {"fy", camera.fy_px},
                          {"cx", camera.cx_px},
                          {"cy", camera.cy_px},
                          {"distortion", camera.distortion}};
    for (int i = 0; i < kFrames; ++i) {
      const std::string name = std::to_string(i) + ".png";
      const Gray8Image grey = i == 2 ? Gray8Image(camera.width_px, camera.height_px, 120)
                                     : RenderMarkers(RoomBoard(), camera, TruePose(i));
      Rgb8Image picture(grey.width, grey.height);
      for (std::size_t k = 0; k < grey.pixels.size(); ++k) {
        picture.pixels[k] = glm::u8vec3(grey.pixels[k]);
      }
      WritePng(folder_ / name, picture);
      pictures_.push_back(folder_ / name);
      document["frames"].push_back(
          {{"image_ldr", name}, {"time_utc", "2026-06-21T10:0" + std::to_string(i) + ":00Z"}});
    }
    Write("sequence.json", document.dump());
  }

  static glm::dmat4 TruePose(int i) {
    const double azimuth = 0.3 * (i - 2);
    return LookAt({1.6 * std::sin(azimuth), -1.6 * std::cos(azimuth), 1.0}, {0.05, 0.2, 0.1});
  }

  std::vector<std::filesystem::path> pictures_;
};

// From pictures to a board, and from that to poses of the same pictures. A corner is found to 0.1
// px, which is 0.3 mm here; the reference marker's tilt is open to 0.1 px over its 60 px, 1.7 mrad,
// and turns everything that is 0.7 m away by 1 mm. A few times that.
TEST_F(CalibrateMarkers, MakesABoardAndThenPoses) {
  CalibrateMarkersOptions markers;
  markers.pictures = pictures_;
  markers.camera = folder_;
  markers.size_m = 0.2;
  markers.reference = 3;
  markers.out = folder_ / "board.json";
  const std::string report = RunCalibrateMarkers(markers);
  EXPECT_THAT(report, HasSubstr("2.png: left out: no marker found"));
  EXPECT_THAT(report, HasSubstr("over 4 pictures"));
  const MarkerBoard board = ReadMarkerBoard(markers.out);
  const MarkerBoard truth = RoomBoard();
  ASSERT_EQ(board.markers.size(), truth.markers.size());
  for (std::size_t i = 0; i < board.markers.size(); ++i) {
    for (std::size_t c = 0; c < 4; ++c) {
      EXPECT_LT(
          glm::distance(board.markers[i].corners_world_m[c], truth.markers[i].corners_world_m[c]),
          5e-3);
    }
  }

  CalibratePoseOptions pose;
  pose.site = folder_;
  pose.markers = markers.out;
  pose.out = folder_ / "with_poses.json";
  const std::string table = RunCalibratePose(pose);
  EXPECT_THAT(table, HasSubstr("4 of 5 frames have a pose"));
  EXPECT_THAT(table, HasSubstr("2  left out: camera pose is not known: no marker is seen"));
  // It is a sequence, its notes kept.
  std::filesystem::rename(pose.out, folder_ / "sequence.json");
  const Sequence sequence = ReadSequence(folder_);
  ASSERT_EQ(sequence.frames.size(), 4u);
  EXPECT_EQ(sequence.frames[2].image_ldr, std::filesystem::path("3.png"));
  for (std::size_t f = 0; f < 4; ++f) {
    const int i = f < 2 ? static_cast<int>(f) : static_cast<int>(f) + 1;
    EXPECT_LT(glm::distance(sequence.CameraOfFrame(f).CentreWorldM(), CentreOfPose(TruePose(i))),
              0.01);
  }
  std::ifstream stream(folder_ / "sequence.json");
  EXPECT_EQ(nlohmann::json::parse(stream)["note_made"], "by hand");
}

// A lens is all that it needs of the camera: no mesh, no frames, no place.
TEST_F(CalibrateMarkers, NeedsNoSequenceAroundTheLens) {
  std::ifstream stream(folder_ / "sequence.json");
  const nlohmann::json camera = nlohmann::json::parse(stream)["camera"];
  CalibrateMarkersOptions markers;
  markers.pictures = pictures_;
  markers.camera = Write("lens.json", nlohmann::json{{"camera", camera}}.dump());
  markers.size_m = 0.2;
  markers.out = folder_ / "board.json";
  std::filesystem::remove(folder_ / "scene.obj");
  EXPECT_THAT(RunCalibrateMarkers(markers), HasSubstr("over 4 pictures"));
  markers.camera = folder_;
  EXPECT_THAT(RunCalibrateMarkers(markers), HasSubstr("over 4 pictures"));
}

TEST_F(CalibrateMarkers, AnAnchorPutsTheBoardIntoTheWorld) {
  MarkerBoard anchor = RoomBoard();
  anchor.markers = {anchor.markers[1], anchor.markers[3]};
  for (BoardMarker& marker : anchor.markers) {
    for (glm::dvec3& corner : marker.corners_world_m) corner += glm::dvec3(10.0, -4.0, 2.0);
  }
  CalibrateMarkersOptions markers;
  markers.pictures = pictures_;
  markers.camera = folder_;
  markers.size_m = 0.2;
  markers.anchor = Write("anchor.json", MarkerBoardText(anchor));
  markers.out = folder_ / "board.json";
  EXPECT_THAT(RunCalibrateMarkers(markers), HasSubstr("anchor.json says; corners miss that by"));
  const MarkerBoard board = ReadMarkerBoard(markers.out);
  EXPECT_LT(glm::distance(board.markers[0].corners_world_m[0],
                          RoomBoard().markers[0].corners_world_m[0] + glm::dvec3(10.0, -4.0, 2.0)),
            5e-3);
}

TEST_F(CalibrateMarkers, RefusalsAreOneLineAndWriteNothing) {
  CalibrateMarkersOptions markers;
  markers.pictures = {pictures_[2]};
  markers.camera = folder_;
  markers.size_m = 0.2;
  markers.out = folder_ / "board.json";
  EXPECT_THAT(Refusal(RunCalibrateMarkers, markers), HasSubstr("two markers or more"));
  markers.pictures = {folder_ / "none.png"};
  EXPECT_THAT(Refusal(RunCalibrateMarkers, markers), HasSubstr("none.png"));
  WritePng(folder_ / "small.png", Rgb8Image(20, 20));
  markers.pictures = {folder_ / "small.png"};
  EXPECT_THAT(Refusal(RunCalibrateMarkers, markers), HasSubstr("expected 640x480 pixels"));
  EXPECT_FALSE(std::filesystem::exists(markers.out));

  MarkerBoard other = RoomBoard();
  for (BoardMarker& marker : other.markers) marker.id += 50;
  CalibratePoseOptions pose;
  pose.site = folder_;
  pose.markers = Write("other.json", MarkerBoardText(other));
  pose.out = folder_ / "with_poses.json";
  EXPECT_THAT(Refusal(RunCalibratePose, pose), HasSubstr("expected frames that show markers"));
  EXPECT_FALSE(std::filesystem::exists(pose.out));
}

// Robots that all have the tag of id 0: no board, and it says why.
TEST_F(CalibrateMarkers, RepeatedIdsMakeNoBoard) {
  const std::filesystem::path photograph =
      kShared / "data/markers_apriltag/33369213973_9d9bb4cc96_c.jpg";
  if (!std::filesystem::exists(photograph)) GTEST_SKIP() << "no picture " << photograph;
  nlohmann::json document;
  std::ifstream(folder_ / "sequence.json") >> document;
  document["camera"]["width"] = 799;
  document["camera"]["height"] = 533;
  Write("sequence.json", document.dump());
  CalibrateMarkersOptions markers;
  markers.pictures = {photograph};
  markers.camera = folder_;
  markers.size_m = 0.1;
  markers.out = folder_ / "board.json";
  EXPECT_THAT(Refusal(RunCalibrateMarkers, markers), HasSubstr("expected each id once"));
}

}  // namespace
}  // namespace pleinair::calibrate_markers_command_test
