// Reconstructions that are damaged, empty or not expressible.
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/reconstruction/reconstruction_file.h"
#include "tests/datasets/colmap_files.h"

namespace pleinair::reconstruction_hard_cases_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string RefusalOf(const ColmapModel& model) {
  const TemporaryFolder binary;
  WriteColmapBinary(model, binary);
  const TemporaryFolder text;
  WriteColmapText(model, text);
  const std::string refusal = MessageOf([&] { ReadColmap(binary.Path()); });
  EXPECT_THAT(refusal, Not(HasSubstr("\n")));
  EXPECT_EQ(MessageOf([&] { ReadColmap(text.Path()); }).empty(), refusal.empty());
  return refusal;
}

TEST(ColmapHardCases, EveryTruncationIsRefused) {
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    const TemporaryFolder folder;
    WriteColmapBinary(SmallColmapModel(), folder);
    const std::string complete = ContentOf(folder / name);
    for (std::size_t size = 0; size < complete.size(); ++size) {
      folder.Write(name, complete.substr(0, size));
      EXPECT_THAT(MessageOf([&] { ReadColmap(folder.Path()); }), HasSubstr(name)) << size;
    }
    folder.Write(name, complete + "x");
    EXPECT_THAT(MessageOf([&] { ReadColmap(folder.Path()); }), HasSubstr("end of the file"));
  }
}

// A count that would ask for more memory than there is.
TEST(ColmapHardCases, AbsurdCountsAreRefusedBeforeMemoryIsTaken) {
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    const TemporaryFolder folder;
    WriteColmapBinary(SmallColmapModel(), folder);
    std::string bytes = ContentOf(folder / name);
    for (const std::uint64_t count : {~std::uint64_t{0}, std::uint64_t{1} << 40U}) {
      std::memcpy(bytes.data(), &count, sizeof(count));
      folder.Write(name, bytes);
      EXPECT_THAT(MessageOf([&] { ReadColmap(folder.Path()); }),
                  AllOf(HasSubstr(name), HasSubstr("no more entries")));
    }
  }
}

TEST(ColmapHardCases, CamerasThatTheLensCannotExpressAreNamed) {
  ColmapModel model = SmallColmapModel();
  model.cameras = {{1, 5, "OPENCV_FISHEYE", 640, 480, {500, 500, 320, 240, 0.1, 0, 0, 0}}};
  EXPECT_THAT(RefusalOf(model),
              AllOf(HasSubstr("OPENCV_FISHEYE"), HasSubstr("colmap image_undistorter")));
  model.cameras = {{1, 6, "FULL_OPENCV", 640, 480, {500, 500, 320, 240, 0, 0, 0, 0, 0, 0.1, 0, 0}}};
  EXPECT_THAT(RefusalOf(model), HasSubstr("FULL_OPENCV"));
  model.cameras = {{1, 99, "NOVEL", 640, 480, {}}};
  EXPECT_THAT(RefusalOf(model), HasSubstr("99"));
}

TEST(ColmapHardCases, NumbersThatAreNoneAreRefused) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double bad : {kNan, kInfinity, -kInfinity, 1e300}) {
    ColmapModel model = SmallColmapModel();
    model.points[1].position.y = bad;
    EXPECT_THAT(RefusalOf(model), HasSubstr("points3D.bin"));
    model = SmallColmapModel();
    model.images[0].translation.z = bad;
    EXPECT_THAT(RefusalOf(model), HasSubstr("images.bin"));
    model = SmallColmapModel();
    model.images[0].seen[0].x = bad;
    EXPECT_THAT(RefusalOf(model), HasSubstr("images.bin"));
  }
  for (const double bad : {kNan, kInfinity, 0.0, -500.0}) {
    ColmapModel model = SmallColmapModel();
    model.cameras[0].parameters[0] = bad;
    EXPECT_THAT(RefusalOf(model), HasSubstr("cameras.bin"));
  }
  ColmapModel model = SmallColmapModel();
  model.images[0].camera_from_model = {0.0, 0.0, 0.0, 0.0};
  EXPECT_THAT(RefusalOf(model), HasSubstr("rotation"));
  model.images[0].camera_from_model = {kNan, 0.0, 0.0, 0.0};
  EXPECT_THAT(RefusalOf(model), HasSubstr("rotation"));
}

TEST(ColmapHardCases, WhatIsMissingIsNamed) {
  ColmapModel model = SmallColmapModel();
  model.points.clear();
  EXPECT_THAT(RefusalOf(model), HasSubstr("points"));
  model = SmallColmapModel();
  model.images.clear();
  EXPECT_THAT(RefusalOf(model), HasSubstr("picture"));
  model = SmallColmapModel();
  model.images[1].camera = 8;
  EXPECT_THAT(RefusalOf(model), HasSubstr("camera 8"));
  model = SmallColmapModel();
  model.points[1].id = 7;
  EXPECT_THAT(RefusalOf(model), HasSubstr("point 7 is there twice"));
  model = SmallColmapModel();
  model.cameras[0].width = std::uint64_t{1} << 63U;
  EXPECT_THAT(RefusalOf(model), HasSubstr("cameras.bin"));
  const TemporaryFolder empty;
  EXPECT_THAT(MessageOf([&] { ReadReconstruction(empty.Path()); }), HasSubstr("COLMAP"));
  EXPECT_THAT(MessageOf([&] { ReadReconstruction(empty / "none"); }), HasSubstr("found nothing"));
}

// Points that a person has deleted from points3D: their observations are left out, noted.
TEST(ColmapHardCases, ObservationsWithoutTheirPointAreNoted) {
  const TemporaryFolder folder;
  ColmapModel model = SmallColmapModel();
  model.points.erase(model.points.begin());
  WriteColmapBinary(model, folder);
  const Reconstruction read = ReadColmap(folder.Path());
  EXPECT_EQ(read.pictures[0].observations.size(), 1u);
  EXPECT_THAT(read.notes, testing::ElementsAre(HasSubstr("1 observation")));
}

TEST(ColmapHardCases, TextsThatAreDamagedNameTheLine) {
  const TemporaryFolder folder;
  WriteColmapText(SmallColmapModel(), folder);
  folder.Write("points3D.txt", "# comment\n7 1 2 x 255 0 51 0.5\n");
  EXPECT_THAT(MessageOf([&] { ReadColmap(folder.Path()); }), HasSubstr("points3D.txt:2"));
  WriteColmapText(SmallColmapModel(), folder);
  folder.Write("images.txt", "1 1 0 0 0 0 0 0 1 one.jpg");
  EXPECT_THAT(MessageOf([&] { ReadColmap(folder.Path()); }),
              AllOf(HasSubstr("images.txt:1"), HasSubstr("line")));
}

std::string OpenSfmRefusal(const std::string& text) {
  const TemporaryFolder folder;
  return MessageOf([&] { ReadOpenSfm(folder.Write("reconstruction.json", text)); });
}

TEST(OpenSfmHardCases, DamagedFilesNameTheKey) {
  EXPECT_THAT(OpenSfmRefusal("[]"), HasSubstr("reconstruction.json"));
  EXPECT_THAT(OpenSfmRefusal("{}"), HasSubstr("reconstruction.json"));
  EXPECT_THAT(OpenSfmRefusal(R"([{"shots": {}}])"), HasSubstr("cameras"));
  EXPECT_THAT(OpenSfmRefusal(R"([{"cameras": {"c": {"projection_type": "fisheye", "width": 4,
                                 "height": 3, "focal": 1}}, "shots": {}, "points": {}}])"),
              AllOf(HasSubstr("projection_type"), HasSubstr("fisheye")));
  const std::string camera =
      R"([{"cameras": {"c": {"projection_type": "perspective", "width": 4, "height": 3,
          "focal": 1, "k1": 0, "k2": 0}}, )";
  EXPECT_THAT(OpenSfmRefusal(camera + R"("shots": {}, "points": {}}])"), HasSubstr("picture"));
  EXPECT_THAT(OpenSfmRefusal(camera + R"("shots": {"a.jpg": {"rotation": [0, "x", 1],
                             "translation": [0, 0, 0], "camera": "c"}}, "points": {}}])"),
              HasSubstr("rotation"));
  EXPECT_THAT(OpenSfmRefusal(camera + R"("shots": {"a.jpg": {"rotation": [0, 0, 0],
                             "translation": [0, 0, 0], "camera": "c"}}, "points": {}}])"),
              HasSubstr("points"));
  EXPECT_THAT(OpenSfmRefusal(camera + R"("shots": {"a.jpg": {"rotation": [0, 0, 0],
                             "translation": [0, 0, 0], "camera": "other"}}, "points": {}}])"),
              HasSubstr("camera other"));
}

}  // namespace
}  // namespace pleinair::reconstruction_hard_cases_test
