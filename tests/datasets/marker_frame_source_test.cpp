#include "datasets/marker_frame_source.h"

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "scene/image_io.h"
#include "tests/calib/marker_scene.h"

namespace pleinair::marker_frame_source_test {
namespace {

using testing::HasSubstr;

// Seven frames, 40 ms apart, of a camera that moves along the board; no poses in sequence.json.
// Frame 3 shows no marker, frame 5 cannot be read.
class MarkerFrames : public testing::Test {
 protected:
  static constexpr int kFrames = 7;

  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              (std::string("pleinair_marker_frames_") +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "scene.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    nlohmann::json document = nlohmann::json::parse(R"json({
      "format": "pleinair-sequence", "version": 1,
      "site": {"latitude_deg": 57.0, "longitude_deg": 9.9, "height_m": 15.0},
      "camera": {"width": 320, "height": 240, "fx": 300, "fy": 300, "cx": 160, "cy": 119},
      "scene": {"mesh": "scene.obj"}, "frames": []})json");
    for (int i = 0; i < kFrames; ++i) {
      const std::string name = std::to_string(i) + ".png";
      if (i != 5) WritePng(folder_ / name, Picture(i));
      document["frames"].push_back({{"image_ldr", name},
                                    {"time_utc",
                                     "2026-06-21T10:00:00." + std::string(i < 3 ? "0" : "") +
                                         std::to_string(40 * i) + "Z"}});
    }
    document["frames"][0]["time_utc"] = "2026-06-21T10:00:00.000Z";
    std::ofstream(folder_ / "sequence.json") << document.dump();
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  static CameraIntrinsics Intrinsics() {
    CameraIntrinsics camera;
    camera.width_px = 320;
    camera.height_px = 240;
    camera.fx_px = camera.fy_px = 300.0;
    camera.cx_px = 160.0;
    camera.cy_px = 119.0;
    return camera;
  }
  static glm::dmat4 TruePose(int i) { return LookAt({0.02 * i, -1.5, 1.1}, {0.05, 0.2, 0.1}); }
  static Rgb8Image Picture(int i) {
    const Gray8Image grey =
        i == 3 ? Gray8Image(320, 240, 120) : RenderMarkers(RoomBoard(), Intrinsics(), TruePose(i));
    Rgb8Image picture(grey.width, grey.height);
    for (std::size_t k = 0; k < grey.pixels.size(); ++k) {
      picture.pixels[k] = glm::u8vec3(grey.pixels[k]);
    }
    return picture;
  }

  std::filesystem::path folder_;
};

TEST_F(MarkerFrames, HaveThePosesOfTheirMarkers) {
  EXPECT_THROW(ReadSequence(folder_), std::runtime_error);
  const Sequence sequence = ReadSequence(folder_, SequencePoses::kMayBeAbsent);
  std::vector<MarkerFrameReport> reports;
  MarkerFrameOptions options;
  options.on_frame = [&](const MarkerFrameReport& report) { reports.push_back(report); };
  const auto frames =
      MakeRecordedMarkerFrameSource(sequence, FrameKind::kLinear, RoomBoard(), options);
  EXPECT_EQ(frames->Count(), kFrames);
  for (int i = 0; i < kFrames; ++i) {
    const auto frame = frames->Next();
    ASSERT_TRUE(frame);
    ASSERT_EQ(reports.size(), static_cast<std::size_t>(i + 1));
    EXPECT_EQ(reports.back().index, i);
    if (i == 5) {
      ASSERT_FALSE(*frame);
      EXPECT_THAT(frame->error().reason, HasSubstr("5.png"));
      continue;
    }
    ASSERT_TRUE(*frame) << frame->error().reason;
    EXPECT_EQ((*frame)->index, i);
    // Frame 3 carries frame 2's.
    const glm::dmat4 truth = TruePose(i == 3 ? 2 : i);
    // 320 px over 1.7 m: corners to 0.15 px, 16 of them: 1 mm; a few times that.
    EXPECT_LT(glm::distance(CentreOfPose((*frame)->camera.camera_from_world), CentreOfPose(truth)),
              5e-3);
    EXPECT_EQ(reports.back().used->carried_frames, i == 3 ? 1 : 0);
    EXPECT_EQ(reports.back().markers.size(), i == 3 ? 0u : 4u);
  }
  EXPECT_FALSE(frames->Next());
}

TEST_F(MarkerFrames, AFrameWhosePoseIsNotKnownIsItsOwnError) {
  const Sequence sequence = ReadSequence(folder_, SequencePoses::kMayBeAbsent);
  MarkerFrameOptions options;
  options.tracker.carry_frames = 0;
  const auto frames =
      MakeRecordedMarkerFrameSource(sequence, FrameKind::kLdr, RoomBoard(), options);
  for (int i = 0; i < kFrames; ++i) {
    const auto frame = frames->Next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->has_value(), i != 3 && i != 5) << i;
    if (i == 3) {
      EXPECT_EQ(frame->error().reason, "camera pose is not known: no marker is seen");
    }
  }
}

TEST_F(MarkerFrames, TheFirstPoseStandsForTheSequence) {
  const Sequence sequence = ReadSequence(folder_, SequencePoses::kMayBeAbsent);
  const Sequence placed = WithFirstMarkerPose(sequence, FrameKind::kLdr, RoomBoard());
  EXPECT_LT(glm::distance(placed.CameraOfFrame(4).CentreWorldM(), CentreOfPose(TruePose(0))), 5e-3);
  MarkerBoard other = RoomBoard();
  for (BoardMarker& marker : other.markers) marker.id += 100;
  try {
    WithFirstMarkerPose(sequence, FrameKind::kLdr, other);
    FAIL() << "markers were found that are not there";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("sequence.json: expected a frame that shows enough"));
    EXPECT_THAT(error.what(), HasSubstr("no marker of the board is seen (but 4 others)"));
  }
}

}  // namespace
}  // namespace pleinair::marker_frame_source_test
