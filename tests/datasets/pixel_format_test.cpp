// Pixel formats by V4L2's codes and by their names.
#include "datasets/camera/pixel_format.h"

#include <cctype>
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

namespace pleinair::pixel_format_test {
namespace {

struct Published {
  const char* code;  // Of linux/videodev2.h.
  const char* name;
  PixelFormat format;
};

constexpr PixelFormat Raw(BayerOrder order, int bits, bool is_packed) {
  return {PixelCoding::kBayer, bits, is_packed, order};
}

// The characters as the kernel's documentation of pixel formats lists them.
constexpr Published kPublished[] = {
    {"YUYV", "YUYV", {PixelCoding::kYuyv}},
    {"NV12", "NV12", {PixelCoding::kNv12}},
    {"MJPG", "MJPEG", {PixelCoding::kMjpeg}},
    {"GREY", "GREY", {PixelCoding::kGrey}},
    {"RGB3", "RGB24", {PixelCoding::kRgb}},
    {"RGGB", "SRGGB8", Raw(BayerOrder::kRggb, 8, false)},
    {"GRBG", "SGRBG8", Raw(BayerOrder::kGrbg, 8, false)},
    {"GBRG", "SGBRG8", Raw(BayerOrder::kGbrg, 8, false)},
    {"BA81", "SBGGR8", Raw(BayerOrder::kBggr, 8, false)},
    {"RG10", "SRGGB10", Raw(BayerOrder::kRggb, 10, false)},
    {"BA10", "SGRBG10", Raw(BayerOrder::kGrbg, 10, false)},
    {"GB10", "SGBRG10", Raw(BayerOrder::kGbrg, 10, false)},
    {"BG10", "SBGGR10", Raw(BayerOrder::kBggr, 10, false)},
    {"pRAA", "SRGGB10P", Raw(BayerOrder::kRggb, 10, true)},
    {"pgAA", "SGRBG10P", Raw(BayerOrder::kGrbg, 10, true)},
    {"pGAA", "SGBRG10P", Raw(BayerOrder::kGbrg, 10, true)},
    {"pBAA", "SBGGR10P", Raw(BayerOrder::kBggr, 10, true)},
    {"RG12", "SRGGB12", Raw(BayerOrder::kRggb, 12, false)},
    {"BA12", "SGRBG12", Raw(BayerOrder::kGrbg, 12, false)},
    {"GB12", "SGBRG12", Raw(BayerOrder::kGbrg, 12, false)},
    {"BG12", "SBGGR12", Raw(BayerOrder::kBggr, 12, false)},
    {"pRCC", "SRGGB12P", Raw(BayerOrder::kRggb, 12, true)},
    {"pgCC", "SGRBG12P", Raw(BayerOrder::kGrbg, 12, true)},
    {"pGCC", "SGBRG12P", Raw(BayerOrder::kGbrg, 12, true)},
    {"pBCC", "SBGGR12P", Raw(BayerOrder::kBggr, 12, true)},
};

std::uint32_t Code(const char* text) {
  std::uint32_t code = 0;
  for (int i = 3; i >= 0; --i) code = code << 8 | static_cast<unsigned char>(text[i]);
  return code;
}

TEST(PixelFormat, HasV4l2sPublishedCodes) {
  for (const Published& one : kPublished) {
    EXPECT_EQ(PixelFormatOf(Code(one.code)), one.format) << one.code;
    EXPECT_EQ(FourccOf(one.format), Code(one.code)) << one.name;
  }
  // Motion-JPEG's other code.
  EXPECT_EQ(PixelFormatOf(Code("JPEG")), PixelFormat{PixelCoding::kMjpeg});
}

TEST(PixelFormat, IsFoundByItsNameInAnyCase) {
  for (const Published& one : kPublished) {
    EXPECT_EQ(NameOf(one.format), one.name);
    std::string lower = one.name;
    for (char& c : lower) c = static_cast<char>(std::tolower(c));
    EXPECT_EQ(PixelFormatNamed(one.name), one.format);
    EXPECT_EQ(PixelFormatNamed(lower), one.format);
  }
  for (const char* wrong : {"", "YUY", "YUYV ", " YUYV", "YUYV2", "MJPG", "SRGGB", "SRGGB16"}) {
    EXPECT_FALSE(PixelFormatNamed(wrong)) << wrong;
  }
}

TEST(PixelFormat, CodesOfNoFormatAreNone) {
  for (const char* code : {"H264", "yuyv", "UYVY", "RGB4"}) {
    EXPECT_FALSE(PixelFormatOf(Code(code))) << code;
  }
  EXPECT_FALSE(PixelFormatOf(0));
  EXPECT_EQ(FourccOf(Raw(BayerOrder::kRggb, 9, false)), 0u);
  EXPECT_EQ(FourccOf(Raw(BayerOrder::kRggb, 8, true)), 0u);
  EXPECT_EQ(NameOf(Raw(BayerOrder::kRggb, 16, false)), "unknown");
}

}  // namespace
}  // namespace pleinair::pixel_format_test
