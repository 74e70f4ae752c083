#include "scene/internal/texture_decoding.h"

#include <cstddef>
#include <span>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

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

}  // namespace
}  // namespace pleinair::texture_decoding_test
