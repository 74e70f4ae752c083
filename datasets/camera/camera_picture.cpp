#include "datasets/camera/camera_picture.h"

#include <turbojpeg.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

namespace pleinair {
namespace {

// Sides beyond this are no camera's.
constexpr int kMostSidePx = 65536;

std::size_t RowBytes(const PictureLayout& layout) {
  const auto width = static_cast<std::size_t>(layout.width_px);
  switch (layout.format.coding) {
    case PixelCoding::kYuyv:
      return 2 * width;
    case PixelCoding::kRgb:
      return 3 * width;
    case PixelCoding::kBayer:
      if (layout.format.is_packed)
        return (width * static_cast<std::size_t>(layout.format.bits) + 7) / 8;
      return layout.format.bits > 8 ? 2 * width : width;
    case PixelCoding::kMjpeg:
      return 0;
    case PixelCoding::kNv12:
    case PixelCoding::kGrey:
      break;
  }
  return width;
}

// Rows of the picture that the bytes hold: NV12's colours follow its brightness.
std::size_t RowCount(const PictureLayout& layout) {
  const auto height = static_cast<std::size_t>(layout.height_px);
  return layout.format.coding == PixelCoding::kNv12 ? height + (height + 1) / 2 : height;
}

// One line; empty where the bytes hold such a picture.
std::string FaultOf(std::span<const std::byte> bytes, const PictureLayout& layout) {
  const auto is_side = [](int side) { return side >= 1 && side <= kMostSidePx; };
  if (!is_side(layout.width_px) || !is_side(layout.height_px)) {
    return fmt::format("camera picture: expected sides of 1 to {} pixels, found {}x{}",
                       kMostSidePx,
                       layout.width_px,
                       layout.height_px);
  }
  if (FourccOf(layout.format) == 0) {
    return fmt::format("camera picture: expected a known pixel format, found one of {} bits",
                       layout.format.bits);
  }
  const PixelCoding coding = layout.format.coding;
  const bool pairs = coding == PixelCoding::kYuyv || coding == PixelCoding::kNv12;
  if ((pairs || coding == PixelCoding::kBayer) && layout.width_px % 2 != 0) {
    return fmt::format("camera picture: expected an even width of {}, found {}",
                       NameOf(layout.format),
                       layout.width_px);
  }
  if (coding == PixelCoding::kMjpeg) {
    return bytes.empty() ? "camera picture: expected a JPEG, found no bytes" : std::string();
  }
  const std::size_t row = RowBytes(layout);
  if (layout.stride_bytes < 0 || static_cast<std::size_t>(layout.stride_bytes) < row) {
    return fmt::format(
        "camera picture: expected {} bytes a row or more, found {}", row, layout.stride_bytes);
  }
  const std::size_t needed =
      (RowCount(layout) - 1) * static_cast<std::size_t>(layout.stride_bytes) + row;
  if (bytes.size() < needed) {
    return fmt::format("camera picture: expected {} bytes of {} {}x{}, found {}",
                       needed,
                       NameOf(layout.format),
                       layout.width_px,
                       layout.height_px,
                       bytes.size());
  }
  return {};
}

const std::uint8_t* Row(std::span<const std::byte> bytes, const PictureLayout& layout, int y) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data()) +
         static_cast<std::size_t>(y) * static_cast<std::size_t>(layout.stride_bytes);
}

// R, G and B of Y, U and V as ITU-R BT.601, 709 and 2020 define them, in units of 2^-16 codes.
class YuvConversion {
 public:
  explicit YuvConversion(const YuvCoding& coding) {
    const auto [kr, kb] = LumaShares(coding.matrix);
    const double kg = 1.0 - kr - kb;
    const double y_scale = coding.is_full_range ? 1.0 : 255.0 / 219.0;
    const double c_scale = coding.is_full_range ? 1.0 : 255.0 / 224.0;
    y_offset_ = coding.is_full_range ? 0 : 16;
    y_ = Fixed(y_scale);
    r_of_v_ = Fixed(2.0 * (1.0 - kr) * c_scale);
    b_of_u_ = Fixed(2.0 * (1.0 - kb) * c_scale);
    g_of_u_ = Fixed(-2.0 * (1.0 - kb) * kb / kg * c_scale);
    g_of_v_ = Fixed(-2.0 * (1.0 - kr) * kr / kg * c_scale);
  }

  glm::u8vec3 Rgb(int y, int u, int v) const {
    const int luma = (y - y_offset_) * y_ + kHalf;
    u -= 128;
    v -= 128;
    return {
        Code(luma + r_of_v_ * v), Code(luma + g_of_u_ * u + g_of_v_ * v), Code(luma + b_of_u_ * u)};
  }

 private:
  static constexpr int kHalf = 1 << 15;
  struct Shares {
    double red;
    double blue;
  };
  static Shares LumaShares(YuvMatrix matrix) {
    switch (matrix) {
      case YuvMatrix::kBt709:
        return {0.2126, 0.0722};
      case YuvMatrix::kBt2020:
        return {0.2627, 0.0593};
      case YuvMatrix::kBt601:
        break;
    }
    return {0.299, 0.114};
  }
  static int Fixed(double factor) { return static_cast<int>(std::lround(factor * 65536.0)); }
  static std::uint8_t Code(int fixed) {
    return static_cast<std::uint8_t>(std::clamp(fixed >> 16, 0, 255));
  }

  int y_offset_ = 0;
  int y_ = 0;
  int r_of_v_ = 0;
  int b_of_u_ = 0;
  int g_of_u_ = 0;
  int g_of_v_ = 0;
};

Rgb8Image FromYuyv(std::span<const std::byte> bytes, const PictureLayout& layout) {
  const YuvConversion conversion(layout.yuv);
  Rgb8Image picture(layout.width_px, layout.height_px);
  for (int y = 0; y < picture.height; ++y) {
    const std::uint8_t* row = Row(bytes, layout, y);
    for (int x = 0; x + 1 < picture.width; x += 2, row += 4) {
      picture.At(x, y) = conversion.Rgb(row[0], row[1], row[3]);
      picture.At(x + 1, y) = conversion.Rgb(row[2], row[1], row[3]);
    }
  }
  return picture;
}

Rgb8Image FromNv12(std::span<const std::byte> bytes, const PictureLayout& layout) {
  const YuvConversion conversion(layout.yuv);
  Rgb8Image picture(layout.width_px, layout.height_px);
  for (int y = 0; y < picture.height; ++y) {
    const std::uint8_t* luma = Row(bytes, layout, y);
    const std::uint8_t* colour = Row(bytes, layout, picture.height + y / 2);
    for (int x = 0; x < picture.width; ++x) {
      const int pair = x - x % 2;
      picture.At(x, y) = conversion.Rgb(luma[x], colour[pair], colour[pair + 1]);
    }
  }
  return picture;
}

Rgb8Image FromGrey(std::span<const std::byte> bytes, const PictureLayout& layout) {
  Rgb8Image picture(layout.width_px, layout.height_px);
  for (int y = 0; y < picture.height; ++y) {
    const std::uint8_t* row = Row(bytes, layout, y);
    for (int x = 0; x < picture.width; ++x) picture.At(x, y) = glm::u8vec3(row[x]);
  }
  return picture;
}

Rgb8Image FromRgb(std::span<const std::byte> bytes, const PictureLayout& layout) {
  Rgb8Image picture(layout.width_px, layout.height_px);
  for (int y = 0; y < picture.height; ++y) {
    const std::uint8_t* row = Row(bytes, layout, y);
    for (int x = 0; x < picture.width; ++x, row += 3) picture.At(x, y) = {row[0], row[1], row[2]};
  }
  return picture;
}

// Whether an end of image follows the last start of a scan.
bool HasJpegEnd(std::span<const std::byte> bytes) {
  constexpr std::array kScan = {std::byte{0xff}, std::byte{0xda}};
  constexpr std::array kEnd = {std::byte{0xff}, std::byte{0xd9}};
  const auto scan = std::find_end(bytes.begin(), bytes.end(), kScan.begin(), kScan.end());
  return std::search(scan, bytes.end(), kEnd.begin(), kEnd.end()) != bytes.end();
}

// Whether turbojpeg's last failure is only padding before a marker. Logitech's C270 and C910 leave
// 1 to 9 bytes in almost every picture; a loss on the bus leaves hundreds.
bool IsPadding(tjhandle decoder, std::span<const std::byte> bytes) {
  constexpr unsigned kMostPadding = 16;
  unsigned padding = 0;
  // The text is that of the first warning: a missing end may come after it.
  return tjGetErrorCode(decoder) == TJERR_WARNING &&
         std::sscanf(tjGetErrorStr2(decoder),
                     "Corrupt JPEG data: %u extraneous bytes before marker",
                     &padding) == 1 &&
         padding <= kMostPadding && HasJpegEnd(bytes);
}

tl::expected<Rgb8Image, std::string> FromJpeg(std::span<const std::byte> bytes,
                                              const PictureLayout& layout) {
  const std::unique_ptr<void, int (*)(tjhandle)> decoder(tjInitDecompress(), tjDestroy);
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  const auto refuse = [&] {
    return tl::unexpected(fmt::format("camera picture: damaged JPEG: {}",
                                      std::string(tjGetErrorStr2(decoder.get()))));
  };
  int width = 0;
  int height = 0;
  int subsampling = 0;
  int colours = 0;
  if (tjDecompressHeader3(
          decoder.get(), data, bytes.size(), &width, &height, &subsampling, &colours) != 0 &&
      !IsPadding(decoder.get(), bytes)) {
    return refuse();
  }
  if (width != layout.width_px || height != layout.height_px) {
    return tl::unexpected(
        fmt::format("camera picture: expected a JPEG of {}x{} pixels, found {}x{}",
                    layout.width_px,
                    layout.height_px,
                    width,
                    height));
  }
  Rgb8Image picture(width, height);
  // Any other warning is damage, too: the picture continues in grey from there. Each scan of a
  // progressive picture covers all of it: at most 500.
  if (tjDecompress2(decoder.get(),
                    data,
                    bytes.size(),
                    reinterpret_cast<unsigned char*>(picture.pixels.data()),
                    width,
                    0,
                    height,
                    TJPF_RGB,
                    TJFLAG_LIMITSCANS) != 0 &&
      !IsPadding(decoder.get(), bytes)) {
    return refuse();
  }
  return picture;
}

// Codes in the upper bits of 16, so that interpolation between them is not rounded to whole codes.
cv::Mat RawCodes(std::span<const std::byte> bytes, const PictureLayout& layout) {
  const int bits = layout.format.bits;
  const auto shift = static_cast<unsigned>(16 - bits);
  cv::Mat codes(layout.height_px, layout.width_px, CV_16U);
  for (int y = 0; y < layout.height_px; ++y) {
    const std::uint8_t* row = Row(bytes, layout, y);
    auto* out = codes.ptr<std::uint16_t>(y);
    const auto put = [&](int x, unsigned code) {
      out[x] = static_cast<std::uint16_t>((code & ((1u << bits) - 1u)) << shift);
    };
    for (int x = 0; x < layout.width_px; ++x) {
      if (!layout.format.is_packed) {
        put(x, bits > 8 ? row[2 * x] | (unsigned{row[2 * x + 1]} << 8) : row[x]);
        continue;
      }
      const int group = 8 / (bits - 8);  // Pixels that share a byte of lower bits: 4 or 2.
      const std::uint8_t* at = row + (x / group) * (group + 1);
      const auto low_shift = static_cast<unsigned>(x % group * (bits - 8));
      const unsigned low =
          (unsigned{at[std::min<std::ptrdiff_t>(group, row + RowBytes(layout) - 1 - at)]} >>
           low_shift) &
          ((1u << (bits - 8)) - 1u);
      put(x, (unsigned{at[x % group]} << (bits - 8)) | low);
    }
  }
  return codes;
}

int OpenCvDemosaicing(BayerOrder order) {
  switch (order) {
    case BayerOrder::kGrbg:
      return cv::COLOR_BayerGRBG2RGB;
    case BayerOrder::kGbrg:
      return cv::COLOR_BayerGBRG2RGB;
    case BayerOrder::kBggr:
      return cv::COLOR_BayerBGGR2RGB;
    case BayerOrder::kRggb:
      break;
  }
  return cv::COLOR_BayerRGGB2RGB;
}

}  // namespace

tl::expected<Rgb8Image, std::string> DecodeCodes(std::span<const std::byte> bytes,
                                                 const PictureLayout& layout) {
  if (std::string fault = FaultOf(bytes, layout); !fault.empty()) {
    return tl::unexpected(std::move(fault));
  }
  switch (layout.format.coding) {
    case PixelCoding::kYuyv:
      return FromYuyv(bytes, layout);
    case PixelCoding::kNv12:
      return FromNv12(bytes, layout);
    case PixelCoding::kMjpeg:
      return FromJpeg(bytes, layout);
    case PixelCoding::kGrey:
      return FromGrey(bytes, layout);
    case PixelCoding::kRgb:
      return FromRgb(bytes, layout);
    case PixelCoding::kBayer:
      break;
  }
  return tl::unexpected(
      fmt::format("camera picture: expected codes, found raw {}", NameOf(layout.format)));
}

void RawDevelopment::Validate() const {
  if (!(black_level >= 0.0) || !(black_level < white_level) || !std::isfinite(white_level)) {
    throw std::invalid_argument(
        fmt::format("raw development: expected 0 <= black level < white level, found {} and {}",
                    black_level,
                    white_level));
  }
  for (int c = 0; c < 3; ++c) {
    if (white_balance_rgb[c] > 0.0 && std::isfinite(white_balance_rgb[c])) continue;
    throw std::invalid_argument(fmt::format(
        "raw development: expected white balance factors above 0, found {}", white_balance_rgb[c]));
  }
}

RawDevelopment UsualDevelopment(int bits) {
  const double codes = std::ldexp(1.0, bits);
  return {codes / 16.0, codes - 1.0, glm::dvec3(1.0)};
}

tl::expected<DevelopedPicture, std::string> Develop(std::span<const std::byte> bytes,
                                                    const PictureLayout& layout,
                                                    const RawDevelopment& development) {
  development.Validate();
  if (layout.format.coding != PixelCoding::kBayer) {
    return tl::unexpected(
        fmt::format("camera picture: expected a raw one, found {}", NameOf(layout.format)));
  }
  if (std::string fault = FaultOf(bytes, layout); !fault.empty()) {
    return tl::unexpected(std::move(fault));
  }
  // Pixels that bilinear interpolation needs around a pixel.
  if (layout.width_px < 4 || layout.height_px < 4) {
    return tl::unexpected(
        fmt::format("camera picture: expected 4x4 raw pixels or more, found {}x{}",
                    layout.width_px,
                    layout.height_px));
  }
  const cv::Mat codes = RawCodes(bytes, layout);
  cv::Mat rgb;
  cv::demosaicing(codes, rgb, OpenCvDemosaicing(layout.format.order));
  // A colour is interpolated between neighbours at most; a pixel of the border has its neighbour's.
  const double unit = std::ldexp(1.0, 16 - layout.format.bits);
  cv::Mat clipped;
  cv::dilate(codes >= development.white_level * unit, clipped, cv::Mat::ones(3, 3, CV_8U));
  const cv::Rect inside(1, 1, layout.width_px - 2, layout.height_px - 2);
  cv::copyMakeBorder(clipped(inside).clone(), clipped, 1, 1, 1, 1, cv::BORDER_REPLICATE);

  DevelopedPicture picture{RgbImage(layout.width_px, layout.height_px),
                           Gray8Image(layout.width_px, layout.height_px)};
  const double range = development.white_level - development.black_level;
  const glm::dvec3 scale = development.white_balance_rgb / (range * unit);
  const glm::dvec3 offset = development.white_balance_rgb * (development.black_level / range);
  for (int y = 0; y < layout.height_px; ++y) {
    const auto* row = rgb.ptr<cv::Vec<std::uint16_t, 3>>(y);
    const std::uint8_t* is_clipped = clipped.ptr<std::uint8_t>(y);
    for (int x = 0; x < layout.width_px; ++x) {
      const glm::dvec3 code(row[x][0], row[x][1], row[x][2]);
      picture.signal_rgb.At(x, y) = glm::vec3(code * scale - offset);
      picture.clipped.At(x, y) = is_clipped[x] != 0 ? 1 : 0;
    }
  }
  return picture;
}

}  // namespace pleinair
