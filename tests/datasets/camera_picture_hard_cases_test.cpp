// Bytes and layouts that no camera should give: a line says so, and nothing past the bytes is read.
#include <climits>
#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/camera/camera_picture.h"
#include "tests/datasets/guarded_bytes.h"
#include "tests/datasets/raw_picture.h"

namespace pleinair::camera_picture_hard_cases_test {
namespace {

using testing::HasSubstr;

std::vector<PixelFormat> AllFormats() {
  std::vector<PixelFormat> formats{{PixelCoding::kYuyv},
                                   {PixelCoding::kNv12},
                                   {PixelCoding::kMjpeg},
                                   {PixelCoding::kGrey},
                                   {PixelCoding::kRgb}};
  for (const BayerOrder order : kAllOrders) {
    for (const int bits : {8, 10, 12}) {
      for (const bool is_packed : {false, true}) {
        if (bits > 8 || !is_packed) {
          formats.push_back({PixelCoding::kBayer, bits, is_packed, order});
        }
      }
    }
  }
  return formats;
}

// Its reason; empty where the bytes are such a picture.
std::string Decode(std::span<const std::byte> bytes, const PictureLayout& layout) {
  std::string reason;
  if (layout.format.coding == PixelCoding::kBayer) {
    const auto picture = Develop(bytes, layout, UsualDevelopment(layout.format.bits));
    if (picture) {
      EXPECT_EQ(picture->signal_rgb.width, layout.width_px);
      EXPECT_EQ(picture->clipped.height, layout.height_px);
      return {};
    }
    reason = picture.error();
  } else {
    const auto picture = DecodeCodes(bytes, layout);
    if (picture) {
      EXPECT_EQ(picture->width, layout.width_px);
      EXPECT_EQ(picture->height, layout.height_px);
      return {};
    }
    reason = picture.error();
  }
  EXPECT_EQ(reason.find("camera picture: "), 0u) << reason;
  EXPECT_EQ(reason.find('\n'), std::string::npos) << reason;
  return reason;
}

int RowBytes(const PixelFormat& format, int width_px) {
  if (format.coding == PixelCoding::kYuyv) return 2 * width_px;
  if (format.coding == PixelCoding::kRgb) return 3 * width_px;
  return RawRowBytes(format, width_px);
}

TEST(CameraPictureHardCases, EveryTruncationIsAnErrorAndNothingBeyondIsRead) {
  for (const PixelFormat& format : AllFormats()) {
    if (format.coding == PixelCoding::kMjpeg) continue;  // Of camera_picture_test.cpp.
    for (const int width : {4, 6, 8}) {
      constexpr int kHeight = 5;
      const int row = RowBytes(format, width);
      const int rows = format.coding == PixelCoding::kNv12 ? kHeight + 3 : kHeight;
      for (const int stride : {row, row + 3}) {
        const PictureLayout layout{format, width, kHeight, stride, {}};
        const std::vector<std::byte> bytes(static_cast<std::size_t>(stride * (rows - 1) + row),
                                           std::byte{0x7f});
        for (std::size_t size = 0; size < bytes.size(); ++size) {
          const GuardedBytes cut{std::span(bytes).first(size)};
          ASSERT_THAT(Decode(cut.Bytes(), layout), HasSubstr("bytes")) << NameOf(format);
        }
        const GuardedBytes complete(bytes);
        EXPECT_EQ(Decode(complete.Bytes(), layout), "") << NameOf(format);
      }
    }
  }
}

TEST(CameraPictureHardCases, LayoutsThatNoPictureHasAreErrors) {
  const std::vector<std::byte> bytes(4096);
  for (const PixelFormat& format : AllFormats()) {
    for (const auto& [width, height] : {std::pair{0, 8},
                                        {8, 0},
                                        {-8, 8},
                                        {8, -8},
                                        {INT_MAX, 8},
                                        {8, INT_MAX},
                                        {INT_MIN, INT_MIN},
                                        {65537, 1}}) {
      const PictureLayout layout{format, width, height, INT_MAX, {}};
      EXPECT_THAT(Decode(bytes, layout), HasSubstr("expected sides")) << NameOf(format);
    }
    if (format.coding == PixelCoding::kMjpeg) continue;
    EXPECT_NE(Decode(bytes, {format, 65536, 65536, INT_MAX, {}}), "");
    for (const int stride : {INT_MIN, -1, 0, 7}) {
      EXPECT_THAT(Decode(bytes, {format, 8, 8, stride, {}}),
                  HasSubstr(stride < RowBytes(format, 8) ? "a row or more" : ""))
          << NameOf(format);
    }
  }
  for (const PixelCoding coding : {PixelCoding::kYuyv, PixelCoding::kNv12, PixelCoding::kBayer}) {
    EXPECT_THAT(Decode(bytes, {{coding}, 7, 8, 64, {}}), HasSubstr("even width"));
  }
  EXPECT_THAT(Decode(bytes, {{PixelCoding::kBayer}, 2, 8, 64, {}}), HasSubstr("4x4"));
}

// Bits that no sensor's format has: also 8 of packed ones, and none at all.
TEST(CameraPictureHardCases, FormatsThatDoNotExistAreErrors) {
  const std::vector<std::byte> bytes(4096);
  for (const int bits : {INT_MIN, -1, 0, 1, 7, 9, 14, 16, 17, INT_MAX}) {
    for (const bool is_packed : {false, true}) {
      const PictureLayout layout{{PixelCoding::kBayer, bits, is_packed}, 8, 8, 64, {}};
      const auto picture = Develop(bytes, layout, UsualDevelopment(8));
      ASSERT_FALSE(picture) << bits;
      EXPECT_THAT(picture.error(), HasSubstr("format"));
    }
  }
  EXPECT_FALSE(Develop(bytes, {{PixelCoding::kBayer, 8, true}, 8, 8, 64, {}}, UsualDevelopment(8)));
}

TEST(CameraPictureHardCases, RandomBytesAndLayoutsEndInAPictureOrALine) {
  std::mt19937 random(3);
  const auto below = [&](int limit) {
    return static_cast<int>(random() % static_cast<unsigned>(limit));
  };
  std::map<std::string, std::pair<int, int>> outcomes;  // Pictures and errors by format.
  for (int round = 0; round < 400; ++round) {
    std::vector<std::byte> bytes(static_cast<std::size_t>(below(1500)));
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(below(256));
    // The beginning of a JPEG, to be read on.
    if (bytes.size() > 2 && round % 2 == 0) {
      bytes[0] = std::byte{0xff};
      bytes[1] = std::byte{0xd8};
      bytes[2] = std::byte{0xff};
    }
    const GuardedBytes guarded(bytes);
    for (const PixelFormat& format : AllFormats()) {
      const PictureLayout layout{format,
                                 below(30) - 1,
                                 below(20) - 1,
                                 below(100) - 2,
                                 {static_cast<YuvMatrix>(below(3)), below(2) == 0}};
      const std::string reason = Decode(guarded.Bytes(), layout);
      auto& [pictures, errors] = outcomes[NameOf(format)];
      ++(reason.empty() ? pictures : errors);
    }
  }
  EXPECT_EQ(outcomes.size(), AllFormats().size());
  for (const auto& [name, count] : outcomes) {
    if (name != "MJPEG") {
      EXPECT_GT(count.first, 10) << name;
    }
    EXPECT_GT(count.second, 10) << name;
  }
}

}  // namespace
}  // namespace pleinair::camera_picture_hard_cases_test
