// Frame files that are missing, cut, empty, of another size, no files at all, or links that lead
// out of the folder: each is its own frame's failure.
#include <functional>
#include <limits>

#include "datasets/frame_source.h"
#include "scene/image_io.h"
#include "tests/datasets/exif_picture.h"
#include "tests/datasets/made_pictures.h"
#include "tests/datasets/sequence_fixture.h"

namespace pleinair::frame_source_hard_cases_test {
namespace {

namespace fs = std::filesystem;

class FrameSourceHardCases : public SequenceFolder {
 protected:
  void SetUp() override {
    SequenceFolder::SetUp();
    document_ = Everything();
    nlohmann::json frame = document_["frames"][1];
    frame.erase("image_ldr");
    document_["frames"] = nlohmann::json::array();
    for (int i = 0; i < 3; ++i) {
      frame["image"] = Name(i, ".exr");
      frame["image_ldr"] = Name(i, ".png");
      document_["frames"].push_back(frame);
      WriteExr(folder_ / Name(i, ".exr"), RgbImage(8, 6, glm::vec3(1.0f)), ExrPrecision::kHalf);
      WritePng(folder_ / Name(i, ".png"), Rgb8Image(8, 6, glm::u8vec3(99)));
    }
    WriteDocument(document_);
  }

  static std::string Name(int frame, const std::string& extension) {
    return "frames/" + std::to_string(frame) + extension;
  }

  // The middle frame fails, naming its file; its neighbours play.
  void ExpectOnlyTheMiddleOneFails(const std::string& expected_word) {
    for (const FrameKind kind : {FrameKind::kLinear, FrameKind::kLdr}) {
      const auto source = MakeRecordedFrameSource(ReadSequence(folder_), kind);
      for (int i = 0; i < 3; ++i) {
        const auto next = source->Next();
        ASSERT_TRUE(next);
        ASSERT_EQ(next->has_value(), i != 1) << (next->has_value() ? "" : next->error().reason);
        if (i != 1) continue;
        const FrameError& error = next->error();
        EXPECT_EQ(error.index, 1);
        const std::string file = Name(1, kind == FrameKind::kLinear ? ".exr" : ".png");
        EXPECT_NE(error.reason.find(file), std::string::npos) << error.reason;
        EXPECT_NE(error.reason.find(expected_word), std::string::npos) << error.reason;
        EXPECT_EQ(error.reason.find('\n'), std::string::npos) << error.reason;
      }
      EXPECT_FALSE(source->Next());
    }
  }

  void ReplaceMiddle(const std::function<void(const fs::path&)>& replace) {
    for (const char* extension : {".exr", ".png"}) {
      const fs::path file = folder_ / Name(1, extension);
      fs::remove_all(file);
      replace(file);
    }
  }

  nlohmann::json document_;
};

TEST_F(FrameSourceHardCases, AMissingFrameFailsAlone) {
  ReplaceMiddle([](const fs::path&) {});
  ExpectOnlyTheMiddleOneFails("found nothing");
}

TEST_F(FrameSourceHardCases, AnEmptyFrameFailsAlone) {
  ReplaceMiddle([](const fs::path& file) { Write(file, ""); });
  ExpectOnlyTheMiddleOneFails("");
}

// Viewers turn it; its pixels are another view than the pose's, whose columns are level.
TEST_F(FrameSourceHardCases, APhotographOfACameraHeldOtherwiseFailsAlone) {
  for (int i = 0; i < 3; ++i) {
    ExifTags tags;
    tags.orientation = i == 1 ? 3u : 1u;
    Write(folder_ / Name(i, ".jpg"),
          WithExif(made_pictures::Jpeg(made_pictures::Noise(8, 6, 1)), tags));
    document_["frames"][static_cast<std::size_t>(i)]["image_ldr"] = Name(i, ".jpg");
  }
  WriteDocument(document_);
  const auto source = MakeRecordedFrameSource(ReadSequence(folder_), FrameKind::kLdr);
  for (int i = 0; i < 3; ++i) {
    const auto next = source->Next();
    ASSERT_TRUE(next);
    ASSERT_EQ(next->has_value(), i != 1);
    if (i == 1) {
      EXPECT_NE(next->error().reason.find("1.jpg: expected a camera held as the pose says, found "
                                          "EXIF orientation 3"),
                std::string::npos)
          << next->error().reason;
    }
  }
}

TEST_F(FrameSourceHardCases, AFrameThatIsNoImageFailsAlone) {
  ReplaceMiddle([](const fs::path& file) { Write(file, "not an image at all, but some text"); });
  ExpectOnlyTheMiddleOneFails("");
}

TEST_F(FrameSourceHardCases, AFrameUnderTheOthersKeyNamesTheRightOne) {
  ReplaceMiddle([&](const fs::path& file) {
    fs::copy_file(folder_ / Name(0, file.extension() == ".exr" ? ".png" : ".exr"), file);
  });
  ExpectOnlyTheMiddleOneFails("under `image_ldr`");
}

TEST_F(FrameSourceHardCases, ATruncatedFrameFailsAlone) {
  for (const double share : {0.1, 0.5, 0.9}) {
    ReplaceMiddle([&](const fs::path& file) {
      const fs::path whole = folder_ / Name(0, file.extension().string());
      fs::copy_file(whole, file);
      fs::resize_file(
          file, static_cast<std::uintmax_t>(share * static_cast<double>(fs::file_size(whole))));
    });
    ExpectOnlyTheMiddleOneFails("");
  }
}

TEST_F(FrameSourceHardCases, AFrameOfAnotherSizeFailsAlone) {
  ReplaceMiddle([](const fs::path& file) {
    if (file.extension() == ".exr") WriteExr(file, RgbImage(6, 8), ExrPrecision::kHalf);
    if (file.extension() == ".png") WritePng(file, Rgb8Image(6, 8));
  });
  ExpectOnlyTheMiddleOneFails("expected 8x6 pixels, found 6x8");
}

TEST_F(FrameSourceHardCases, ADirectoryFailsAlone) {
  ReplaceMiddle([](const fs::path& file) { fs::create_directory(file); });
  ExpectOnlyTheMiddleOneFails("no file");
}

TEST_F(FrameSourceHardCases, ALinkLaidAfterTheSequenceWasReadIsNotFollowedOut) {
  fs::copy_file(folder_ / "frames/0.exr", root_ / "outside.exr");
  const Sequence sequence = ReadSequence(folder_);
  fs::remove(folder_ / "frames/1.exr");
  fs::create_symlink(root_ / "outside.exr", folder_ / "frames/1.exr");
  const auto source = MakeRecordedFrameSource(sequence, FrameKind::kLinear);
  EXPECT_TRUE(source->Next()->has_value());
  const auto second = source->Next();
  ASSERT_FALSE(second->has_value());
  EXPECT_NE(second->error().reason.find("inside the sequence's folder"), std::string::npos);
  EXPECT_TRUE(source->Next()->has_value());
}

TEST_F(FrameSourceHardCases, ALinearFrameWithoutAFinitePixelFailsAlone) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  RgbImage picture(8, 6);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    picture.pixels[i] = i % 2 == 0 ? glm::vec3(1.0f, nan, 1.0f) : glm::vec3(infinity);
  }
  WriteExr(folder_ / Name(1, ".exr"), picture, ExrPrecision::kHalf);
  auto source = MakeRecordedFrameSource(ReadSequence(folder_), FrameKind::kLinear);
  EXPECT_TRUE(source->Next()->has_value());
  const auto second = source->Next();
  ASSERT_FALSE(second->has_value());
  EXPECT_NE(second->error().reason.find("frames/1.exr: expected finite radiances, found none"),
            std::string::npos)
      << second->error().reason;
  EXPECT_TRUE(source->Next()->has_value());

  // One good pixel is a picture; the others are counted and not measured from.
  picture.pixels[7] = glm::vec3(1.0f);
  WriteExr(folder_ / Name(1, ".exr"), picture, ExrPrecision::kHalf);
  source = MakeRecordedFrameSource(ReadSequence(folder_), FrameKind::kLinear);
  EXPECT_EQ(source->Next()->value().defects.Count(), 0);
  const Frame frame = source->Next()->value();
  EXPECT_EQ(frame.defects.not_finite, 47);
  for (std::size_t i = 0; i < frame.unusable.pixels.size(); ++i) {
    EXPECT_EQ(frame.unusable.pixels[i], i == 7 ? 0 : kUnusable) << i;
  }
}

}  // namespace
}  // namespace pleinair::frame_source_hard_cases_test
