#include "calib/fisheye_camera.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/fisheye_file.h"
#include "sunmodel/angles.h"

namespace pleinair::fisheye_camera_test {
namespace {

const glm::dvec3 kEast{1.0, 0.0, 0.0};
const glm::dvec3 kNorth{0.0, 1.0, 0.0};
const glm::dvec3 kUp{0.0, 0.0, 1.0};

TEST(FisheyeCamera, KnowsTheWorldsAxesByName) {
  for (const char* text : {"+Y", "+Y north", "+Y (north)", "north", "North"}) {
    EXPECT_EQ(WorldAxisFromText(text), kNorth) << text;
  }
  EXPECT_EQ(WorldAxisFromText("-X west"), -kEast);
  EXPECT_EQ(WorldAxisFromText("down"), -kUp);
  for (const char* text : {"", " ", "Y", "+Y east", "+W", "+Y north up", "northward"}) {
    EXPECT_FALSE(WorldAxisFromText(text)) << text;
  }
}

// px = (u - W/2)/(W/2), py = (H/2 - v)/(H/2), pixel centres at +0.5; theta = r pi/2; direction =
// (px/r sin(theta), py/r sin(theta), cos(theta)): the formula that recorded sequences state for an
// equidistant sky picture with north at the top and east at the right.
TEST(FisheyeCamera, FollowsTheStatedFormulaOfSkyPictures) {
  FisheyeCamera camera;
  camera.intrinsics = CentredFisheye(FisheyeModel::kEquidistant, RadFromDeg(180.0), 64, 64);
  const auto orientation = FisheyeOrientationFromAxes(kUp, kNorth, kEast);
  ASSERT_TRUE(orientation);
  camera.world_from_camera = *orientation;
  EXPECT_LT(glm::determinant(camera.world_from_camera), 0.0);
  const FisheyePixelTable table = MakeFisheyePixelTable(camera);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const double px = (x + 0.5 - 32.0) / 32.0;
      const double py = (32.0 - (y + 0.5)) / 32.0;
      const double r = std::hypot(px, py);
      const double theta = r * std::acos(0.0);
      const glm::vec3 expected =
          r <= 1.0 ? glm::vec3(px / r * std::sin(theta), py / r * std::sin(theta), std::cos(theta))
                   : glm::vec3(0.0f);
      EXPECT_LT(glm::distance(table.direction_world.At(x, y), expected), 1e-6f) << x << " " << y;
      EXPECT_EQ(table.solid_angle_sr.At(x, y) > 0.0f, r <= 1.0);
    }
  }
}

TEST(FisheyeCamera, DistinguishesAMirroredPictureFromACamerasOwn) {
  FisheyeCamera camera;
  camera.world_from_camera = *FisheyeOrientationFromAxes(kUp, kNorth, -kEast);
  EXPECT_GT(glm::determinant(camera.world_from_camera), 0.0);
  EXPECT_FALSE(FisheyeOrientationFromAxes(kUp, kNorth, glm::dvec3(0.6, 0.8, 0.0)));
  EXPECT_FALSE(FisheyeOrientationFromAxes(kUp, kUp, kEast));
}

class FisheyeFile : public testing::Test {
 protected:
  void SetUp() override {
    file_ = std::filesystem::path(testing::TempDir()) /
            (std::string("pleinair_fisheye_") +
             testing::UnitTest::GetInstance()->current_test_info()->name() + ".json");
  }
  void TearDown() override { std::filesystem::remove(file_); }
  void Write(const std::string& text) { std::ofstream(file_, std::ios::binary) << text; }

  std::filesystem::path file_;
};

TEST_F(FisheyeFile, GivesBackWhatWasWritten) {
  FisheyeCalibration written;
  written.intrinsics = CentredFisheye(FisheyeModel::kEquisolid, RadFromDeg(186.0), 640, 480);
  Write(FisheyeCalibrationText(written));
  FisheyeCalibration read = ReadFisheyeCalibration(file_);
  EXPECT_NEAR(read.intrinsics.max_angle_rad, written.intrinsics.max_angle_rad, 1e-15);
  read.intrinsics.max_angle_rad = written.intrinsics.max_angle_rad;
  EXPECT_EQ(read.intrinsics, written.intrinsics);
  EXPECT_FALSE(read.world_from_camera || read.room_from_fisheye_rgb || read.rms_px);

  written.intrinsics.model = FisheyeModel::kOpenCv;
  written.intrinsics.distortion = {0.01, -0.002, 0.003, -0.0004};
  written.world_from_camera = FisheyeOrientationFromAxes(kUp, kNorth, kEast);
  written.room_from_fisheye_rgb = glm::dmat3(1.25, 0.5, 0.0, 0.0, 1.5, 0.25, 0.0, 0.0, 0.75);
  written.rms_px = 0.25;
  Write(FisheyeCalibrationText(written));
  read = ReadFisheyeCalibration(file_);
  EXPECT_EQ(read.intrinsics.distortion, written.intrinsics.distortion);
  EXPECT_EQ(read.world_from_camera, written.world_from_camera);
  EXPECT_EQ(read.room_from_fisheye_rgb, written.room_from_fisheye_rgb);
  EXPECT_EQ(read.rms_px, 0.25);
}

TEST_F(FisheyeFile, IsRefusedByKey) {
  const std::string good = FisheyeCalibrationText(
      {CentredFisheye(FisheyeModel::kEquisolid, RadFromDeg(186.0), 640, 480), {}, {}, {}});
  const auto refusal = [this](std::string text, const std::string& old, const std::string& fresh) {
    const std::size_t at = text.find(old);
    EXPECT_NE(at, std::string::npos) << old;
    Write(text.replace(at, old.size(), fresh));
    try {
      ReadFisheyeCalibration(file_);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_NE(refusal(good, "equisolid", "orthographic").find("model"), std::string::npos);
  EXPECT_NE(refusal(good, "equisolid", "opencv").find("distortion"), std::string::npos);
  EXPECT_NE(refusal(good, "\"width\"", "\"breadth\"").find("breadth"), std::string::npos);
  EXPECT_NE(refusal(good, "\"fov_deg\"", "\"distortion\": [0, 0, 1, 0], \"fov_deg\"")
                .find("distortion[2]"),
            std::string::npos);
  EXPECT_NE(refusal(good,
                    "\"fov_deg\"",
                    "\"orientation_world_from_camera\": [[1,0,0],[0,1,0],[0,0,2]], \"fov_deg\"")
                .find("orthogonal"),
            std::string::npos);
  const auto tied_by = [&](const std::string& rows) {
    return refusal(good, "\"fov_deg\"", "\"room_from_fisheye_rgb\": " + rows + ", \"fov_deg\"");
  };
  EXPECT_EQ(tied_by("[[1.5,-0.5,0],[0,1,0],[0,-0.2,0.7]]"), "accepted");
  EXPECT_NE(tied_by("[[1e300,0,0],[0,1,0],[0,0,1]]").find("room_from_fisheye_rgb[0][0]: expected"),
            std::string::npos);
  EXPECT_NE(tied_by("[[1,0,0],[0,-1,0],[0,0,1]]")
                .find("room_from_fisheye_rgb[1]: expected numbers whose sum is above 0, as white "
                      "light stays light, found a list of 3 (0, -1, 0)"),
            std::string::npos);
  EXPECT_NE(refusal(good, "pleinair-fisheye", "yaml").find("format"), std::string::npos);
}

}  // namespace
}  // namespace pleinair::fisheye_camera_test
