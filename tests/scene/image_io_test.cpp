#include "scene/image_io.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <half.h>
#include <opencv2/imgcodecs.hpp>

#include "tests/scene/temporary_folder.h"

namespace pleinair::image_io_test {
namespace {

using testing::HasSubstr;

RgbImage Ramp(int width, int height) {
  RgbImage image(width, height);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const float value = static_cast<float>(i);
    image.pixels[i] = {0.1f + value, 1.0f / (1.0f + value), 1e-3f * value * value};
  }
  return image;
}

// Writes R, G, B (and others, in the order given) of one pixel type, with any header.
void WriteWithOpenExr(const std::filesystem::path& file,
                      Imf::Header header,
                      const std::string& channels,
                      Imf::PixelType type) {
  const Imath::Box2i data = header.dataWindow();
  const std::size_t width = static_cast<std::size_t>(data.max.x - data.min.x) + 1;
  const std::size_t height = static_cast<std::size_t>(data.max.y - data.min.y) + 1;
  const std::size_t size = type == Imf::HALF ? 2 : 4;
  std::vector<std::vector<char>> planes;
  Imf::FrameBuffer frame;
  for (const char channel : channels) {
    header.channels().insert(std::string(1, channel), Imf::Channel(type));
    planes.emplace_back(width * height * size);
    for (std::size_t i = 0; i < width * height; ++i) {
      const float value = static_cast<float>(i % 97) + static_cast<float>(channel - 'A');
      char* const target = planes.back().data() + i * size;
      if (type == Imf::HALF) *reinterpret_cast<half*>(target) = half(value);
      if (type == Imf::FLOAT) *reinterpret_cast<float*>(target) = value;
      if (type == Imf::UINT) *reinterpret_cast<unsigned*>(target) = static_cast<unsigned>(value);
    }
    frame.insert(std::string(1, channel),
                 Imf::Slice::Make(type, planes.back().data(), data, size, size * width));
  }
  Imf::OutputFile output(file.c_str(), header);
  output.setFrameBuffer(frame);
  output.writePixels(static_cast<int>(height));
}

TEST(ImageIo, FloatExrComesBackBitForBit) {
  const TemporaryFolder folder;
  const RgbImage image = Ramp(33, 17);
  WriteExr(folder / "a.exr", image, ExrPrecision::kFloat);
  const RgbImage again = ReadRadianceImage(folder / "a.exr");
  EXPECT_EQ(again.width, 33);
  EXPECT_EQ(again.height, 17);
  EXPECT_EQ(again.pixels, image.pixels);
}

// All 65536 half floats, NaN and infinities included: a composite must return what the camera gave.
TEST(ImageIo, EveryHalfFloatComesBackBitForBit) {
  const TemporaryFolder folder;
  RgbImage image(256, 256);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    half value;
    value.setBits(static_cast<unsigned short>(i));
    image.pixels[i] = glm::vec3(static_cast<float>(value));
  }
  WriteExr(folder / "a.exr", image, ExrPrecision::kHalf);
  const RgbImage once = ReadRadianceImage(folder / "a.exr");
  WriteExr(folder / "b.exr", once, ExrPrecision::kHalf);
  const RgbImage twice = ReadRadianceImage(folder / "b.exr");
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const auto bits = [&](const RgbImage& from) {
      return std::bit_cast<std::uint32_t>(from.pixels[i].y);
    };
    ASSERT_EQ(bits(once), bits(image)) << i;
    ASSERT_EQ(bits(twice), bits(image)) << i;
  }
}

TEST(ImageIo, ReadsEveryPixelTypeAndCompression) {
  const TemporaryFolder folder;
  for (const Imf::PixelType type : {Imf::HALF, Imf::FLOAT, Imf::UINT}) {
    for (int compression = 0; compression < Imf::NUM_COMPRESSION_METHODS; ++compression) {
      Imf::Header header(40, 30);
      header.compression() = static_cast<Imf::Compression>(compression);
      WriteWithOpenExr(folder / "a.exr", header, "ABGR", type);
      const RgbImage image = ReadRadianceImage(folder / "a.exr");
      ASSERT_EQ(image.width, 40);
      ASSERT_EQ(image.height, 30);
      // The lossy ones (PXR24, B44, DWA) keep 1 % of the ramp's 113.
      EXPECT_NEAR(image.At(7, 2).r, 87 + ('R' - 'A'), 1.2) << type << " " << compression;
      EXPECT_NEAR(image.At(7, 2).g, 87 + ('G' - 'A'), 1.2) << type << " " << compression;
      EXPECT_NEAR(image.At(7, 2).b, 87 + ('B' - 'A'), 1.2) << type << " " << compression;
    }
  }
}

TEST(ImageIo, ReadsTheDisplayWindowOfALargerDataWindow) {
  const TemporaryFolder folder;
  const Imath::Box2i display({10, 20}, {13, 22});
  const Imath::Box2i data({8, 19}, {15, 24});
  WriteWithOpenExr(folder / "a.exr", Imf::Header(display, data), "BGR", Imf::FLOAT);
  const RgbImage image = ReadRadianceImage(folder / "a.exr");
  ASSERT_EQ(image.width, 4);
  ASSERT_EQ(image.height, 3);
  // Data rows are 8 wide; the display window begins 2 to the right and 1 below.
  EXPECT_EQ(image.At(0, 0).r, 8 * 1 + 2 + ('R' - 'A'));
  EXPECT_EQ(image.At(3, 2).r, 8 * 3 + 5 + ('R' - 'A'));
}

TEST(ImageIo, RefusesADataWindowThatLeavesGaps) {
  const TemporaryFolder folder;
  const Imath::Box2i display({0, 0}, {9, 9});
  const Imath::Box2i data({0, 0}, {9, 4});
  WriteWithOpenExr(folder / "a.exr", Imf::Header(display, data), "BGR", Imf::FLOAT);
  EXPECT_THAT(MessageOf([&] { ReadRadianceImage(folder / "a.exr"); }),
              HasSubstr("does not cover the display window"));
}

// The largest channel has a mantissa of 128 to 255: half a step is at most 1/256 of it.
TEST(ImageIo, HdrKeepsEachPixelToHalfAStep) {
  const TemporaryFolder folder;
  for (const int width : {1, 7, 8, 33, 40000}) {
    RgbImage image = Ramp(width, 5);
    image.pixels[2] = glm::vec3(255.9f, 0.0f, 1e-30f);  // Rounds up into the next exponent.
    image.pixels[3] = glm::vec3(1.6e7f, 2.0f, 0.0f);
    for (std::size_t i = image.pixels.size() / 2; i < image.pixels.size(); ++i) {
      if (i % 300 > 20) image.pixels[i] = glm::vec3(0.5f);  // Long runs.
    }
    WriteHdr(folder / "a.hdr", image);
    const RgbImage again = ReadRadianceImage(folder / "a.hdr");
    ASSERT_EQ(again.width, width);
    ASSERT_EQ(again.height, 5);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      const glm::vec3& p = image.pixels[i];
      const float largest = std::max({p.r, p.g, p.b});
      for (int channel = 0; channel < 3; ++channel) {
        ASSERT_NEAR(again.pixels[i][channel], p[channel], 1.0001f * largest / 256.0f)
            << width << " " << i;
      }
    }
  }
}

TEST(ImageIo, ReadsOldRunsFlippedRowsAndExposure) {
  const TemporaryFolder folder;
  // Exponent 136 makes a mantissa of 1 one unit; (1, 1, 1, 3) repeats the pixel before three times.
  const std::string head = "#?RGBE\n# a comment\nFORMAT=32-bit_rle_rgbe\nEXPOSURE= 2\n\n";
  const std::string rows = std::string("\x0a\x14\x1e\x88\x01\x01\x01\x03", 8) +
                           std::string("\x02\x04\x06\x88\x02\x04\x06\x88", 8) +
                           std::string("\x02\x04\x06\x88\x08\x04\x06\x88", 8);
  const RgbImage image = ReadRadianceImage(folder.Write("a.hdr", head + "+Y 2 +X 4\n" + rows));
  ASSERT_EQ(image.width, 4);
  ASSERT_EQ(image.height, 2);
  EXPECT_EQ(image.At(0, 1), glm::vec3(5.0f, 10.0f, 15.0f));
  EXPECT_EQ(image.At(3, 1), glm::vec3(5.0f, 10.0f, 15.0f));
  EXPECT_EQ(image.At(0, 0), glm::vec3(1.0f, 2.0f, 3.0f));
  EXPECT_EQ(image.At(3, 0), glm::vec3(4.0f, 2.0f, 3.0f));
}

TEST(ImageIo, PngComesBackBitForBit) {
  const TemporaryFolder folder;
  Rgb8Image image(37, 11);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    image.pixels[i] = glm::u8vec3(i * 3, i * 5 + 1, i * 7 + 2);
  }
  WritePng(folder / "a.png", image);
  EXPECT_EQ(ReadDisplayImage(folder / "a.png").pixels, image.pixels);

  Gray8Image mask(5, 4);
  for (std::size_t i = 0; i < mask.pixels.size(); ++i) {
    mask.pixels[i] = static_cast<std::uint8_t>(i * 12);
  }
  WritePng(folder / "m.png", mask);
  EXPECT_EQ(ReadMaskImage(folder / "m.png").pixels, mask.pixels);
  EXPECT_EQ(ReadDisplayImage(folder / "m.png").At(1, 1), glm::u8vec3(72));
  EXPECT_EQ(ReadMaskImage(folder / "a.png").At(1, 0), image.At(1, 0).r);
}

// As phones, browsers and scripts name them.
TEST(ImageIo, ReadsPicturesByTheirContentWhateverTheirName) {
  const TemporaryFolder folder;
  const auto renamed = [&](const char* from, const char* to) {
    std::filesystem::rename(folder / from, folder / to);
    return folder / to;
  };
  const RgbImage light = Ramp(9, 5);
  WriteExr(folder / "a.exr", light, ExrPrecision::kFloat);
  EXPECT_EQ(ReadRadianceImage(renamed("a.exr", "a.hdr")).pixels, light.pixels);
  WriteHdr(folder / "b.hdr", light);
  EXPECT_EQ(ReadRadianceImage(renamed("b.hdr", "b.EXR")).width, 9);
  Rgb8Image picture(16, 8, glm::u8vec3(10, 100, 200));
  WritePng(folder / "c.png", picture);
  EXPECT_EQ(ReadDisplayImage(renamed("c.png", "c.jpg")).pixels, picture.pixels);
  cv::imwrite((folder / "d.jpg").string(), cv::Mat(8, 16, CV_8UC3, cv::Scalar(200, 100, 10)));
  // A flat JPEG is right to a code value or two.
  EXPECT_NEAR(ReadDisplayImage(renamed("d.jpg", "d")).At(3, 3).b, 200, 2);
  EXPECT_TRUE(HoldsRadiance(folder / "a.hdr"));
  EXPECT_FALSE(HoldsRadiance(folder / "c.jpg"));
  EXPECT_EQ(DescribeContent(folder / "d"), "a JPEG picture");
}

TEST(ImageIo, WritersLeaveNothingButTheFile) {
  const TemporaryFolder folder;
  WriteExr(folder / "a.exr", Ramp(4, 4), ExrPrecision::kHalf);
  WriteExr(folder / "a.exr", Ramp(8, 8), ExrPrecision::kHalf);  // Replaces it.
  EXPECT_EQ(folder.FileCount(), 1u);
  EXPECT_EQ(ReadRadianceImage(folder / "a.exr").width, 8);
  EXPECT_THAT(MessageOf([&] { WriteHdr(folder / "no/such/a.hdr", Ramp(4, 4)); }),
              HasSubstr("no/such/a.hdr: cannot be written: No such file"));
  std::filesystem::create_directory(folder / "taken.png");
  EXPECT_THROW(WritePng(folder / "taken.png", Gray8Image(2, 2)), std::runtime_error);
  EXPECT_EQ(folder.FileCount(), 2u);
}

TEST(ImageIo, ReadsTheRecordedFrames) {
  const std::filesystem::path shared = std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences";
  const std::filesystem::path frame = shared / "courtyard-clouds/frames/000000.exr";
  if (!std::filesystem::exists(frame)) GTEST_SKIP() << "the recorded sequences are not here";
  const RgbImage linear = ReadRadianceImage(frame);
  EXPECT_EQ(linear.width, 480);
  EXPECT_EQ(linear.height, 360);
  const Rgb8Image photo = ReadDisplayImage(shared / "berlin-photos/frames_ldr/000000.jpg");
  EXPECT_EQ(photo.width, 1024);
  EXPECT_EQ(photo.height, 768);
}

}  // namespace
}  // namespace pleinair::image_io_test
