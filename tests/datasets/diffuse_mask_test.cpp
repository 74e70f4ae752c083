// Masks of what may be sampled: over the survey map or over the first frame.
#include "datasets/diffuse_mask.h"

#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/frame_source.h"
#include "scene/image_io.h"
#include "tests/datasets/sequence_fixture.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::diffuse_mask_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// A camera of 8x6 pixels, with and without a survey map.
class DiffuseMaskTest : public SequenceFolder {
 protected:
  void SetUp() override {
    SequenceFolder::SetUp();
    document_ = Everything();
    document_["camera"]["width"] = 8;
    document_["camera"]["height"] = 6;
  }
  Sequence Read() {
    WriteDocument(document_);
    return ReadSequence(folder_);
  }
  void WriteMask(int width, int height, int dark_x) {
    Gray8Image mask(width, height, 255);
    mask.At(dark_x, 1) = 0;
    WritePng(folder_ / "mask.png", mask);
  }
  std::string RefusalToSave(int width, int height) {
    const Sequence sequence = Read();
    const std::string before = ContentOf(folder_ / "sequence.json");
    std::string text =
        MessageOf([&] { SaveDiffuseMask(sequence, Gray8Image(width, height, 255)); });
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    EXPECT_EQ(ContentOf(folder_ / "sequence.json"), before);
    return text;
  }

  nlohmann::json document_;
};

TEST_F(DiffuseMaskTest, TheSizeSaysWhatItIsOver) {
  WriteMask(8, 6, 3);
  EXPECT_FALSE(ReadDiffuseMask(Read())->is_over_map);
  WriteMask(64, 32, 3);
  EXPECT_TRUE(ReadDiffuseMask(Read())->is_over_map);
  // A camera with a map's proportions: then as ever over the map.
  document_["camera"]["height"] = 4;
  WriteMask(8, 4, 3);
  EXPECT_TRUE(ReadDiffuseMask(Read())->is_over_map);
  document_.erase("environment");
  EXPECT_FALSE(ReadDiffuseMask(Read())->is_over_map);
  document_.erase("diffuse_mask");
  EXPECT_FALSE(ReadDiffuseMask(Read()));
}

TEST_F(DiffuseMaskTest, OverTheFirstFrameItHoldsForFramesBesideASurveyMap) {
  WriteMask(8, 6, 3);
  Sequence sequence = Read();
  for (FrameEntry& frame : sequence.frames) {
    frame.camera_from_world.reset();
    frame.fisheye.reset();
  }
  WriteExr(
      folder_ / *sequence.frames[0].image, RgbImage(8, 6, glm::vec3(1.0f)), ExrPrecision::kFloat);
  const auto frame = MakeRecordedFrameSource(sequence, FrameKind::kLinear)->Next();
  ASSERT_TRUE(frame);
  ASSERT_TRUE(*frame) << frame->error().reason;
  EXPECT_EQ((*frame)->unusable.At(3, 1), kUnusable);
  EXPECT_EQ((*frame)->unusable.At(4, 1), 0);
}

TEST_F(DiffuseMaskTest, IsSavedTogetherWithTheOneThatIsThere) {
  WriteMask(8, 6, 3);
  Gray8Image mask(8, 6, 255);
  mask.At(5, 2) = 0;
  EXPECT_EQ(SaveDiffuseMask(Read(), mask), folder_ / "mask.png");
  const Gray8Image both = ReadDiffuseMask(ReadSequence(folder_))->image;
  EXPECT_EQ(both.At(3, 1), 0);
  EXPECT_EQ(both.At(5, 2), 0);
  EXPECT_EQ(both.At(4, 4), 255);
  // The first one.
  document_.erase("diffuse_mask");
  EXPECT_EQ(SaveDiffuseMask(Read(), mask), folder_ / "diffuse_mask.png");
  EXPECT_EQ(ReadSequence(folder_).diffuse_mask, "diffuse_mask.png");
  EXPECT_EQ(ReadDiffuseMask(ReadSequence(folder_))->image.pixels, mask.pixels);
}

TEST_F(DiffuseMaskTest, RefusesWhatWouldMeanSomethingElse) {
  WriteMask(64, 32, 3);
  EXPECT_THAT(RefusalToSave(8, 6), HasSubstr("sequence.json: diffuse_mask is over the survey map"));
  EXPECT_THAT(RefusalToSave(4, 6), HasSubstr("expected 8x6 pixels, found 4x6"));
  document_.erase("diffuse_mask");
  document_["camera"]["height"] = 4;
  EXPECT_THAT(RefusalToSave(8, 4), HasSubstr("twice as wide as high"));
}

// As a sequence is with the materials' albedos: without the map and its mask.
TEST_F(DiffuseMaskTest, KeepsTheSurveysMaskWhereTheCallerHasLeftOutTheMap) {
  document_["diffuse_mask"] = "diffuse_mask.png";
  Gray8Image over_map(64, 32, 255);
  WritePng(folder_ / "diffuse_mask.png", over_map);
  WriteMask(64, 32, 3);
  Sequence sequence = Read();
  sequence.environment.reset();
  sequence.diffuse_mask.reset();
  const std::string before = ContentOf(folder_ / "diffuse_mask.png");
  EXPECT_THAT(MessageOf([&] { ReplaceDiffuseMask(sequence, Gray8Image(8, 6, 255)); }),
              HasSubstr("diffuse_mask is over the survey map"));
  EXPECT_EQ(ContentOf(folder_ / "diffuse_mask.png"), before);
}

}  // namespace
}  // namespace pleinair::diffuse_mask_test
