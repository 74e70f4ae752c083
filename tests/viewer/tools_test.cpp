// What keys, menu and buttons do with the tools, without a window.
#include "apps/viewer/tool_hand.h"

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "apps/viewer/actions.h"
#include "apps/viewer/picture_cursor.h"
#include "apps/viewer/view_model.h"
#include "calib/camera_pose.h"
#include "calib/colour_chart.h"
#include "calib/lens.h"
#include "calib/response.h"
#include "datasets/sequence.h"
#include "datasets/site_file.h"
#include "tests/scene/shell.h"
#include "tests/viewer/coarse_courtyard.h"

namespace pleinair::tools_test {
namespace {

using testing::HasSubstr;

constexpr double kReachPx = 8.0;
constexpr glm::ivec2 kFirst(100, 60);
constexpr int kPatchPx = 30;
const std::array<glm::dvec2, 4> kCorners{
    glm::dvec2(99.5, 59.5), {279.5, 59.5}, {279.5, 179.5}, {99.5, 179.5}};

// A ColorChecker, in greys, in front of grey.
Rgb8Image ChartPicture() {
  RgbImage light(480, 360, glm::vec3(0.2f));
  for (int i = 0; i < kChartPatches; ++i) {
    const glm::ivec2 at = kFirst + kPatchPx * glm::ivec2(i % 6, i / 6);
    const auto grey = static_cast<float>(kChartReflectance[static_cast<std::size_t>(i)]);
    for (int y = 0; y < kPatchPx; ++y) {
      for (int x = 0; x < kPatchPx; ++x) light.At(at.x + x, at.y + y) = glm::vec3(grey);
    }
  }
  return CodesFromRadiance(light, ResponseCurve::Srgb(), 1.0);
}

class Tools : public testing::Test {
 protected:
  Tools() {
    model_.site = ViewedSiteOf(copy_.Path());
    model_.editor.emplace(model_.site);
    Show(ReadSequence(copy_.Path()).CameraOfFrame(0), ChartPicture());
  }
  void Show(const Camera& camera, Rgb8Image picture) {
    auto frame = std::make_shared<ViewedFrame>();
    frame->number = ++frames_;
    frame->step.frame.emplace();
    frame->step.frame->camera = camera;
    frame->step.frame->codes = std::move(picture);
    model_.frame = std::move(frame);
  }
  void Take(Tool tool) {
    TakeTool(tool, model_);
    ASSERT_TRUE(TakeUpTool(model_)) << model_.status;
  }
  void Press(const glm::dvec2& pixel) {
    model_.hand.Press({pixel, PictureSide::kCamera, kReachPx, false}, model_);
  }
  void Click(const glm::dvec2& pixel) {
    Press(pixel);
    model_.hand.Release(model_);
  }
  // With a curve of one picture.
  void MarkResponseChart() {
    Take(Tool::kResponse);
    model_.response->SetWay(ResponseWay::kChart);
    for (const glm::dvec2& corner : kCorners) Click(corner);
    TakePicture(model_);
    ASSERT_TRUE(model_.response->Found() && *model_.response->Found())
        << model_.response->Describe();
  }
  const ResponseTable& Curve() const { return (*model_.response->Found())->table; }
  // As a camera that is turned a little would see them.
  void PickCorners(std::size_t count) {
    Take(Tool::kPose);
    const Camera& real = model_.pose->Shown();
    Camera turned = real;
    turned.camera_from_world =
        glm::rotate(glm::dmat4(1.0), 0.01, glm::dvec3(0.3, 1.0, 0.1)) * real.camera_from_world;
    std::vector<glm::dvec3> corners;
    for (const glm::dvec2& pixel : model_.pose->CornersInView()) {
      corners.push_back(model_.pose->CornerAt(pixel, 0.01).value());
    }
    for (std::size_t i = 0; i < count; ++i) {
      const glm::dvec3 corner = corners.at(i * corners.size() / count);
      const glm::dvec3 seen(turned.camera_from_world * glm::dvec4(corner, 1.0));
      model_.pose->Pick(corner, ProjectToPixel(turned.intrinsics, seen).value());
    }
  }
  glm::dmat4 SavedPose() const {
    return ReadSequence(copy_.Path()).CameraOfFrame(0).camera_from_world;
  }

  CourtyardCopy copy_;
  ViewModel model_;
  std::int64_t frames_ = 0;
};

// Escape, and another tool, in the middle of a press.
class LetGo : public Tools, public testing::WithParamInterface<bool> {
 protected:
  void EndWithoutEffect() {
    const Tool tool = model_.tool;
    if (GetParam()) {
      Take(Tool::kObjects);
      Take(tool);
    } else {
      model_.hand.LetGo(model_);
    }
    EXPECT_FALSE(model_.hand.IsDown());
    model_.hand.MoveTo({50.0, 300.0}, model_);  // Nothing is held.
  }
};

TEST_P(LetGo, AStrokeOfTheMaskIsAsIfItWasNotBegun) {
  Take(Tool::kMask);
  const std::vector<std::uint8_t> before = model_.mask->Mask().pixels;
  Press({200.0, 300.0});
  model_.hand.MoveTo({260.0, 300.0}, model_);
  ASSERT_NE(model_.mask->Mask().pixels, before);
  EXPECT_EQ(UnsavedWork(model_), "mask");
  EndWithoutEffect();
  EXPECT_EQ(model_.mask->Mask().pixels, before);
  EXPECT_EQ(UnsavedWork(model_), "");
  // One that was put down stays, also where the next one is let go after an undo.
  Click({200.0, 300.0});
  const std::vector<std::uint8_t> painted = model_.mask->Mask().pixels;
  Press({300.0, 300.0});
  Undo(model_);
  EndWithoutEffect();
  EXPECT_EQ(model_.mask->Mask().pixels, painted);
}

TEST_P(LetGo, ASurfaceStaysWhereItWas) {
  Take(Tool::kColour);
  Click({239.0, 319.0});
  const std::vector<PickedSurface> before = model_.colour->Surfaces();
  ASSERT_TRUE(before.at(0).other);
  const std::string described = model_.colour->Describe();
  Press({239.0, 319.0});
  model_.hand.MoveTo({300.0, 330.0}, model_);
  ASSERT_NE(model_.colour->Surfaces(), before);
  EndWithoutEffect();
  EXPECT_EQ(model_.colour->Surfaces(), before);
  EXPECT_EQ(model_.colour->Describe(), described);
  Press({88.0, 239.0});
  EndWithoutEffect();
  EXPECT_EQ(model_.colour->Surfaces(), before);
  Undo(model_);
  EXPECT_TRUE(model_.colour->Surfaces().empty());
}

TEST_P(LetGo, TheCurveIsThatOfTheCornersThatAreShown) {
  MarkResponseChart();
  const ResponseTable before = Curve();
  Press(kCorners[2]);
  model_.hand.MoveTo(kCorners[2] - 25.0, model_);
  EndWithoutEffect();
  EXPECT_THAT(model_.response->Chart().Corners(), testing::ElementsAreArray(kCorners));
  EXPECT_EQ(Curve(), before);
  // Saved in the middle of a press: of the corner where it is.
  Press(kCorners[2]);
  model_.hand.MoveTo(kCorners[2] - 25.0, model_);
  ASSERT_TRUE(Save(model_)) << model_.status;
  EXPECT_NE(Curve(), before);
  const ResponseCurve saved = ResponseCurve::FromFile(copy_ / "camera_response.json");
  EXPECT_EQ(saved.FileText(), ResponseCurve::FromTable(Curve()).FileText());
}

INSTANTIATE_TEST_SUITE_P(ByEscapeAndByAnotherTool, LetGo, testing::Bool());

TEST_F(Tools, AMaskAndAPoseAreUndoneAndRedone) {
  Take(Tool::kMask);
  const std::vector<std::uint8_t> empty = model_.mask->Mask().pixels;
  Click({200.0, 300.0});
  const std::vector<std::uint8_t> painted = model_.mask->Mask().pixels;
  Undo(model_);
  EXPECT_EQ(model_.mask->Mask().pixels, empty);
  Redo(model_);
  EXPECT_EQ(model_.mask->Mask().pixels, painted);
  EXPECT_EQ(UnsavedWork(model_), "mask");

  PickCorners(8);
  const glm::dmat4 found = model_.pose->Shown().camera_from_world;
  Undo(model_);
  EXPECT_EQ(model_.pose->Picks().size(), 7u);
  Redo(model_);
  EXPECT_EQ(model_.pose->Picks().size(), 8u);
  EXPECT_LT(RotationBetweenRad(model_.pose->Shown().camera_from_world, found), 1e-6);
  // All at once, by the panel's button.
  model_.pose->Clear();
  Undo(model_);
  EXPECT_EQ(model_.pose->Picks().size(), 8u);
}

TEST_F(Tools, NothingIsSavedOfAMaskWithoutAStroke) {
  Take(Tool::kMask);
  const std::string before = ContentOf(copy_ / "sequence.json");
  EXPECT_FALSE(Save(model_));
  EXPECT_THAT(model_.status, HasSubstr("nothing was painted"));
  EXPECT_EQ(ContentOf(copy_ / "sequence.json"), before);
}

TEST_F(Tools, AllThatIsNotSavedIsAskedAboutAndSaved) {
  EXPECT_EQ(UnsavedWork(model_), "");
  Take(Tool::kColour);
  EXPECT_EQ(UnsavedWork(model_), "");
  Click({239.0, 319.0});
  EXPECT_EQ(UnsavedWork(model_), "colours");
  MarkResponseChart();
  PickCorners(8);
  EXPECT_EQ(UnsavedWork(model_), "camera's pose, response, colours");
  const glm::dmat4 shown = model_.pose->Shown().camera_from_world;
  SaveAndQuit(model_);
  EXPECT_EQ(model_.quitting, Quitting::kYes) << model_.status;
  EXPECT_EQ(UnsavedWork(model_), "");
  EXPECT_EQ(SavedPose(), shown);
  EXPECT_EQ(ReadSequence(copy_.Path()).response_ldr, "camera_response.json");
}

TEST_F(Tools, WhatCannotBeSavedDoesNotQuit) {
  PickCorners(3);
  EXPECT_EQ(UnsavedWork(model_), "camera's pose");
  const std::string before = ContentOf(copy_ / "sequence.json");
  SaveAndQuit(model_);
  EXPECT_EQ(model_.quitting, Quitting::kNo);
  EXPECT_THAT(model_.status, HasSubstr("3 of 4 picks"));
  EXPECT_EQ(ContentOf(copy_ / "sequence.json"), before);
  EXPECT_EQ(model_.pose->Picks().size(), 3u);
}

// Until the site is read again, frames come with the pose that it had.
TEST_F(Tools, ASavedPoseIsNotTakenBackByTheNextSave) {
  PickCorners(8);
  ASSERT_TRUE(Save(model_)) << model_.status;
  const glm::dmat4 saved = SavedPose();
  EXPECT_GT(RotationBetweenRad(saved, model_.ShownCamera()->camera_from_world), 0.005);
  ASSERT_TRUE(TakeUpTool(model_));
  EXPECT_EQ(model_.pose->Shown().camera_from_world, saved);
  EXPECT_TRUE(model_.pose->Picks().empty());
  ASSERT_TRUE(Save(model_)) << model_.status;
  EXPECT_EQ(SavedPose(), saved);
  // Another program's, once the site is read again.
  const glm::dmat4 other = glm::translate(glm::dmat4(1.0), {0.0, 0.0, 0.1}) * saved;
  EditSiteFile(copy_.Path(), [&](nlohmann::ordered_json& json) {
    json["camera"]["camera_from_world"] = JsonOf(other);
  });
  model_.pose->SetSite(ViewedSiteOf(copy_.Path()));
  EXPECT_EQ(model_.pose->Shown().camera_from_world, other);
  EXPECT_EQ(UnsavedWork(model_), "");
}

// Of a recording whose next picture is smaller, or where another picture is opened.
TEST_F(Tools, TheCursorStaysInAPictureThatBecomesSmaller) {
  Take(Tool::kColour);
  MoveCursor({1000.0, 1000.0}, model_);
  EXPECT_EQ(model_.cursor.pixel, glm::dvec2(479.0, 359.0));
  Camera small = *model_.ShownCamera();
  small.intrinsics.width_px = 240;
  small.intrinsics.height_px = 180;
  Show(small, Rgb8Image(240, 180, glm::u8vec3(100)));
  PressAtCursor(false, model_);
  EXPECT_EQ(model_.cursor.pixel, glm::dvec2(239.0, 179.0));
  ASSERT_EQ(model_.colour->Surfaces().size(), 1u);
  EXPECT_EQ(model_.colour->Surfaces()[0].camera.at_px, model_.cursor.pixel);
}

}  // namespace
}  // namespace pleinair::tools_test
