// Composites to other programs, read back as they would read them.
#include "apps/picture_stream.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <exception>
#include <random>
#include <stop_token>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scene/temporary_folder.h"

namespace pleinair::picture_stream_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr int kWidth = 16;
constexpr int kHeight = 9;

// Any colours, and the corners of their cube.
Rgb8Image Picture(unsigned seed) {
  std::mt19937 random(seed);
  Rgb8Image picture(kWidth, kHeight);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    for (unsigned c = 0; c < 3; ++c) {
      picture.pixels[i][static_cast<int>(c)] =
          static_cast<std::uint8_t>(i < 8 ? 255 * (i >> c & 1) : random() % 256);
    }
  }
  return picture;
}

// YUV4MPEG2's header is words with a letter each; planes are Y, Cb and Cr, BT.601, full range. A
// rounding of each moves R and B by up to 0.5 + 0.5 * 1.772 codes, and they are rounded again.
TEST(PictureStream, Y4mIsReadBackAsThePicturesWritten) {
  const TemporaryFolder folder;
  const std::string file = (folder / "live.y4m").string();
  {
    PictureStream stream("y4m:" + file, 29.97);
    for (unsigned i = 0; i < 3; ++i) stream.Write(Picture(i));
  }
  const std::string bytes = ContentOf(file);
  const std::string header = "YUV4MPEG2 W16 H9 F29970:1000 Ip A1:1 C444 XCOLORRANGE=FULL\n";
  ASSERT_EQ(bytes.substr(0, header.size()), header);
  constexpr std::size_t kPixels = kWidth * kHeight;
  constexpr std::size_t kFrame = 6 + 3 * kPixels;
  ASSERT_EQ(bytes.size(), header.size() + 3 * kFrame);
  for (unsigned frame = 0; frame < 3; ++frame) {
    const std::size_t at = header.size() + frame * kFrame;
    EXPECT_EQ(bytes.substr(at, 6), "FRAME\n");
    const auto plane = [&](std::size_t k, std::size_t i) {
      return static_cast<double>(static_cast<unsigned char>(bytes[at + 6 + k * kPixels + i]));
    };
    const Rgb8Image picture = Picture(frame);
    double worst_luma = 0.0;
    double worst = 0.0;
    for (std::size_t i = 0; i < kPixels; ++i) {
      const glm::dvec3 rgb(picture.pixels[i]);
      const double y = plane(0, i);
      const double cb = plane(1, i) - 128.0;
      const double cr = plane(2, i) - 128.0;
      worst_luma =
          std::max(worst_luma, std::abs(y - (0.299 * rgb.r + 0.587 * rgb.g + 0.114 * rgb.b)));
      const glm::dvec3 back(
          y + 1.402 * cr, y - (0.114 * 1.772 * cb + 0.299 * 1.402 * cr) / 0.587, y + 1.772 * cb);
      for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(back[c] - rgb[c]));
    }
    EXPECT_LE(worst_luma, 0.5 + 1e-9);
    // Cb and Cr of saturated colours reach 255.5, and are 255: half a code more.
    EXPECT_LE(worst, 0.5 + 0.5 * 1.772 + 1e-9);
  }
}

TEST(PictureStream, AReaderThatIsGoneIsAnErrorAndNoSignal) {
  const TemporaryFolder folder;
  const std::string pipe = (folder / "pipe").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  PictureStream stream("y4m:" + pipe);
  stream.Write(Picture(0));
  close(reader);
  EXPECT_THAT(MessageOf([&] { stream.Write(Picture(1)); }),
              AllOf(HasSubstr("y4m:" + pipe), HasSubstr("its reader is gone")));
}

TEST(PictureStream, APictureOfAnotherSizeIsAnError) {
  const TemporaryFolder folder;
  const std::string file = (folder / "live.y4m").string();
  PictureStream stream("y4m:" + file);
  stream.Write(Picture(0));
  const auto size = std::filesystem::file_size(file);
  EXPECT_THAT(MessageOf([&] { stream.Write(Rgb8Image(8, 9)); }),
              HasSubstr("expected a picture of 16x9 as the first, found 8x9"));
  EXPECT_EQ(std::filesystem::file_size(file), size);
}

TEST(PictureStream, RefusesOtherNamesAndPlaces) {
  for (const char* target : {"", "live.y4m", "y4m", "Y4M:-", "rtsp://camera", "unix:socket"}) {
    EXPECT_THAT(MessageOf([&] { const PictureStream stream(target); }),
                AllOf(HasSubstr("--stream '" + std::string(target) + "'"),
                      HasSubstr("expected y4m:-, y4m:PATH or v4l2:/dev/videoN")));
  }
  EXPECT_THAT(MessageOf([] { const PictureStream stream("y4m:/no/such/folder/live.y4m"); }),
              HasSubstr("/no/such/folder/live.y4m: expected a file or pipe"));
  EXPECT_THAT(MessageOf([] { const PictureStream stream("v4l2:/no/such/device"); }),
              HasSubstr("v4l2:/no/such/device: expected a loopback device"));
}

// A file is no device: it is not written to.
TEST(PictureStream, AFileIsNoLoopbackDevice) {
  const TemporaryFolder folder;
  const std::string file = folder.Write("file", "mine").string();
  EXPECT_THAT(MessageOf([&] { const PictureStream stream("v4l2:" + file); }),
              HasSubstr("v4l2:" + file + ": expected a loopback device, found no V4L2 device"));
  EXPECT_EQ(ContentOf(file), "mine");
}

TEST(PictureStream, AFullDiscIsAnError) {
  PictureStream stream("y4m:/dev/full");
  EXPECT_THAT(MessageOf([&] { stream.Write(Picture(0)); }), HasSubstr("No space left"));
}

// A pipe holds 64 kB; nobody reads it.
TEST(PictureStream, LeavesAReaderThatDoesNotReadASecondAfterTheEnd) {
  const TemporaryFolder folder;
  const std::string pipe = (folder / "pipe").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  std::stop_source end;
  PictureStream stream("y4m:" + pipe, 30.0, end.get_token());
  std::string failure;
  std::thread writing([&] {
    try {
      stream.Write(Rgb8Image(320, 240));
    } catch (const std::exception& error) {
      failure = error.what();
    }
  });
  // What is read in time is all of it, also after the end.
  std::string read(100'000, ' ');
  std::size_t begun = 0;
  while (begun < read.size()) {
    const ssize_t bytes = ::read(reader, read.data() + begun, read.size() - begun);
    if (bytes > 0) begun += static_cast<std::size_t>(bytes);
    if (begun > 50'000) end.request_stop();
  }
  const auto stopped = std::chrono::steady_clock::now();
  writing.join();
  EXPECT_GE(std::chrono::steady_clock::now() - stopped, std::chrono::milliseconds(900));
  EXPECT_THAT(failure, HasSubstr(pipe + ": its reader does not read"));
  close(reader);
}

}  // namespace
}  // namespace pleinair::picture_stream_test
