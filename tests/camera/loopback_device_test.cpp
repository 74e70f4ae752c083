// `--stream v4l2:` with the kernel's drivers, read back as other programs read it. Only
// scripts/test-cameras has the devices:
//
// PLEINAIR_TEST_LOOPBACK        a v4l2loopback device; without it all tests are skipped
// PLEINAIR_TEST_RUN             shell command of a run that streams to it
// PLEINAIR_TEST_COMPOSITES      folder of that run's composites
// PLEINAIR_TEST_CAMERA          a device that takes no pictures

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/picture_stream.h"
#include "datasets/camera/camera.h"
#include "datasets/camera/camera_capture.h"
#include "scene/image_io.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::loopback_device_test {
namespace {

using std::chrono::milliseconds;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

constexpr int kWidth = 320;
constexpr int kHeight = 180;

std::string Given(const char* variable) {
  const char* value = std::getenv(variable);
  return value == nullptr ? "" : value;
}

// Any colours; two neighbours, which share U and V, are equal where `is_smooth`.
Rgb8Image Picture(unsigned seed, bool is_smooth, int width = kWidth, int height = kHeight) {
  std::mt19937 random(seed);
  Rgb8Image picture(width, height);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    if (is_smooth && i % 2 == 1) {
      picture.pixels[i] = picture.pixels[i - 1];
      continue;
    }
    for (int c = 0; c < 3; ++c) {
      picture.pixels[i][c] = static_cast<std::uint8_t>(random() % 256);
    }
  }
  return picture;
}

// What YUYV of `picture` is without rounding: BT.601, limited range, U and V the means of two
// pixels.
std::vector<double> ExactYuyv(const Rgb8Image& picture) {
  std::vector<double> values;
  values.reserve(2 * picture.pixels.size());
  const auto luma = [](const glm::dvec3& rgb) {
    return (0.299 * rgb.r + 0.587 * rgb.g + 0.114 * rgb.b) / 255.0;
  };
  for (std::size_t i = 0; i < picture.pixels.size(); i += 2) {
    const glm::dvec3 a(picture.pixels[i]);
    const glm::dvec3 b(picture.pixels[i + 1]);
    const glm::dvec3 mean = 0.5 * (a + b);
    values.push_back(16.0 + 219.0 * luma(a));
    values.push_back(128.0 + 112.0 * (mean.b / 255.0 - luma(mean)) / (1.0 - 0.114));
    values.push_back(16.0 + 219.0 * luma(b));
    values.push_back(128.0 + 112.0 * (mean.r / 255.0 - luma(mean)) / (1.0 - 0.299));
  }
  return values;
}

// Half a code at most, and the sums' own errors.
bool IsRoundedFrom(const std::vector<std::byte>& bytes, const std::vector<double>& exact) {
  return bytes.size() == exact.size() &&
         std::equal(bytes.begin(), bytes.end(), exact.begin(), [](std::byte code, double value) {
           return std::abs(std::to_integer<int>(code) - value) <= 0.5 + 1e-9;
         });
}

class LoopbackDevice : public testing::Test {
 protected:
  void SetUp() override {
    if (device_.empty()) GTEST_SKIP() << "PLEINAIR_TEST_LOOPBACK names no device";
  }

  std::unique_ptr<CameraStream> OpenReader() const {
    CameraRequest request;
    request.automatic = true;  // No pictures are spent to settle.
    return OpenCamera(device_, request);
  }

  // The next picture; none where none comes within `patience`.
  static std::optional<CapturedBuffer> NextOf(CameraStream& reader,
                                              std::chrono::seconds patience = kPatience) {
    auto buffer = reader.Next(patience);
    if (!buffer) return std::nullopt;
    return std::move(*buffer);
  }

  static constexpr std::chrono::seconds kPatience{30};  // An emulated machine is slow.
  const std::string device_ = Given("PLEINAIR_TEST_LOOPBACK");
};

TEST_F(LoopbackDevice, GivesEachPictureAsItWasWrittenUpToTheRoundingOfYuyv) {
  PictureStream stream("v4l2:" + device_, 12.5);
  stream.Write(Picture(0, false));
  const auto reader = OpenReader();
  EXPECT_EQ(reader->Layout().format, *PixelFormatNamed("YUYV"));
  EXPECT_EQ(reader->Layout().width_px, kWidth);
  EXPECT_EQ(reader->Layout().height_px, kHeight);
  for (unsigned seed = 0; seed < 20; ++seed) {
    if (seed > 0) stream.Write(Picture(seed, false));
    const auto read = NextOf(*reader);
    ASSERT_TRUE(read) << "picture " << seed;
    EXPECT_TRUE(IsRoundedFrom(read->bytes, ExactYuyv(Picture(seed, false)))) << "picture " << seed;
    // The driver forgets the count of what was written before the reader came.
    EXPECT_EQ(read->sequence, seed > 0 ? std::optional(seed) : std::nullopt);
  }
}

// Matrix and range that the device states are those of the pictures. Y is wrong by half a code of
// 219, U and V by half of 224; then the colours are rounded. B depends on U most: 1.772.
TEST_F(LoopbackDevice, StatesTheColoursThatWereWritten) {
  const Rgb8Image picture = Picture(7, true);
  PictureStream stream("v4l2:" + device_);
  stream.Write(picture);
  const auto reader = OpenReader();
  const auto read = NextOf(*reader);
  ASSERT_TRUE(read);
  const auto decoded = DecodeCodes(read->bytes, read->layout);
  ASSERT_TRUE(decoded) << decoded.error();
  double worst = 0.0;
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    const glm::dvec3 error = glm::dvec3(decoded->pixels[i]) - glm::dvec3(picture.pixels[i]);
    worst = std::max({worst, std::abs(error.r), std::abs(error.g), std::abs(error.b)});
  }
  EXPECT_LE(worst, 0.5 * 255.0 / 219.0 + 0.5 * 1.772 * 255.0 / 224.0 + 0.5 + 1e-9);
}

// With and without exclusive_caps=1: neither listed nor opened, whatever was written before.
TEST_F(LoopbackDevice, IsACameraWhileSomebodyWritesToIt) {
  const auto modes = [&] {
    for (const CameraDescription& camera : ListCameras().cameras) {
      if (camera.device == device_) return camera.modes;
    }
    return std::vector<CameraMode>();
  };
  for (const double rate : {12.5, 30.0}) {
    EXPECT_THAT(modes(), IsEmpty());
    EXPECT_THAT(MessageOf([&] { OpenReader(); }),
                testing::StrEq(device_ + ": expected a camera that streams, found a loopback "
                                         "device that no program writes to"));
    PictureStream stream("v4l2:" + device_, rate);
    EXPECT_THAT(modes(), IsEmpty());
    stream.Write(Picture(0, false));
    ASSERT_THAT(modes(), testing::SizeIs(1));
    EXPECT_EQ(modes().front().width_px, kWidth);
    EXPECT_THAT(modes().front().frames_per_second, testing::ElementsAre(rate));
  }
}

// Nobody reads: the run must not wait.
TEST_F(LoopbackDevice, TakesPicturesWithoutAReader) {
  PictureStream stream("v4l2:" + device_);
  for (unsigned i = 0; i < 100; ++i) stream.Write(Picture(i % 3, false));
  const auto reader = OpenReader();
  const auto read = NextOf(*reader);
  ASSERT_TRUE(read);
  EXPECT_TRUE(IsRoundedFrom(read->bytes, ExactYuyv(Picture(99 % 3, false))));
}

// Of pictures from before the capture's begin none is its loss.
TEST_F(LoopbackDevice, AReaderThatComesLateHasLostNothing) {
  PictureStream stream("v4l2:" + device_);
  for (unsigned i = 0; i < 50; ++i) stream.Write(Picture(i % 3, false));
  EventLog events;
  CameraRequest request;
  request.automatic = true;
  CameraCapture capture(device_, request, {}, events);
  for (unsigned i = 0; i < 10; ++i) {
    ASSERT_TRUE(capture.Next());
    stream.Write(Picture(i % 3, false));
  }
  EXPECT_EQ(events.CountOf(EventKind::kFrameLost), 0);
}

TEST_F(LoopbackDevice, CanBeWrittenToAgainInAnotherSizeWhenNobodyReadsIt) {
  for (const int height : {kHeight, kHeight / 2, kHeight}) {
    PictureStream stream("v4l2:" + device_);
    stream.Write(Picture(0, false, kWidth, height));
    EXPECT_EQ(OpenReader()->Layout().height_px, height);
  }
}

// With exclusive_caps=1, version 0.12 of the driver is then neither camera nor output.
TEST_F(LoopbackDevice, TakesPicturesAfterAProgramThatOnlyWroteToIt) {
  const int other = open(device_.c_str(), O_RDWR);
  ASSERT_GE(other, 0);
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  format.fmt.pix.width = 64;
  format.fmt.pix.height = 48;
  format.fmt.pix.pixelformat = V4L2_PIX_FMT_YUYV;
  ASSERT_EQ(ioctl(other, VIDIOC_S_FMT, &format), 0);
  const std::vector<std::byte> grey(std::size_t{2} * 64 * 48, std::byte{128});
  ASSERT_EQ(write(other, grey.data(), grey.size()), static_cast<ssize_t>(grey.size()));
  close(other);
  PictureStream stream("v4l2:" + device_);
  stream.Write(Picture(0, false));
  const auto read = NextOf(*OpenReader());
  ASSERT_TRUE(read);
  EXPECT_TRUE(IsRoundedFrom(read->bytes, ExactYuyv(Picture(0, false))));
}

// A reader keeps the format of the writer before.
TEST_F(LoopbackDevice, RefusesAnotherSizeWhileAProgramReads) {
  std::optional<PictureStream> earlier("v4l2:" + device_);
  earlier->Write(Picture(0, false));
  const auto reader = OpenReader();
  earlier.reset();
  PictureStream stream("v4l2:" + device_);
  EXPECT_THAT(MessageOf([&] { stream.Write(Picture(0, false, 64, 48)); }),
              HasSubstr(device_ + ": expected a device that takes YUYV of 64x48, found YUYV of "
                                  "320x180 in rows of 640 bytes"));
  EXPECT_THAT(MessageOf([&] { stream.Write(Picture(0, false)); }), IsEmpty());
}

TEST_F(LoopbackDevice, RefusesAnOddWidth) {
  PictureStream stream("v4l2:" + device_);
  EXPECT_THAT(MessageOf([&] { stream.Write(Picture(0, false, 63, 48)); }),
              HasSubstr(device_ + ": expected an even width for YUYV, found 63"));
}

TEST_F(LoopbackDevice, RefusesACamera) {
  const std::string camera = Given("PLEINAIR_TEST_CAMERA");
  EXPECT_THAT(MessageOf([&] { const PictureStream stream("v4l2:" + camera); }),
              AllOf(StartsWith("v4l2:" + camera + ": expected a loopback device, found "),
                    HasSubstr("vivid")));
}

// A run takes much longer for a composite than the reader for a picture. Should a busy machine hold
// the reader up, the device keeps the two latest pictures: those may be missing that are older.
TEST_F(LoopbackDevice, ARunsCompositesAreRead) {
  std::optional<PictureStream> first("v4l2:" + device_);
  first->Write(Rgb8Image(480, 360));  // Until there is a picture, no reader can open the device.
  const auto reader = OpenReader();
  ASSERT_TRUE(NextOf(*reader));
  first.reset();

  int status = -1;
  std::atomic<bool> is_over = false;
  std::jthread run([&] {
    status = std::system(Given("PLEINAIR_TEST_RUN").c_str());
    is_over = true;
  });
  std::vector<std::vector<std::byte>> pictures;
  for (;;) {
    const bool is_last_look = is_over;
    if (auto read = NextOf(*reader, std::chrono::seconds(1))) {
      pictures.push_back(std::move(read->bytes));
    } else if (is_last_look) {
      break;
    }
  }
  run.join();
  EXPECT_EQ(status, 0);

  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(Given("PLEINAIR_TEST_COMPOSITES"))) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  ASSERT_THAT(files, Not(IsEmpty()));
  auto next = files.begin();
  for (const auto& picture : pictures) {
    next = std::find_if(next, files.end(), [&](const std::filesystem::path& file) {
      return IsRoundedFrom(picture, ExactYuyv(ReadDisplayImage(file)));
    });
    ASSERT_NE(next, files.end()) << "a picture that is no later composite";
    ++next;
  }
  EXPECT_EQ(next, files.end()) << "the last composite is missing";
  EXPECT_GE(pictures.size(), 2U);
  std::printf("%zu of %zu composites were read\n", pictures.size(), files.size());
}

}  // namespace
}  // namespace pleinair::loopback_device_test
