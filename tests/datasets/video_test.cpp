#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/video/internal/libav_functions.h"
#include "datasets/video/video_reader.h"
#include "datasets/video/video_writer.h"
#include "tests/datasets/made_pictures.h"
#include "tests/scene/file_size_limit.h"

namespace pleinair::video_test {
namespace {

namespace fs = std::filesystem;
using made_pictures::Noise;
using std::chrono::milliseconds;
using testing::HasSubstr;

class VideoFolder : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / (std::string("pleinair_video_") + test->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    file_ = folder_ / "video.mkv";
  }
  void TearDown() override { fs::remove_all(folder_); }

  void WriteFile(const std::string& content) const {
    std::ofstream(file_, std::ios::binary) << content;
  }
  std::string Content() const {
    std::ifstream file(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  // Five pictures of noise.
  void WriteFfv1(int width, int height, bool is_grey = false) const {
    VideoWriter writer(file_, {VideoCodec::kFfv1, width, height, is_grey, {}});
    for (unsigned i = 0; i < 5; ++i) writer.Add(Noise(width, height, i), i * milliseconds(40));
  }
  std::string Refusal() const {
    try {
      const VideoReader reader(file_);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "accepted";
  }

  fs::path folder_;
  fs::path file_;
};

TEST_F(VideoFolder, GivesFfv1BackBitForBit) {
  for (const auto& [width, height] : {std::pair(64, 48), std::pair(33, 17), std::pair(640, 480)}) {
    fs::remove(file_);
    WriteFfv1(width, height);
    VideoReader reader(file_);
    for (unsigned i = 0; i < 5; ++i) {
      const auto picture = reader.Next();
      ASSERT_TRUE(picture && *picture);
      EXPECT_EQ((*picture)->codes.width, width);
      EXPECT_EQ((*picture)->codes.pixels, Noise(width, height, i).pixels);
      EXPECT_EQ((*picture)->time, i * milliseconds(40));
    }
    EXPECT_FALSE(reader.Next());
    EXPECT_FALSE(reader.Next());
  }
}

TEST_F(VideoFolder, KeepsGreyAsOneChannel) {
  Rgb8Image grey = Noise(64, 48, 1);
  for (glm::u8vec3& pixel : grey.pixels) pixel = glm::u8vec3(pixel.x);
  std::uint64_t bytes_grey = 0;
  std::uint64_t bytes_rgb = 0;
  {
    VideoWriter writer(file_, {VideoCodec::kFfv1, 64, 48, true, {}});
    bytes_grey = writer.Add(grey, milliseconds(0));
  }
  EXPECT_EQ((*VideoReader(file_).Next())->codes.pixels, grey.pixels);
  fs::remove(file_);
  bytes_rgb = VideoWriter(file_, {VideoCodec::kFfv1, 64, 48, false, {}}).Add(grey, milliseconds(0));
  EXPECT_LT(bytes_grey, bytes_rgb);
}

TEST_F(VideoFolder, CanBeReadWhileItGrows) {
  VideoWriter writer(file_, {VideoCodec::kH264, 64, 48, false, {}});
  for (unsigned i = 0; i < 70; ++i) {
    const std::uint64_t bytes = writer.Add(Noise(64, 48, i), i * milliseconds(33));
    EXPECT_GT(bytes, 0u);
    VideoReader reader(file_);
    for (unsigned k = 0; k <= i; ++k) ASSERT_TRUE(reader.Skip()) << k << " of " << i;
    EXPECT_FALSE(reader.Skip());
  }
}

// Flat colours need neither detail nor colours at full resolution: what is left is the rounding of
// YUV, and the quantizer's.
TEST_F(VideoFolder, KeepsColoursInH264) {
  const glm::u8vec3 colours[] = {
      {200, 30, 30}, {30, 200, 30}, {30, 30, 200}, {128, 128, 128}, {250, 250, 250}, {5, 5, 5}};
  for (const int width : {64, 63}) {
    fs::remove(file_);
    {
      VideoWriter writer(file_, {VideoCodec::kH264, width, 48, false, {}});
      Rgb8Image picture(width, 48);
      milliseconds time{0};
      for (const glm::u8vec3& colour : colours) {
        std::ranges::fill(picture.pixels, colour);
        writer.Add(picture, time += milliseconds(40));
      }
    }
    VideoReader reader(file_);
    for (const glm::u8vec3& colour : colours) {
      const auto picture = reader.Next();
      ASSERT_TRUE(picture && *picture);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR((*picture)->codes.At(width / 2, 24)[c], colour[c], 4) << int{colour[c]};
      }
    }
  }
}

TEST_F(VideoFolder, KnowsWhenItWasMade) {
  const UtcTime start = std::chrono::sys_days{std::chrono::year{2026} / 6 / 21} +
                        std::chrono::hours(9) + milliseconds(250);
  VideoWriter(file_, {VideoCodec::kFfv1, 64, 48, false, start}).Add(Noise(64, 48, 0), {});
  EXPECT_EQ(VideoReader(file_).CreationTime(), start);
  fs::remove(file_);
  WriteFfv1(64, 48);  // 1970: no clock.
  EXPECT_FALSE(VideoReader(file_).CreationTime());
}

TEST_F(VideoFolder, KeepsTimesAscending) {
  {
    VideoWriter writer(file_, {VideoCodec::kFfv1, 64, 48, false, {}});
    for (const int ms : {0, 40, 40, 10, 80}) writer.Add(Noise(64, 48, 1), milliseconds(ms));
  }
  VideoReader reader(file_);
  for (const int ms : {0, 40, 41, 42, 80}) {
    EXPECT_EQ((*reader.Next())->time, milliseconds(ms));
  }
}

TEST_F(VideoFolder, FindsADamagedPictureAlone) {
  WriteFfv1(64, 48);
  std::string content = Content();
  // In the middle of the third picture of five, which all have the same size.
  for (std::size_t at = 0; at < 20; ++at) content[content.size() / 2 + at] ^= 0x55;
  WriteFile(content);
  VideoReader reader(file_);
  int damaged = 0;
  for (unsigned i = 0; i < 5; ++i) {
    const auto picture = reader.Next();
    ASSERT_TRUE(picture);
    if (!*picture) {
      EXPECT_THAT(picture->error(), HasSubstr("damaged picture"));
      ++damaged;
      continue;
    }
    EXPECT_EQ((*picture)->codes.pixels, Noise(64, 48, i).pixels);
  }
  EXPECT_EQ(damaged, 1);
  EXPECT_FALSE(reader.Next());
}

TEST_F(VideoFolder, EndsWhereAFileBreaksOff) {
  WriteFfv1(64, 48);
  const std::string content = Content();
  for (std::size_t size = 0; size < content.size(); size += 97) {
    WriteFile(content.substr(0, size));
    try {
      VideoReader reader(file_);
      unsigned pictures = 0;
      while (const auto picture = reader.Next()) {
        if (*picture) {
          EXPECT_EQ((*picture)->codes.pixels, Noise(64, 48, pictures).pixels);
        }
        ++pictures;
      }
      EXPECT_LE(pictures, 5u);
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("video.mkv: "));
    }
  }
}

TEST_F(VideoFolder, RefusesWhatIsNoVideo) {
  EXPECT_THAT(Refusal(), HasSubstr("no such file"));
  WriteFile("");
  EXPECT_THAT(Refusal(), HasSubstr("the file is empty"));
  WriteFile("a diary, not a video\n");
  EXPECT_THAT(Refusal(), HasSubstr("expected a video"));
  // A list of other files is not followed.
  WriteFile("ffconcat version 1.0\nfile /etc/hostname\n");
  EXPECT_THAT(Refusal(), HasSubstr("expected a video"));
  WriteFile("#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\n/etc/hostname\n#EXT-X-ENDLIST\n");
  EXPECT_THAT(Refusal(), HasSubstr("expected a video"));
  EXPECT_THROW(VideoWriter(file_, {VideoCodec::kFfv1, 64, 48, false, {}}), std::runtime_error);
  fs::remove(file_);
  VideoWriter writer(file_, {VideoCodec::kFfv1, 64, 48, false, {}});
  EXPECT_THROW(writer.Add(Noise(32, 24, 0), {}), std::invalid_argument);
}

TEST_F(VideoFolder, LeavesNothingWhereItsHeaderCannotBeWritten) {
  {
    const FileSizeLimit limit(10);
    EXPECT_THROW(VideoWriter(file_, {VideoCodec::kFfv1, 32, 24, false, {}}), std::runtime_error);
  }
  EXPECT_FALSE(fs::exists(file_));
}

TEST(Libav, SaysWhichLibraryOrFunctionIsAbsent) {
  const auto words = [](const char* library, const char* function) -> std::string {
    try {
      FindLibavFunction(library, function);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "found";
  };
  EXPECT_THAT(words("libavnowhere.so.1", "av_crc"),
              testing::StartsWith("libavnowhere.so.1: expected FFmpeg's library"));
  EXPECT_EQ(words("libc.so.6", "av_crc"),
            "libc.so.6: expected FFmpeg's function av_crc, found none");
}

}  // namespace
}  // namespace pleinair::video_test
