#include "datasets/reconstruction/reconstruction_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/lens.h"
#include "sunmodel/angles.h"
#include "tests/datasets/colmap_files.h"

namespace pleinair::reconstruction_test {
namespace {

TEST(Colmap, ReadsWhatWasWritten) {
  const TemporaryFolder folder;
  WriteColmapBinary(SmallColmapModel(), folder);
  const Reconstruction read = ReadReconstruction(folder.Path());
  ASSERT_EQ(read.cameras.size(), 1u);
  const CameraIntrinsics& camera = read.cameras[0].intrinsics;
  EXPECT_EQ(camera.width_px, 640);
  EXPECT_EQ(camera.height_px, 480);
  EXPECT_EQ(camera.fx_px, 500.0);
  EXPECT_EQ(camera.fy_px, 501.0);
  // COLMAP's pixels have their corners at integers, ours their centres.
  EXPECT_EQ(camera.cx_px, 320.0);
  EXPECT_EQ(camera.cy_px, 239.75);
  EXPECT_FALSE(camera.HasDistortion());

  ASSERT_EQ(read.points.size(), 3u);
  EXPECT_EQ(read.points[2].id, 7);
  EXPECT_EQ(read.points[2].position, glm::dvec3(1.0, 2.0, 3.0));
  EXPECT_EQ(read.points[2].colour_srgb, glm::dvec3(1.0, 0.0, 0.2));
  ASSERT_EQ(read.pictures.size(), 2u);
  EXPECT_EQ(read.pictures[0].name, "a walk/one.jpg");
  EXPECT_TRUE(read.pictures[1].observations.empty());
  // The pixel without a point is no observation.
  ASSERT_EQ(read.pictures[0].observations.size(), 2u);
  EXPECT_EQ(read.pictures[0].observations[0].point, 2u);
  EXPECT_EQ(read.pictures[0].observations[0].pixel, glm::dvec2(10.0, 19.75));
  EXPECT_EQ(read.pictures[0].observations[1].point, 0u);

  const glm::dquat q = SmallColmapModel().images[0].camera_from_model;
  const glm::dvec3 moved(read.pictures[0].camera_from_model * glm::dvec4(1.0, 2.0, 3.0, 1.0));
  const glm::dvec3 expected = q * glm::dvec3(1.0, 2.0, 3.0) + glm::dvec3(0.25, -1.5, 3.0);
  EXPECT_LT(glm::distance(moved, expected), 1e-14);
  EXPECT_TRUE(read.notes.empty());
}

TEST(Colmap, TextAndBinaryAreTheSame) {
  const TemporaryFolder binary;
  const TemporaryFolder text;
  WriteColmapBinary(SmallColmapModel(), binary);
  WriteColmapText(SmallColmapModel(), text);
  const Reconstruction a = ReadColmap(binary.Path());
  const Reconstruction b = ReadColmap(text.Path());
  EXPECT_EQ(a.cameras[0].intrinsics, b.cameras[0].intrinsics);
  ASSERT_EQ(a.pictures.size(), b.pictures.size());
  for (std::size_t i = 0; i < a.pictures.size(); ++i) {
    EXPECT_EQ(a.pictures[i].name, b.pictures[i].name);
    EXPECT_EQ(a.pictures[i].camera_from_model, b.pictures[i].camera_from_model);
    ASSERT_EQ(a.pictures[i].observations.size(), b.pictures[i].observations.size());
    for (std::size_t o = 0; o < a.pictures[i].observations.size(); ++o) {
      EXPECT_EQ(a.pictures[i].observations[o].point, b.pictures[i].observations[o].point);
      EXPECT_EQ(a.pictures[i].observations[o].pixel, b.pictures[i].observations[o].pixel);
    }
  }
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_EQ(a.points[i].id, b.points[i].id);
    EXPECT_EQ(a.points[i].position, b.points[i].position);
    EXPECT_EQ(a.points[i].colour_srgb, b.points[i].colour_srgb);
  }
}

CameraIntrinsics ReadCamera(std::int32_t model,
                            const std::string& name,
                            const std::vector<double>& parameters) {
  const TemporaryFolder folder;
  ColmapModel colmap = SmallColmapModel();
  colmap.cameras = {{1, model, name, 640, 480, parameters}};
  WriteColmapBinary(colmap, folder);
  const CameraIntrinsics binary = ReadColmap(folder.Path()).cameras[0].intrinsics;
  const TemporaryFolder texts;
  WriteColmapText(colmap, texts);
  EXPECT_EQ(ReadColmap(texts.Path()).cameras[0].intrinsics, binary);
  return binary;
}

// COLMAP's models in OpenCV's five coefficients: k1, k2, p1, p2, k3.
TEST(Colmap, ReadsItsCameraModels) {
  using D = std::array<double, 5>;
  const CameraIntrinsics simple = ReadCamera(0, "SIMPLE_PINHOLE", {500, 320, 240});
  EXPECT_EQ(simple.fx_px, 500.0);
  EXPECT_EQ(simple.fy_px, 500.0);
  EXPECT_EQ(simple.cx_px, 319.5);
  EXPECT_EQ(simple.distortion, D{});
  EXPECT_EQ(ReadCamera(2, "SIMPLE_RADIAL", {500, 320, 240, -0.1}).distortion, D{-0.1});
  EXPECT_EQ(ReadCamera(3, "RADIAL", {500, 320, 240, -0.1, 0.02}).distortion, (D{-0.1, 0.02}));
  const CameraIntrinsics opencv =
      ReadCamera(4, "OPENCV", {500, 510, 320, 240, -0.1, 0.02, 0.003, -0.004});
  EXPECT_EQ(opencv.fy_px, 510.0);
  EXPECT_EQ(opencv.distortion, (D{-0.1, 0.02, 0.003, -0.004}));
  EXPECT_EQ(
      ReadCamera(6, "FULL_OPENCV", {500, 510, 320, 240, -0.1, 0.02, 0.003, -0.004, 0.005, 0, 0, 0})
          .distortion,
      (D{-0.1, 0.02, 0.003, -0.004, 0.005}));
}

constexpr const char* kOpenSfm = R"([
 {"cameras": {}, "shots": {}, "points": {}},
 {"cameras": {
   "phone": {"projection_type": "perspective", "width": 400, "height": 300, "focal": 0.9,
             "k1": -0.1, "k2": 0.02},
   "slr": {"projection_type": "brown", "width": 300, "height": 400, "focal_x": 0.8,
           "focal_y": 0.81, "c_x": 0.01, "c_y": -0.02, "k1": 0.1, "k2": 0.2, "k3": 0.3,
           "p1": 0.01, "p2": 0.02}},
  "shots": {
   "b.jpg": {"rotation": [0, 0, 0], "translation": [1, 2, 3], "camera": "slr"},
   "a.jpg": {"rotation": [0, 0, 1.5707963267948966], "translation": [0, 0, 5], "camera": "phone",
             "orientation": 1, "gps_dop": 5.0}},
  "points": {"12": {"coordinates": [1, 2, 3], "color": [255, 0, 51]}},
  "reference_lla": {"latitude": 52.5, "longitude": 13.4, "altitude": 30.0}}])";

TEST(OpenSfm, ReadsTheBiggestReconstruction) {
  const TemporaryFolder folder;
  folder.Write("reconstruction.json", kOpenSfm);
  const Reconstruction read = ReadReconstruction(folder.Path());
  ASSERT_EQ(read.pictures.size(), 2u);
  EXPECT_EQ(read.pictures[0].name, "a.jpg");
  const CameraIntrinsics& phone = read.cameras[read.pictures[0].camera].intrinsics;
  EXPECT_EQ(phone.fx_px, 360.0);
  EXPECT_EQ(phone.cx_px, 199.5);
  EXPECT_EQ(phone.cy_px, 149.5);
  EXPECT_EQ(phone.distortion, (std::array<double, 5>{-0.1, 0.02}));
  const CameraIntrinsics& slr = read.cameras[read.pictures[1].camera].intrinsics;
  EXPECT_EQ(slr.fx_px, 320.0);
  EXPECT_EQ(slr.fy_px, 324.0);
  EXPECT_EQ(slr.cx_px, 149.5 + 4.0);
  EXPECT_EQ(slr.cy_px, 199.5 - 8.0);
  EXPECT_EQ(slr.distortion, (std::array<double, 5>{0.1, 0.2, 0.01, 0.02, 0.3}));
  // A quarter turn about the camera's axis takes x to y.
  const glm::dvec3 moved(read.pictures[0].camera_from_model * glm::dvec4(1.0, 0.0, 0.0, 1.0));
  EXPECT_LT(glm::distance(moved, glm::dvec3(0.0, 1.0, 5.0)), 1e-15);
  ASSERT_EQ(read.points.size(), 1u);
  EXPECT_EQ(read.points[0].id, 12);
  EXPECT_EQ(read.points[0].colour_srgb, glm::dvec3(1.0, 0.0, 0.2));
  ASSERT_TRUE(read.enu_at.has_value());
  EXPECT_EQ(read.enu_at->latitude_rad, RadFromDeg(52.5));
  EXPECT_EQ(read.enu_at->height_m, 30.0);
  EXPECT_THAT(read.notes,
              testing::ElementsAre("the biggest of 2 reconstructions is used: 2 pictures"));
}

TEST(Reconstruction, ASimilarityKeepsWhatPicturesShow) {
  const TemporaryFolder folder;
  WriteColmapBinary(SmallColmapModel(), folder);
  Reconstruction moved = ReadColmap(folder.Path());
  const Reconstruction before = moved;
  const glm::dmat3 rotation = glm::mat3_cast(glm::normalize(glm::dquat(0.3, -0.4, 0.5, 0.6)));
  Transform({2.5, rotation, {100.0, -20.0, 3.0}}, moved);
  for (std::size_t p = 0; p < moved.pictures.size(); ++p) {
    for (std::size_t i = 0; i < moved.points.size(); ++i) {
      const glm::dvec3 seen(before.pictures[p].camera_from_model *
                            glm::dvec4(before.points[i].position, 1.0));
      const glm::dvec3 now(moved.pictures[p].camera_from_model *
                           glm::dvec4(moved.points[i].position, 1.0));
      EXPECT_LT(glm::distance(now, 2.5 * seen), 1e-12);
    }
    EXPECT_LT(glm::distance(
                  moved.pictures[p].Centre(),
                  2.5 * (rotation * before.pictures[p].Centre()) + glm::dvec3(100.0, -20.0, 3.0)),
              1e-12);
  }
}

}  // namespace
}  // namespace pleinair::reconstruction_test
