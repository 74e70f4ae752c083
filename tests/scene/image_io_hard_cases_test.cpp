#include "scene/image_io.h"

#include <sys/stat.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "scene/half_float.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::image_io_hard_cases_test {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kDenormal = 6e-8f;  // The smallest half float.
constexpr float kMaxHalf = 65504.0f;

RgbImage Noise(int width, int height) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> uniform(0.0f, 100.0f);
  RgbImage image(width, height);
  for (glm::vec3& pixel : image.pixels) {
    pixel = {uniform(random), uniform(random), uniform(random)};
  }
  return image;
}

std::string ReadingMessage(const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  if (extension == ".exr" || extension == ".hdr") {
    return MessageOf([&] { ReadRadianceImage(file); });
  }
  return MessageOf([&] { ReadDisplayImage(file); });
}

TEST(ImageIoHardCases, CountsAndRepairsEachDefect) {
  RgbImage image(4, 2, glm::vec3(1.0f));
  image.pixels[0] = {kNaN, 2.0f, -3.0f};      // Counts as not finite, once.
  image.pixels[1] = {kInfinity, 5.0f, 1.0f};  // A sun that overflowed.
  image.pixels[2] = {-kInfinity, kInfinity, 1.0f};
  image.pixels[3] = {-1e-30f, 1.0f, 1.0f};
  image.pixels[4] = {kMaxHalf, kDenormal, 0.0f};  // No defect.
  const ImageDefects defects = RepairRadiance(image);
  EXPECT_EQ(defects.not_finite, 3);
  EXPECT_EQ(defects.negative, 1);
  EXPECT_EQ(defects.Count(), 4);
  EXPECT_EQ(image.pixels[0], glm::vec3(0.0f, 2.0f, 0.0f));
  EXPECT_EQ(image.pixels[1], glm::vec3(kMaxHalf, 5.0f, 1.0f));
  EXPECT_EQ(image.pixels[2], glm::vec3(0.0f, 5.0f, 1.0f));
  EXPECT_EQ(image.pixels[3], glm::vec3(0.0f, 1.0f, 1.0f));
  EXPECT_EQ(image.pixels[4], glm::vec3(kMaxHalf, kDenormal, 0.0f));
  EXPECT_EQ(RepairRadiance(image).Count(), 0);
}

TEST(ImageIoHardCases, RepairsImagesWithNothingGoodInThem) {
  RgbImage image(2, 1);
  image.pixels = {glm::vec3(kInfinity), glm::vec3(kNaN)};
  EXPECT_EQ(RepairRadiance(image).not_finite, 2);
  EXPECT_EQ(image.pixels[0], glm::vec3(0.0f));
  RgbImage empty;
  EXPECT_EQ(RepairRadiance(empty).Count(), 0);
}

// What half floats hold is left alone, and then can be written.
TEST(ImageIoHardCases, ClampsToHalfAndCounts) {
  const TemporaryFolder folder;
  RgbImage image(6, 1, glm::vec3(1.0f));
  image.pixels[0] = {65504.0f, -65504.0f, 0.0f};
  image.pixels[1] = {65504.01f, 1e38f, 2.0f};
  image.pixels[2] = {-1e30f, 1.0f, 1.0f};
  image.pixels[3] = {kInfinity, -kInfinity, 3.0f};
  image.pixels[4] = {1.0f, 1.0f, kNaN};
  EXPECT_EQ(ClampToHalf(image), 2);
  EXPECT_EQ(image.pixels[0], glm::vec3(65504.0f, -65504.0f, 0.0f));
  EXPECT_EQ(image.pixels[1], glm::vec3(65504.0f, 65504.0f, 2.0f));
  EXPECT_EQ(image.pixels[2], glm::vec3(-65504.0f, 1.0f, 1.0f));
  EXPECT_EQ(image.pixels[3], glm::vec3(kInfinity, -kInfinity, 3.0f));
  EXPECT_TRUE(std::isnan(image.pixels[4].b));
  WriteExr(folder / "a.exr", image, ExrPrecision::kHalf);
  EXPECT_EQ(ReadRadianceImage(folder / "a.exr").pixels[1], image.pixels[1]);
}

TEST(ImageIoHardCases, HalfRefusesWhatItCannotHold) {
  const TemporaryFolder folder;
  RgbImage image(3, 2, glm::vec3(1.0f));
  image.At(2, 1).g = 65505.0f;
  EXPECT_THROW(WriteExr(folder / "a.exr", image, ExrPrecision::kHalf), std::invalid_argument);
  EXPECT_THAT(MessageOf([&] { WriteExr(folder / "a.exr", image, ExrPrecision::kHalf); }),
              HasSubstr("a.exr: pixel (2, 1): value 65505"));
  EXPECT_EQ(folder.FileCount(), 0u);
  WriteExr(folder / "a.exr", image, ExrPrecision::kFloat);
  EXPECT_EQ(ReadRadianceImage(folder / "a.exr").At(2, 1).g, 65505.0f);
}

// A pipe or a device is somebody's: /dev/null must not become a file.
TEST(ImageIoHardCases, WritersReplaceRegularFilesAlone) {
  const TemporaryFolder folder;
  const std::filesystem::path pipe = folder / "pipe.png";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(MessageOf([&] { WritePng(pipe, Gray8Image(2, 2)); }),
            pipe.string() +
                ": cannot be written: expected a regular file there, or none, found a device or a "
                "pipe");
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
  EXPECT_EQ(folder.FileCount(), 1u);
  // A link to a file is replaced, what it points to stays.
  const std::filesystem::path file = folder.Write("file", "mine");
  std::filesystem::create_symlink(file, folder / "link.png");
  WritePng(folder / "link.png", Gray8Image(2, 2));
  EXPECT_EQ(ContentOf(file), "mine");
}

TEST(ImageIoHardCases, HdrRefusesWhatItCannotHold) {
  const TemporaryFolder folder;
  for (const float value : {kNaN, kInfinity, -1.0f, 1e38f}) {
    RgbImage image(9, 1, glm::vec3(1.0f));
    image.At(4, 0).b = value;
    EXPECT_THROW(WriteHdr(folder / "a.hdr", image), std::invalid_argument);
  }
  EXPECT_EQ(folder.FileCount(), 0u);
}

TEST(ImageIoHardCases, RefusesImagesWithoutPixels) {
  const TemporaryFolder folder;
  EXPECT_THROW(WriteExr(folder / "a.exr", RgbImage(), ExrPrecision::kFloat), std::invalid_argument);
  EXPECT_THROW(WriteHdr(folder / "a.hdr", RgbImage(0, 5)), std::invalid_argument);
  EXPECT_THROW(WritePng(folder / "a.png", Rgb8Image()), std::invalid_argument);
  EXPECT_THROW(RgbImage(-1, 2), std::invalid_argument);
}

TEST(ImageIoHardCases, NamesTheFileThatCannotBeRead) {
  const TemporaryFolder folder;
  for (const char* extension : {".exr", ".hdr", ".png", ".jpg"}) {
    const std::string name = std::string("a") + extension;
    EXPECT_EQ(ReadingMessage(folder / name), (folder / name).string() + ": no such file");
    std::filesystem::create_directory(folder / name);
    EXPECT_THAT(ReadingMessage(folder / name), HasSubstr("not a regular file"));
    std::filesystem::remove(folder / name);
    EXPECT_THAT(ReadingMessage(folder.Write(name, "")), HasSubstr("empty"));
    EXPECT_THAT(ReadingMessage(folder.Write(name, "some text that is no image")),
                StartsWith((folder / name).string() + ": "));
  }
}

TEST(ImageIoHardCases, SaysWhatItFoundInPlaceOfAPicture) {
  const TemporaryFolder folder;
  const std::string nul(1, '\0');
  const std::pair<std::string, const char*> contents[] = {
      {"II*" + nul + "and so on", "found a TIFF picture or a camera's raw file"},
      {"RIFF....WEBPVP8 ", "found a WebP picture"},
      {"GIF89a", "found a GIF picture"},
      {"BM1234" + nul + nul + nul + nul + "6", "found a BMP picture"},
      {nul + nul + nul + "\x18" + "ftypheic", "found a HEIC picture"},
      {nul + nul + nul + "\x18" + "ftypisom", "found an MP4 video"},
      {nul + nul + nul + "\x14" + "ftypqt  ", "found a QuickTime video"},
      {"<html>no such page</html>\n", "found text"},
      {"\x01\x02", "found something else"}};
  for (const auto& [content, found] : contents) {
    const std::filesystem::path file = folder.Write("a.png", content);
    EXPECT_EQ(ReadingMessage(file), file.string() + ": expected a PNG or JPEG picture, " + found);
    EXPECT_THAT(MessageOf([&] { ReadRadianceImage(file); }), HasSubstr(found));
  }
}

// Every length of a file that is cut off: an error each time, in one line, never grey pixels.
TEST(ImageIoHardCases, TruncatedFilesAreErrors) {
  const TemporaryFolder folder;
  WriteExr(folder / "a.exr", Noise(24, 20), ExrPrecision::kHalf);
  WriteHdr(folder / "a.hdr", Noise(24, 20));
  Rgb8Image picture(24, 20);
  std::mt19937 random(12);
  for (glm::u8vec3& pixel : picture.pixels) pixel = glm::u8vec3(random(), random(), random());
  WritePng(folder / "a.png", picture);
  for (const char* name : {"a.exr", "a.hdr", "a.png"}) {
    const std::string whole = ContentOf(folder / name);
    ASSERT_EQ(ReadingMessage(folder / name), "");
    for (std::size_t length = 1; length < whole.size(); length += 37) {
      const std::string message = ReadingMessage(folder.Write(name, whole.substr(0, length)));
      ASSERT_THAT(message, StartsWith((folder / name).string() + ": ")) << length;
      ASSERT_THAT(message, Not(HasSubstr("\n")));
    }
  }
}

TEST(ImageIoHardCases, TruncatedPhotographsAreErrors) {
  const std::filesystem::path photo = std::filesystem::path(PLEINAIR_SHARED_DIR) /
                                      "sequences/courtyard-clouds/frames_ldr/000000.jpg";
  const std::filesystem::path other =
      std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences/berlin-photos/frames_ldr/000000.jpg";
  const std::filesystem::path file = std::filesystem::exists(photo) ? photo : other;
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "the recorded sequences are not here";
  const TemporaryFolder folder;
  const std::string whole = ContentOf(file);
  EXPECT_EQ(ReadingMessage(folder.Write("a.jpg", whole + "trailing bytes of a camera")), "");
  for (int part = 1; part < 50; ++part) {
    const std::size_t length = whole.size() * static_cast<std::size_t>(part) / 50;
    EXPECT_THAT(ReadingMessage(folder.Write("a.jpg", whole.substr(0, length))),
                HasSubstr("truncated"));
  }
}

// Random damage must end in an image or an error, and the error in one line.
TEST(ImageIoHardCases, DamagedFilesNeverCrash) {
  const TemporaryFolder folder;
  WriteExr(folder / "a.exr", Noise(16, 16), ExrPrecision::kHalf);
  WriteHdr(folder / "a.hdr", Noise(16, 16));
  WritePng(folder / "a.png", Rgb8Image(16, 16, glm::u8vec3(9)));
  constexpr unsigned kSeed = 13;
  std::mt19937 random(kSeed);
  int errors = 0;
  for (const char* name : {"a.exr", "a.hdr", "a.png"}) {
    const std::string whole = ContentOf(folder / name);
    for (int trial = 0; trial < 60; ++trial) {
      std::string damaged = whole;
      for (int i = 0; i < 3; ++i) {
        // Mostly in the header, where it counts.
        const std::size_t range =
            trial % 2 == 0 ? std::min<std::size_t>(300, damaged.size()) : damaged.size();
        damaged[random() % range] = static_cast<char>(random());
      }
      const std::string message = ReadingMessage(folder.Write(name, damaged));
      EXPECT_THAT(message, Not(HasSubstr("\n"))) << "seed " << kSeed << " trial " << trial;
      if (!message.empty()) ++errors;
    }
  }
  EXPECT_GT(errors, 30) << "the damage did not reach what is checked";
}

// The CRC-32 of PNG (ISO 3309), as four bytes.
std::string PngCheckSum(const std::string& bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1u) != 0 ? 0xedb88320u ^ crc >> 1 : crc >> 1;
  }
  std::string text;
  for (int shift = 24; shift >= 0; shift -= 8) text += static_cast<char>(~crc >> shift);
  return text;
}

// What passes all check sums is found by the decoders: one line, which is the exception's.
TEST(ImageIoHardCases, DecodersPrintNothing) {
  const TemporaryFolder folder;
  Rgb8Image picture(64, 64);
  std::mt19937 random(14);
  for (glm::u8vec3& pixel : picture.pixels) pixel = glm::u8vec3(random(), random(), random());
  WritePng(folder / "a.png", picture);
  std::string png = ContentOf(folder / "a.png");
  const std::size_t data = png.find("IDAT");
  ASSERT_NE(data, std::string::npos);
  std::size_t length = 0;
  for (std::size_t i = data - 4; i < data; ++i) length = length << 8 | static_cast<uint8_t>(png[i]);
  for (std::size_t i = data + 100; i < data + 140; ++i) png[i] = '\xff';
  png.replace(data + 4 + length, 4, PngCheckSum(png.substr(data, 4 + length)));
  folder.Write("a.png", png);

  WriteJpeg(folder / "a.jpg", picture, 90);
  std::string jpeg = ContentOf(folder / "a.jpg");
  jpeg.erase(jpeg.size() / 2, jpeg.size() / 2 - 2);  // The end marker stays.
  folder.Write("a.jpg", jpeg);

  testing::internal::CaptureStderr();
  const std::string of_png = ReadingMessage(folder / "a.png");
  const std::string of_jpeg = ReadingMessage(folder / "a.jpg");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_THAT(of_png, StartsWith((folder / "a.png").string() + ": the PNG image is damaged ("));
  EXPECT_THAT(of_jpeg, StartsWith((folder / "a.jpg").string() + ": the JPEG image is damaged ("));
}

// The response curve is one of the codes that the camera has written.
TEST(ImageIoHardCases, CodesAreThoseStoredWhateverGammaIsStated) {
  const TemporaryFolder folder;
  WritePng(folder / "a.png", Rgb8Image(2, 2, glm::u8vec3(10, 100, 200)));
  std::string png = ContentOf(folder / "a.png");
  const std::string linear = std::string("gAMA\0\1\x86\xa0", 8);  // 100000: codes are linear.
  png.insert(png.find("IDAT") - 4, std::string("\0\0\0\4", 4) + linear + PngCheckSum(linear));
  EXPECT_EQ(ReadDisplayImage(folder.Write("a.png", png)).At(1, 1), glm::u8vec3(10, 100, 200));
}

TEST(ImageIoHardCases, RefusesHugeImagesBeforeAllocating) {
  const TemporaryFolder folder;
  const std::string head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";
  EXPECT_THAT(ReadingMessage(folder.Write("a.hdr", head + "-Y 1000000 +X 1000000\nxxxx")),
              HasSubstr("image size 1000000x1000000"));
  EXPECT_THAT(ReadingMessage(folder.Write("b.hdr", head + "-Y 99999999999999999999 +X 1\nxxxx")),
              HasSubstr("resolution line"));
  const Imath::Box2i window({-2000000000, -2000000000}, {2000000000, 2000000000});
  Imf::Header header(window, window);
  for (const char* channel : {"R", "G", "B"}) header.channels().insert(channel, Imf::Channel());
  try {
    const Imf::OutputFile output((folder / "a.exr").c_str(), header);
  } catch (const std::exception&) {
    // OpenEXR may refuse it itself; then there is no such file to read.
    std::filesystem::remove(folder / "a.exr");
  }
  EXPECT_THAT(ReadingMessage(folder / "a.exr"), StartsWith((folder / "a.exr").string() + ": "));
}

// Sizes that memory would hold and the file's bytes do not: 16384 x 16384 in some hundred bytes.
TEST(ImageIoHardCases, RefusesSizesBeyondWhatTheBytesHold) {
  const TemporaryFolder folder;
  const std::string expected = "image size 16384x16384: expected no more pixels than";
  EXPECT_THAT(ReadingMessage(folder.Write(
                  "a.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16384 +X 16384\nxxxx")),
              HasSubstr(expected));

  WriteExr(folder / "a.exr", RgbImage(2, 2), ExrPrecision::kHalf);
  std::string exr = ContentOf(folder / "a.exr");
  for (const std::string window : {"dataWindow", "displayWindow"}) {
    // After the type's name, the length and the lower corner: both coordinates of the upper one.
    exr.replace(exr.find(window) + window.size() + std::string("_box2i_").size() + 4 + 8,
                8,
                std::string("\xff\x3f\0\0\xff\x3f\0\0", 8));
  }
  exr += std::string(8192, '\1');  // The table of lines, which OpenEXR reads first.
  EXPECT_THAT(ReadingMessage(folder.Write("a.exr", exr)), HasSubstr(expected));

  const std::string side("\0\0\x40\0", 4);
  WritePng(folder / "a.png", Rgb8Image(2, 2));
  std::string png = ContentOf(folder / "a.png");
  const std::string header = "IHDR" + side + side + png.substr(24, 5);
  png.replace(12, 21, header + PngCheckSum(header));
  EXPECT_THAT(ReadingMessage(folder.Write("a.png", png)), HasSubstr(expected));

  WriteJpeg(folder / "a.jpg", Rgb8Image(2, 2), 90);
  std::string jpeg = ContentOf(folder / "a.jpg");
  jpeg.replace(jpeg.find("\xff\xc0") + 5, 4, std::string("\x40\0\x40\0", 4));
  EXPECT_THAT(ReadingMessage(folder.Write("a.jpg", jpeg)), HasSubstr(expected));
}

// Some hundred bytes a scan, and each scan goes over all of the picture.
TEST(ImageIoHardCases, RefusesJpegOfThousandsOfScans) {
  const TemporaryFolder folder;
  const cv::Mat grey(64, 64, CV_8U, cv::Scalar(99));
  cv::imwrite((folder / "a.jpg").string(), grey, {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  std::string jpeg = ContentOf(folder / "a.jpg");
  const std::string last_scan = jpeg.substr(jpeg.rfind("\xff\xda"), std::string::npos);
  const std::string scan = last_scan.substr(0, last_scan.size() - 2);  // Without the end marker.
  std::string many;
  for (int i = 0; i < 3000; ++i) many += scan;
  jpeg.insert(jpeg.size() - 2, many);
  EXPECT_THAT(ReadingMessage(folder.Write("a.jpg", jpeg)), HasSubstr("more than 500 scans"));
}

// The flattest pictures that our writers and PNG's one bit give.
TEST(ImageIoHardCases, ReadsPicturesThatPackWell) {
  const TemporaryFolder folder;
  const RgbImage flat(1024, 1024, glm::vec3(0.5f));
  WriteExr(folder / "a.exr", flat, ExrPrecision::kHalf);
  EXPECT_EQ(ReadingMessage(folder / "a.exr"), "");
  WriteHdr(folder / "a.hdr", flat);
  EXPECT_EQ(ReadingMessage(folder / "a.hdr"), "");
  for (const char* name : {"a.png", "a.jpg"}) {
    const cv::Mat white(1024, 1024, CV_8U, cv::Scalar(255));
    cv::imwrite((folder / name).string(), white, {cv::IMWRITE_PNG_BILEVEL, 1});
    EXPECT_EQ(ReadingMessage(folder / name), "");
  }
  // 64 pixels of three channels are 6 bytes, packed 1032 to 1.
  Imf::Header header(1024, 1024);
  header.compression() = Imf::DWAB_COMPRESSION;
  std::vector<float> values(1024, 1.0f);
  Imf::FrameBuffer frame;
  for (const char* channel : {"R", "G", "B"}) {
    header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
    frame.insert(channel, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), 4, 0));
  }
  {
    Imf::OutputFile output((folder / "b.exr").c_str(), header);
    output.setFrameBuffer(frame);
    output.writePixels(1024);
  }
  EXPECT_EQ(ReadingMessage(folder / "b.exr"), "") << std::filesystem::file_size(folder / "b.exr");
}

TEST(ImageIoHardCases, RefusesExrWithoutRgb) {
  const TemporaryFolder folder;
  Imf::Header header(4, 4);
  header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
  std::vector<float> values(16, 1.0f);
  Imf::FrameBuffer frame;
  frame.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), 4, 16));
  {
    Imf::OutputFile output((folder / "a.exr").c_str(), header);
    output.setFrameBuffer(frame);
    output.writePixels(4);
  }
  EXPECT_THAT(ReadingMessage(folder / "a.exr"), HasSubstr("no channel R"));
}

TEST(ImageIoHardCases, RefusesSubSampledChannels) {
  const TemporaryFolder folder;
  Imf::Header header(4, 4);
  header.channels().insert("R", Imf::Channel(Imf::FLOAT, 2, 2));
  header.channels().insert("G", Imf::Channel(Imf::FLOAT));
  header.channels().insert("B", Imf::Channel(Imf::FLOAT));
  std::vector<float> values(16, 1.0f);
  char* const base = reinterpret_cast<char*>(values.data());
  Imf::FrameBuffer frame;
  frame.insert("R", Imf::Slice(Imf::FLOAT, base, 4, 8, 2, 2));
  frame.insert("G", Imf::Slice(Imf::FLOAT, base, 4, 16));
  frame.insert("B", Imf::Slice(Imf::FLOAT, base, 4, 16));
  {
    Imf::OutputFile output((folder / "a.exr").c_str(), header);
    output.setFrameBuffer(frame);
    output.writePixels(4);
  }
  EXPECT_THAT(ReadingMessage(folder / "a.exr"), HasSubstr("sub-sampled"));
}

}  // namespace
}  // namespace pleinair::image_io_hard_cases_test
