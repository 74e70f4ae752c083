#include "apps/calibrate_pose_command.h"

#include <random>
#include <vector>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "calib/camera_pose.h"
#include "datasets/sequence.h"
#include "datasets/site_file.h"
#include "sunmodel/angles.h"
#include "tests/calib/marker_scene.h"
#include "tests/session/command_folder.h"

namespace pleinair::calibrate_pose_command_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// A site that is not complete yet: a lens, and eight points about a courtyard of 8 m.
class CalibratePose : public CommandFolder {
 protected:
  void SetUp() override {
    CommandFolder::SetUp();
    WriteSite();
    for (const glm::dvec3& point : {glm::dvec3(-4, 3, 0),
                                    glm::dvec3(-4, 3, 3),
                                    glm::dvec3(0, 4, 0),
                                    glm::dvec3(0.5, 4, 2.5),
                                    glm::dvec3(3, 3, 0),
                                    glm::dvec3(3, 2, 3.5),
                                    glm::dvec3(-1.5, 0, 0),
                                    glm::dvec3(1.5, -0.5, 0)}) {
      picks_.push_back({point, *lens_.ProjectToPixel(glm::dvec3(truth_ * glm::dvec4(point, 1.0)))});
    }
    options_.site = folder_;
  }

  void WriteSite(const nlohmann::ordered_json& more = nlohmann::ordered_json::object()) {
    const CameraIntrinsics& camera = lens_.Intrinsics();
    nlohmann::ordered_json site = {{"format", "pleinair-site"},
                                   {"version", 1},
                                   {"note_made", "by hand"},
                                   {"camera",
                                    {{"width", camera.width_px},
                                     {"height", camera.height_px},
                                     {"fx", camera.fx_px},
                                     {"fy", camera.fy_px},
                                     {"cx", camera.cx_px},
                                     {"cy", camera.cy_px},
                                     {"distortion", camera.distortion}}}};
    site.merge_patch(more);
    Write("site.json", site.dump());
  }

  CalibratePoseOptions From(const std::vector<PointMatch>& picks) {
    std::string table = "# x, y, x, y, z\n";
    for (const PointMatch& pick : picks) {
      table += fmt::format("{},{},{},{},{}\n",
                           pick.pixel.x,
                           pick.pixel.y,
                           pick.point_world_m.x,
                           pick.point_world_m.y,
                           pick.point_world_m.z);
    }
    options_.points = Write("picks.csv", table);
    return options_;
  }

  const Lens lens_{MarkerCamera()};
  const glm::dmat4 truth_ = LookAt({0.5, -6.0, 1.7}, {0.0, 2.0, 1.2});
  std::vector<PointMatch> picks_;
  CalibratePoseOptions options_;
};

TEST_F(CalibratePose, WritesThePoseIntoTheSite) {
  std::vector<PointMatch> picks = picks_;
  picks[2].pixel.x += 60.0;
  CalibratePoseOptions options = From(picks);
  options.out = folder_ / "site.json";
  const std::string report = RunCalibratePose(options);
  EXPECT_THAT(report, HasSubstr("rms 0.00 px over 7 of 8 picks"));
  EXPECT_THAT(report, HasSubstr("60.00  0.000, 4.000, 0.000  left out"));
  EXPECT_THAT(report, HasSubstr("camera at 0.500, -6.000, 1.700 m, sigma"));
  const StatedCamera written = ReadStatedCamera(folder_);
  EXPECT_EQ(written.intrinsics, lens_.Intrinsics());
  ASSERT_TRUE(written.camera_from_world);
  EXPECT_LT(RotationBetweenRad(*written.camera_from_world, truth_), 1e-7);
  std::ifstream stream(folder_ / "site.json");
  const auto document = nlohmann::ordered_json::parse(stream);
  EXPECT_EQ(document.begin().key(), "format");
  EXPECT_EQ(document["note_made"], "by hand");
}

// A square seen nearly from the front: its mirrored pose fits to the picks' own pixel.
TEST_F(CalibratePose, RefusesAMirroredTwinUnlessToldWhereTheCameraIs) {
  const glm::dmat4 truth = LookAt({0.3, -10.0, 1.2}, {0.0, 0.0, 1.0});
  std::vector<PointMatch> picks;
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0.0, 0.7);
  for (const glm::dvec3& point : {glm::dvec3(-0.5, 0, 0.5),
                                  glm::dvec3(0.5, 0, 0.5),
                                  glm::dvec3(0.5, 0, 1.5),
                                  glm::dvec3(-0.5, 0, 1.5)}) {
    picks.push_back({point,
                     *lens_.ProjectToPixel(glm::dvec3(truth * glm::dvec4(point, 1.0))) +
                         glm::dvec2(noise(random), noise(random))});
  }
  CalibratePoseOptions options = From(picks);
  options.out = folder_ / "out.json";
  EXPECT_THAT(Refusal(RunCalibratePose, options),
              AllOf(HasSubstr("picks.csv: the camera's pose cannot be determined: two poses"),
                    HasSubstr("reprojection errors")));
  EXPECT_FALSE(std::filesystem::exists(options.out));
  options.near_stated = true;
  EXPECT_THAT(Refusal(RunCalibratePose, options), HasSubstr("expected for --near-stated"));
}

// Near the stated pose, from several pictures: the bundled courtyard's, with a camera turned by
// 0.7 deg.
TEST_F(CalibratePose, NearTheStatedPoseByEdges) {
  const std::filesystem::path courtyard = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard";
  const Sequence sequence = ReadSequence(courtyard);
  const glm::dmat4 truth = sequence.camera_from_world.value();
  const glm::dmat4 turned =
      glm::rotate(glm::dmat4(1.0), RadFromDeg(0.7), glm::normalize(glm::dvec3(1.0, -1.0, 0.0))) *
      truth;
  nlohmann::ordered_json camera = JsonOf(sequence.intrinsics);
  camera["camera_from_world"] = JsonOf(turned);
  Write("turned.json", nlohmann::ordered_json{{"camera", camera}}.dump());
  CalibratePoseOptions options;
  options.site = folder_ / "turned.json";
  options.mesh = courtyard / "scene.obj";
  options.edges = {courtyard / "frames/000000.exr"};
  options.more_edges = {courtyard / "frames/000002.exr", courtyard / "frames/000004.exr"};
  EXPECT_THAT(Refusal(RunCalibratePose, options), HasSubstr("--near-stated"));
  options.near_stated = true;
  options.out = folder_ / "out.json";
  EXPECT_THAT(RunCalibratePose(options), AllOf(HasSubstr("odds for it"), HasSubstr("turned by")));
  EXPECT_LT(RotationBetweenRad(ReadStatedCamera(options.out).camera_from_world.value(), truth),
            RadFromDeg(0.35));
}

TEST_F(CalibratePose, RefusalsAreOneLineWithTheReason) {
  EXPECT_THAT(Refusal(RunCalibratePose, From({picks_[0], picks_[1], picks_[2]})),
              AllOf(HasSubstr("3 points leave"), HasSubstr("expected 4 or more")));
  std::vector<PointMatch> line;
  for (int i = 0; i < 6; ++i) {
    const glm::dvec3 point(i - 3.0, 2.0, 0.0);
    line.push_back({point, *lens_.ProjectToPixel(glm::dvec3(truth_ * glm::dvec4(point, 1.0)))});
  }
  EXPECT_THAT(Refusal(RunCalibratePose, From(line)), HasSubstr("the points lie on one line"));
  std::vector<PointMatch> wrong = picks_;
  for (std::size_t i = 0; i < 6; ++i) wrong[i].pixel = picks_[(i + 1) % 6].pixel;
  EXPECT_THAT(Refusal(RunCalibratePose, From(wrong)),
              AllOf(HasSubstr("no pose fits more than"), HasSubstr("reprojection error")));
  options_.points.clear();
  EXPECT_THAT(Refusal(RunCalibratePose, options_), HasSubstr("expected one of"));
}

TEST_F(CalibratePose, LeavesFramesWithPosesOfTheirOwnAlone) {
  WriteSite({{"frames", {{{"image", "0.exr"}, {"camera_from_world", {1}}}}}});
  CalibratePoseOptions options = From(picks_);
  options.out = folder_ / "out.json";
  EXPECT_THAT(Refusal(RunCalibratePose, options), HasSubstr("a camera that stands still"));
  // The same in a file of their own.
  WriteSite({{"frames", "frames.jsonl"}});
  Write("frames.jsonl",
        "{\"image\": \"0.exr\"}\n{\"image\": \"1.exr\", \"camera_from_world\": [1]}\n{");
  EXPECT_THAT(Refusal(RunCalibratePose, options), HasSubstr("a camera that stands still"));
  EXPECT_FALSE(std::filesystem::exists(options.out));
}

}  // namespace
}  // namespace pleinair::calibrate_pose_command_test
