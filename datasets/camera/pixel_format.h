// Layouts of a camera's picture in memory.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace pleinair {

// Memory layouts of a picture.
enum class PixelCoding {
  kYuyv,   // Y0 U Y1 V: two pixels in four bytes.
  kNv12,   // A plane of Y, then one of U V pairs at half the size.
  kMjpeg,  // A JPEG a picture.
  kGrey,   // A byte a pixel.
  kRgb,    // Three bytes a pixel: R G B.
  kBayer,  // A colour a pixel: light in proportion to the code above the black level.
};

// The colours of the top row's first two pixels, and of the row below.
enum class BayerOrder { kRggb, kGrbg, kGbrg, kBggr };

// Plain Bayer rows have 8 bits in a byte, or more in two bytes (little-endian, upper bits 0).
// Packed rows have four pixels of 10 bits in 5 bytes, or two of 12 bits in 3. The upper eight bits
// of each pixel come first, then the lower ones of all, first pixel lowest (MIPI CSI-2).
struct PixelFormat {
  PixelCoding coding = PixelCoding::kRgb;
  int bits = 8;  // 8, 10 or 12; other than 8 only for Bayer.
  bool is_packed = false;
  BayerOrder order = BayerOrder::kRggb;

  bool operator==(const PixelFormat&) const = default;
};

// V4L2's four-character code, "YUYV", "pRAA"; none where V4L2 knows no such format.
std::optional<PixelFormat> PixelFormatOf(std::uint32_t fourcc);
std::uint32_t FourccOf(const PixelFormat& format);

// Its usual name: "YUYV", "NV12", "MJPEG", "GREY", "RGB24", "SRGGB8", "SRGGB10", "SRGGB10P".
std::string NameOf(const PixelFormat& format);
// Upper or lower case.
std::optional<PixelFormat> PixelFormatNamed(std::string_view name);

enum class YuvMatrix { kBt601, kBt709, kBt2020 };

// The conversion of Y, U and V to R, G and B.
struct YuvCoding {
  YuvMatrix matrix = YuvMatrix::kBt601;
  bool is_full_range = false;  // Else Y is 16 to 235, and U and V 16 to 240.

  bool operator==(const YuvCoding&) const = default;
};

// The layout of one picture in memory.
struct PictureLayout {
  PixelFormat format;
  int width_px = 0;
  int height_px = 0;
  int stride_bytes = 0;  // From row to row; without meaning for MJPEG.
  YuvCoding yuv;         // Only for YUYV and NV12: a JPEG has its own.

  bool operator==(const PictureLayout&) const = default;
};

}  // namespace pleinair
