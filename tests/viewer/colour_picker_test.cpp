#include "apps/viewer/colour_picker.h"

#include <array>
#include <cmath>
#include <fstream>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "apps/calibrate_command.h"
#include "apps/site_response.h"
#include "apps/viewer/pose_picker.h"
#include "datasets/sequence.h"
#include "datasets/site_file.h"
#include "scene/image_io.h"
#include "tests/scene/shell.h"
#include "tests/viewer/coarse_courtyard.h"

namespace pleinair::colour_picker_test {
namespace {

using testing::HasSubstr;

constexpr double kReachPx = 8.0;
constexpr double kRadiusPx = 6.0;

// Patches of 30 px from (100, 60) on, in the chart's colours, as far as a test needs them.
constexpr glm::ivec2 kFirst(100, 60);
constexpr int kPatchPx = 30;
const std::array<glm::dvec2, 4> kCorners{
    glm::dvec2(99.5, 59.5), {279.5, 59.5}, {279.5, 179.5}, {99.5, 179.5}};

// `factor`: what a camera makes of red, green and blue.
RgbImage ChartLight(const glm::dvec3& factor) {
  RgbImage light(480, 360, glm::vec3(0.2f));
  for (int i = 0; i < kChartPatches; ++i) {
    const double grey = kChartReflectance[static_cast<std::size_t>(i)];
    const glm::dvec3 colour = grey * glm::dvec3(1.0 + 0.3 * std::sin(i), 1.0, 0.7);
    const glm::ivec2 at = kFirst + kPatchPx * glm::ivec2(i % 6, i / 6);
    for (int y = 0; y < kPatchPx; ++y) {
      for (int x = 0; x < kPatchPx; ++x) light.At(at.x + x, at.y + y) = glm::vec3(colour * factor);
    }
  }
  return light;
}

class Picker : public testing::Test {
 protected:
  // The site's camera sees the chart.
  Picker() {
    WritePng(copy_ / "camera.png",
             CodesFromRadiance(ChartLight({0.5, 0.6, 0.7}), ResponseCurve::Srgb(), 1.0));
    WritePng(copy_ / "other.png",
             CodesFromRadiance(ChartLight({0.6, 0.6, 0.6}), ResponseCurve::Srgb(), 1.0));
    frame_.number = 1;
    frame_.step.frame.emplace();
    frame_.step.frame->camera = ReadSequence(copy_.Path()).CameraOfFrame(0);
    frame_.step.frame->codes = ReadDisplayImage(copy_ / "camera.png");
  }
  // The response that the command writes.
  std::string Commanded(CalibrateColourOptions options) const {
    options.calibration = copy_.Path();
    options.from_picture = copy_ / "camera.png";
    options.out = copy_ / "commanded" / "sequence.json";
    std::filesystem::create_directories(copy_ / "commanded");
    RunCalibrateColour(options);
    return ContentOf(copy_ / "commanded/camera_response.json");
  }

  static glm::dvec2 MiddleOf(int patch) {
    return glm::dvec2(kFirst + kPatchPx * glm::ivec2(patch % 6, patch / 6) + kPatchPx / 2);
  }
  // In both pictures.
  static void PickPatches(ColourPicker& picker) {
    for (const int patch : {1, 4, 10, 19}) {
      for (const PictureSide side : {PictureSide::kCamera, PictureSide::kOther}) {
        picker.Press(side, MiddleOf(patch), kReachPx, kRadiusPx);
        picker.Release();
      }
    }
    ASSERT_TRUE(picker.Tie() && *picker.Tie()) << picker.Describe();
  }

  CourtyardCopy copy_;
  ViewedFrame frame_;
};

TEST_F(Picker, AColorCheckerGivesWhatTheCommandGives) {
  ColourPicker picker(ViewedSiteOf(copy_.Path()));
  picker.Look(frame_);
  picker.OpenOther(copy_ / "other.png");
  picker.SetWay(ColourWay::kChart);
  for (const PictureSide side : {PictureSide::kCamera, PictureSide::kOther}) {
    EXPECT_THAT(picker.Describe(), HasSubstr("dark skin"));
    for (const glm::dvec2& corner : kCorners) {
      EXPECT_FALSE(picker.Tie());
      // Beside its place, and then dragged there.
      picker.Press(side, corner + 3.0, kReachPx, kRadiusPx);
      picker.MoveTo(corner);
      picker.Release();
    }
  }
  ASSERT_TRUE(picker.Tie() && *picker.Tie()) << picker.Describe();
  const ColourTie& tie = **picker.Tie();
  EXPECT_NEAR(tie.to_from_rgb[0][0], 0.6 / 0.5, 0.01);
  EXPECT_NEAR(tie.to_from_rgb[1][1], 1.0, 0.01);
  EXPECT_NEAR(tie.to_from_rgb[2][2], 0.6 / 0.7, 0.01);
  EXPECT_THAT(picker.Press(PictureSide::kCamera, {10.0, 10.0}, kReachPx, kRadiusPx),
              HasSubstr("has its four corners"));
  std::string corners;
  for (const glm::dvec2& corner : kCorners) {
    corners += fmt::format("{}{},{}", corners.empty() ? "" : ",", corner.x, corner.y);
  }
  CalibrateColourOptions options;
  options.to_picture = copy_ / "other.png";
  options.from_corners = options.to_corners = corners;
  const std::string commanded = Commanded(options);
  picker.Save();
  EXPECT_EQ(ContentOf(copy_ / "camera_response.json"), commanded);
  EXPECT_EQ(ReadSequence(copy_.Path()).response_ldr, "camera_response.json");
}

TEST_F(Picker, ASurfaceThatDoesNotFitIsLeftOutDeletedAndBroughtBack) {
  ColourPicker picker(ViewedSiteOf(copy_.Path()));
  picker.Look(frame_);
  picker.OpenOther(copy_ / "other.png");
  // Patches of the two pictures; the last pair is of two that differ.
  for (const auto& [camera, other] : {std::pair{1, 1},
                                      std::pair{4, 4},
                                      std::pair{10, 10},
                                      std::pair{13, 13},
                                      std::pair{18, 18},
                                      std::pair{22, 19}}) {
    EXPECT_THAT(picker.Press(PictureSide::kCamera, MiddleOf(camera), kReachPx, kRadiusPx),
                HasSubstr("press the same surface in the other picture"));
    picker.Release();
    picker.Press(PictureSide::kOther, MiddleOf(other), kReachPx, kRadiusPx);
    picker.Release();
  }
  ASSERT_TRUE(picker.Tie() && *picker.Tie()) << picker.Describe();
  for (std::size_t i = 0; i < 5; ++i) EXPECT_TRUE(picker.ResidualOf(i)->counts) << i;
  EXPECT_FALSE(picker.ResidualOf(5)->counts);
  EXPECT_GT(picker.ResidualOf(5)->relative, 0.5);
  picker.Delete(5);
  EXPECT_EQ(picker.Surfaces().size(), 5u);
  picker.Undo();
  ASSERT_EQ(picker.Surfaces().size(), 6u);
  EXPECT_FALSE(picker.ResidualOf(5)->counts);
  picker.Redo();
  EXPECT_EQ(picker.Surfaces().size(), 5u);
  EXPECT_EQ((*picker.Tie())->counts.size(), 5u);
}

// As calibrated by a command, or by another tool of the window, since the picker was made.
TEST_F(Picker, TheResponseIsTheSitesAtTheTimeOfSaving) {
  ColourPicker picker(ViewedSiteOf(copy_.Path()));
  picker.Look(frame_);
  picker.OpenOther(copy_ / "other.png");
  PickPatches(picker);
  const double of_srgb = (*picker.Tie())->to_from_rgb[0][0];
  ResponseTable table{};
  for (auto& channel : table) {
    for (std::size_t code = 0; code < channel.size(); ++code) {
      channel[code] = static_cast<float>(std::pow(static_cast<double>(code) / 255.0, 1.6));
    }
  }
  const std::filesystem::path file = copy_ / "sequence.json";
  WriteSiteResponse(ResponseCurve::FromTable(table).FileText(), file, file);
  CalibrateColourOptions options;
  options.to_picture = copy_ / "other.png";
  options.regions = copy_ / "regions.csv";
  std::ofstream regions(options.regions);
  for (const PickedSurface& surface : picker.Surfaces()) {
    const PickedDisc& from = surface.camera;
    const PickedDisc& to = *surface.other;
    regions << fmt::format("{},{},{},{},{},{}\n",
                           from.at_px.x,
                           from.at_px.y,
                           from.radius_px,
                           to.at_px.x,
                           to.at_px.y,
                           to.radius_px);
  }
  regions.close();
  const std::string commanded = Commanded(options);
  picker.Save();
  EXPECT_EQ(ContentOf(copy_ / "camera_response.json"), commanded);
  EXPECT_GT(std::abs((*picker.Tie())->to_from_rgb[0][0] / of_srgb - 1.0), 0.05);
}

TEST_F(Picker, AResponseThatCannotBeReadIsReportedUntilItCan) {
  const auto site = ViewedSiteOf(copy_.Path());
  ColourPicker picker(site);
  picker.Look(frame_);
  picker.OpenOther(copy_ / "other.png");
  PickPatches(picker);
  const std::string known = picker.Describe();
  EditSiteFile(copy_.Path(), [](nlohmann::ordered_json& json) {
    json["radiometry"]["frames_ldr"] = "none.json";
  });
  picker.SetSite(site);
  EXPECT_THAT(picker.Describe(), HasSubstr("none.json"));
  EXPECT_THROW(picker.Save(), std::runtime_error);
  EditSiteFile(copy_.Path(),
               [](nlohmann::ordered_json& json) { json["radiometry"]["frames_ldr"] = "srgb8"; });
  picker.SetSite(site);
  EXPECT_EQ(picker.Describe(), known);
}

// Not only until the next thing that is fitted, and after an 8-bit picture.
TEST_F(Picker, LinearPicturesStayRefused) {
  ColourPicker picker(ViewedSiteOf(copy_.Path()));
  picker.Look(frame_);
  picker.OpenOther(copy_ / "other.png");
  PickPatches(picker);
  ViewedFrame linear = frame_;
  ++linear.number;
  linear.step.frame->codes.reset();
  picker.Look(linear);
  const std::size_t picked = picker.Surfaces().size();
  for (int i = 0; i < 3; ++i) {
    EXPECT_THAT(picker.Describe(), HasSubstr("the camera's pictures are linear"));
    EXPECT_FALSE(picker.Tie());
    picker.Press(PictureSide::kCamera, {200.0, 300.0}, kReachPx, kRadiusPx);
    EXPECT_EQ(picker.Surfaces().size(), picked);
    picker.SetWay(i == 0 ? ColourWay::kChart : ColourWay::kSurfaces);
    picker.OpenOther(copy_ / "other.png");
  }
  frame_.number = linear.number + 1;
  picker.Look(frame_);
  EXPECT_TRUE(picker.Tie() && *picker.Tie()) << picker.Describe();
}

TEST_F(Picker, ASurveyMapThatCannotBeReadLeavesRoomForAnotherPicture) {
  const auto site = ViewedSiteOf(copy_.Path());
  std::ofstream(copy_ / "environment.exr") << "damaged";
  ColourPicker picker(site);
  picker.Look(frame_);
  EXPECT_THAT(picker.Describe(), HasSubstr("environment.exr"));
  EXPECT_FALSE(picker.OtherShown());
  picker.OpenOther(copy_ / "other.png");
  EXPECT_THAT(picker.Describe(), HasSubstr("press surfaces"));
  PickPatches(picker);
}

// Where Tab goes to: corners that are in view, each where the pose puts it, and a press takes it.
TEST(PosePicker, CornersInViewArePressedWhereTheyAre) {
  const CourtyardCopy copy;
  const auto site = ViewedSiteOf(copy.Path());
  const Camera camera = ReadSequence(copy.Path()).CameraOfFrame(0);
  const PosePicker picker(site, camera);
  const std::vector<glm::dvec2> corners = picker.CornersInView();
  ASSERT_GT(corners.size(), 5u);
  // Each once.
  std::set<std::pair<double, double>> places;
  for (const glm::dvec2& corner : corners) {
    EXPECT_TRUE(places.emplace(corner.x, corner.y).second);
    EXPECT_GE(std::min(corner.x, corner.y), 0.0);
    EXPECT_LE(corner.x, camera.intrinsics.width_px - 1);
    EXPECT_LE(corner.y, camera.intrinsics.height_px - 1);
    EXPECT_TRUE(picker.CornerAt(corner, 0.01));
  }
}

}  // namespace
}  // namespace pleinair::colour_picker_test
