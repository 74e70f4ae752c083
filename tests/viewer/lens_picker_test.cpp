#include "apps/viewer/lens_picker.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "datasets/sequence.h"
#include "scene/image_io.h"
#include "tests/calib/drawn_boards.h"
#include "tests/scene/shell.h"
#include "tests/viewer/coarse_courtyard.h"

namespace pleinair::lens_picker_test {
namespace {

using testing::HasSubstr;

constexpr int kWidthPx = 480;  // As the courtyard's camera.
constexpr double kReachPx = 8.0;

class LensPicked : public testing::Test {
 protected:
  // Six boards, the third once more but blurred, and no board.
  LensPicked() {
    boards_ = DrawnBoards(kWidthPx);
    boards_.push_back(Blurred(boards_[2], 3.0));
    boards_.emplace_back(kWidthPx, 3 * kWidthPx / 4, glm::u8vec3(90));
    for (std::size_t i = 0; i < boards_.size(); ++i) {
      WritePng(folder_ / fmt::format("board{}.png", i), boards_[i]);
    }
    picker_.Open(folder_.Path());
    picker_.Await();
  }
  const LensFit& Fit() const { return picker_.Lens().choice.value().fit; }
  const std::vector<BoardCorner>& Corners(std::size_t picture) const {
    return picker_.ResultOf(picture)->board.value().corners;
  }
  std::vector<std::string> Fitted() const {
    std::vector<std::string> names;
    for (const FittedPicture& picture : Fit().fitted) {
      names.push_back(std::filesystem::path(picture.name).stem().string());
    }
    return names;
  }
  // What the same corners give without the picker.
  BoardLens LensOf(std::size_t picture, const std::vector<BoardCorner>& corners) const {
    std::vector<SeenBoard> seen;
    for (std::size_t i = 0; i < boards_.size(); ++i) {
      const LensPicture read(folder_ / fmt::format("board{}.png", i));
      seen.push_back(read.LookAt({{8, 6}, {}}));
      if (i == picture) seen.back().board->corners = corners;
    }
    return FitBoards(seen, std::nullopt);
  }

  TemporaryFolder folder_;
  CourtyardCopy site_;
  std::vector<Rgb8Image> boards_;
  LensPicker picker_{site_ / "sequence.json", [] {}};
};

TEST_F(LensPicked, FindsTheBoardAndNamesWhatIsLeftOut) {
  EXPECT_EQ(picker_.Board()->size, (BoardSize{8, 6}));
  EXPECT_EQ(Fit().Model(), LensModel::kPinhole);
  EXPECT_NEAR(Fit().FxPx(), kDrawnFocalShare * kWidthPx, 0.01 * kDrawnFocalShare * kWidthPx);
  EXPECT_THAT(Fitted(),
              testing::ElementsAre("board0", "board1", "board2", "board3", "board4", "board5"));
  EXPECT_THAT(picker_.DescribePicture(0), HasSubstr("board0.png: rms 0."));
  EXPECT_THAT(picker_.DescribePicture(6), HasSubstr("left out: blurred"));
  EXPECT_THAT(picker_.DescribePicture(7), HasSubstr("left out: no board of 8x6"));
  EXPECT_THAT(picker_.Describe(), HasSubstr("6 of 8 pictures"));
  EXPECT_THAT(picker_.Open(folder_.Path()), HasSubstr("there already"));
  EXPECT_THROW(picker_.Open(folder_ / "absent.png"), std::runtime_error);
}

TEST_F(LensPicked, PicturesAreLeftOutAndTakenBackInByHand) {
  const AnyLens before = Fit().lens;
  picker_.ToggleUse(1);
  picker_.Await();
  EXPECT_THAT(Fitted(), testing::ElementsAre("board0", "board2", "board3", "board4", "board5"));
  EXPECT_THAT(picker_.DescribePicture(1), HasSubstr("left out: by hand"));
  picker_.ToggleUse(1);
  picker_.Await();
  EXPECT_EQ(Fit().lens, before);
  EXPECT_THAT(picker_.ToggleUse(6), HasSubstr("is used, whatever its fit"));
  picker_.Await();
  EXPECT_THAT(Fitted(), testing::Contains("board6"));
  EXPECT_THAT(picker_.ToggleUse(7), HasSubstr("no board"));
  picker_.Undo();
  picker_.Undo();
  picker_.Await();
  EXPECT_THAT(Fitted(), testing::Not(testing::Contains("board1")));
  picker_.Redo();
  picker_.Redo();
  picker_.Await();
  EXPECT_THAT(Fitted(), testing::Contains("board6"));
  picker_.Delete(6);
  picker_.Await();
  EXPECT_EQ(Fit().lens, before);
}

TEST_F(LensPicked, AMovedCornerShowsItsResidualAtOnceAndIsFittedWhenLetGo) {
  const AnyLens before = Fit().lens;
  const std::vector<BoardCorner> found = Corners(3);
  picker_.Select(3);
  ASSERT_TRUE(picker_.Shown());
  EXPECT_THAT(picker_.Press(found[20].pixel + 2.0, kReachPx), HasSubstr("off by 0."));
  picker_.MoveTo(found[20].pixel + glm::dvec2(1.5, 0.0));
  EXPECT_FALSE(picker_.IsBusy());
  EXPECT_NEAR(picker_.ResultOf(3)->fit.value().residual_px[20].x, 1.5, 0.4);
  picker_.Release();
  picker_.Await();
  std::vector<BoardCorner> moved = found;
  moved[20].pixel.x += 1.5;
  EXPECT_EQ(Corners(3), moved);
  EXPECT_NE(Fit().lens, before);
  EXPECT_EQ(Fit().lens, LensOf(3, moved).choice.value().fit.lens);
  EXPECT_EQ(picker_.NextCorner({0.0, 0.0}), moved[20].pixel);  // The worst one.
  // Far off, the picture is left out.
  picker_.Press(moved[20].pixel, kReachPx);
  picker_.MoveTo(moved[20].pixel + 40.0);
  picker_.Release();
  picker_.Await();
  EXPECT_THAT(picker_.DescribePicture(3), HasSubstr("left out: off by"));
  EXPECT_THAT(picker_.FindCorners(), HasSubstr("as they are found"));
  picker_.Await();
  EXPECT_EQ(Corners(3), found);
  EXPECT_EQ(Fit().lens, before);
}

TEST_F(LensPicked, APressThatIsLetGoOrMovesNothingIsNone) {
  const std::vector<BoardCorner> found = Corners(0);
  picker_.Select(0);
  picker_.Press(found[5].pixel, kReachPx);
  picker_.MoveTo(found[5].pixel + 30.0);
  ASSERT_NE(Corners(0), found);
  picker_.LetGo();
  EXPECT_EQ(Corners(0), found);
  picker_.Press(found[5].pixel + 1.0, kReachPx);
  picker_.Release();
  EXPECT_FALSE(picker_.IsBusy());
  EXPECT_EQ(Corners(0), found);
  picker_.Undo();  // Of the pictures that were opened: nothing else was done.
  picker_.Await();
  EXPECT_TRUE(picker_.Boards().pictures.empty());
  EXPECT_FALSE(picker_.Selected());
}

TEST_F(LensPicked, ARemovedCornerIsNotFitted) {
  picker_.Select(4);
  std::vector<BoardCorner> rest = Corners(4);
  EXPECT_THAT(picker_.RemoveCorner(rest[9].pixel, kReachPx), HasSubstr("47 corners"));
  rest.erase(rest.begin() + 9);
  picker_.Await();
  EXPECT_EQ(Corners(4), rest);
  EXPECT_EQ(Fit().lens, LensOf(4, rest).choice.value().fit.lens);
  EXPECT_THAT(picker_.RemoveCorner({2.0, 2.0}, kReachPx), HasSubstr("no corner"));
  while (Corners(4).size() > 5) picker_.RemoveCorner(Corners(4).back().pixel, kReachPx);
  picker_.Await();
  EXPECT_THAT(picker_.DescribePicture(4), HasSubstr("expected 6 corners or more, 5 are left"));
  EXPECT_THAT(Fitted(), testing::Not(testing::Contains("board4")));
}

TEST_F(LensPicked, ALensInDoubtIsSavedOnlyWhereForced) {
  // Pixels that are not square.
  const TemporaryFolder squeezed;
  for (std::size_t i = 0; i < 6; ++i) {
    Rgb8Image& picture = boards_[i];
    cv::Mat pixels(picture.height, picture.width, CV_8UC3, picture.pixels.data());
    cv::Mat narrow;
    cv::resize(pixels, narrow, {432, 360}, 0.0, 0.0, cv::INTER_AREA);
    pixels.setTo(cv::Scalar(150, 150, 150));
    narrow.copyTo(pixels(cv::Rect(24, 0, 432, 360)));
    WritePng(squeezed / fmt::format("board{}.png", i), picture);
  }
  LensPicker picker(site_ / "sequence.json", [] {});
  const std::string before = ContentOf(site_ / "sequence.json");
  try {
    picker.Save(false);
    FAIL() << "a lens without pictures is saved";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("no lens yet: take pictures of a board"));
  }
  picker.Open(squeezed.Path());
  EXPECT_TRUE(picker.HasUnsavedPicks());
  try {
    picker.Save(false);
    FAIL() << "a lens in doubt is saved: " << picker.Describe();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("in doubt: corners are missed by"));
  }
  EXPECT_EQ(ContentOf(site_ / "sequence.json"), before);
  picker.Save(true);
  EXPECT_FALSE(picker.HasUnsavedPicks());
  EXPECT_NE(ContentOf(site_ / "sequence.json"), before);
}

// Pictures come while others are looked at; the last choice counts.
TEST_F(LensPicked, WhatIsChosenWhileItIsBusyCounts) {
  const LensFit chosen = Fit();
  picker_.SetModel(LensModel::kFisheye);
  picker_.SetModel(LensModel::kPinhole);
  picker_.SetSize(BoardSize{7, 6});
  picker_.SetSize(std::nullopt);
  EXPECT_TRUE(picker_.IsBusy());
  picker_.Await();
  EXPECT_EQ(Fit().lens, chosen.lens);
  picker_.SetModel(LensModel::kFisheye);
  picker_.Await();
  EXPECT_EQ(Fit().Model(), LensModel::kFisheye);
  picker_.SetSize(BoardSize{2, 6});
  picker_.Await();
  EXPECT_THAT(picker_.Describe(), HasSubstr("board 2x6: expected 3 or more"));
  picker_.SetMarkers(CharucoMarkers{});
  picker_.SetSize(std::nullopt);
  picker_.Await();
  EXPECT_THAT(picker_.Describe(), HasSubstr("have to be entered"));
}

}  // namespace
}  // namespace pleinair::lens_picker_test
