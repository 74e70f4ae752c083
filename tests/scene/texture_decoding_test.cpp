#include "scene/internal/texture_decoding.h"

#include <cstddef>
#include <cstring>
#include <span>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace pleinair::texture_decoding_test {
namespace {

// Twice as wide as high, and marked by a camera that was held upright.
std::vector<unsigned char> TurnedJpeg() {
  std::vector<unsigned char> plain;
  cv::imencode(".jpg", cv::Mat(8, 16, CV_8UC3, cv::Scalar(40, 120, 200)), plain);
  const std::vector<unsigned char> exif{
      0xff, 0xe1, 0,   34,                           // Application segment of 34 bytes.
      'E',  'x',  'i', 'f', 0, 0,                    //
      'I',  'I',  42,  0,   8, 0, 0, 0,              // Little-endian, its directory after 8 bytes,
      1,    0,                                       // of one entry:
      0x12, 0x01, 3,   0,   1, 0, 0, 0, 6, 0, 0, 0,  // orientation, a short, 6: turned by 90 deg.
      0,    0,    0,   0};                           // No other directory.
  plain.insert(plain.begin() + 2, exif.begin(), exif.end());
  return plain;
}

// Coordinates are of the picture as it lies in the file.
TEST(TextureDecoding, DoesNotTurnPicturesAsCamerasWereHeld) {
  const std::vector<unsigned char> jpeg = TurnedJpeg();
  ASSERT_EQ(cv::imdecode(jpeg, cv::IMREAD_COLOR).rows, 16) << "a picture that readers do turn";
  for (const bool with_alpha : {false, true}) {
    const auto texture = DecodeTexture(std::as_bytes(std::span(jpeg)), with_alpha);
    ASSERT_NE(texture, nullptr);
    EXPECT_EQ(texture->Width(), 16);
    EXPECT_EQ(texture->Height(), 8);
  }
}

// The decoder that is used here against another one, bit for bit.
TEST(TextureDecoding, GivesTheCodesOfOpenCv) {
  cv::Mat picture(37, 53, CV_8UC4);
  cv::theRNG().state = 15;
  cv::randu(picture, 0, 256);
  cv::Mat colours;
  cv::Mat grey;
  cv::cvtColor(picture, colours, cv::COLOR_BGRA2BGR);
  cv::cvtColor(picture, grey, cv::COLOR_BGRA2GRAY);
  for (const cv::Mat& drawn : {picture, colours, grey}) {
    for (const char* format : {".png", ".jpg"}) {
      std::vector<unsigned char> encoded;
      cv::imencode(format, drawn, encoded);
      cv::Mat expected = cv::imdecode(encoded, cv::IMREAD_UNCHANGED);
      if (expected.channels() == 1) cv::cvtColor(expected, expected, cv::COLOR_GRAY2BGR);
      cv::cvtColor(
          expected, expected, expected.channels() == 4 ? cv::COLOR_BGRA2RGBA : cv::COLOR_BGR2RGBA);
      const auto texture = DecodeTexture(std::as_bytes(std::span(encoded)), true);
      ASSERT_NE(texture, nullptr);
      const auto& texels = texture->Level(0).pixels;
      ASSERT_EQ(texels.size(), expected.total());
      EXPECT_EQ(std::memcmp(texels.data(), expected.data, 4 * expected.total()), 0)
          << format << " of " << drawn.channels() << " channels";
    }
  }
}

}  // namespace
}  // namespace pleinair::texture_decoding_test
