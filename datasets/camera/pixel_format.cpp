#include "datasets/camera/pixel_format.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <cctype>

namespace pleinair {
namespace {

struct NamedFormat {
  std::uint32_t fourcc;
  const char* name;
  PixelFormat format;
};

constexpr PixelFormat Bayer(BayerOrder order, int bits, bool is_packed) {
  return {PixelCoding::kBayer, bits, is_packed, order};
}

constexpr NamedFormat kFormats[] = {
    {V4L2_PIX_FMT_YUYV, "YUYV", {PixelCoding::kYuyv}},
    {V4L2_PIX_FMT_NV12, "NV12", {PixelCoding::kNv12}},
    {V4L2_PIX_FMT_MJPEG, "MJPEG", {PixelCoding::kMjpeg}},
    {V4L2_PIX_FMT_GREY, "GREY", {PixelCoding::kGrey}},
    {V4L2_PIX_FMT_RGB24, "RGB24", {PixelCoding::kRgb}},
    {V4L2_PIX_FMT_SRGGB8, "SRGGB8", Bayer(BayerOrder::kRggb, 8, false)},
    {V4L2_PIX_FMT_SGRBG8, "SGRBG8", Bayer(BayerOrder::kGrbg, 8, false)},
    {V4L2_PIX_FMT_SGBRG8, "SGBRG8", Bayer(BayerOrder::kGbrg, 8, false)},
    {V4L2_PIX_FMT_SBGGR8, "SBGGR8", Bayer(BayerOrder::kBggr, 8, false)},
    {V4L2_PIX_FMT_SRGGB10, "SRGGB10", Bayer(BayerOrder::kRggb, 10, false)},
    {V4L2_PIX_FMT_SGRBG10, "SGRBG10", Bayer(BayerOrder::kGrbg, 10, false)},
    {V4L2_PIX_FMT_SGBRG10, "SGBRG10", Bayer(BayerOrder::kGbrg, 10, false)},
    {V4L2_PIX_FMT_SBGGR10, "SBGGR10", Bayer(BayerOrder::kBggr, 10, false)},
    {V4L2_PIX_FMT_SRGGB10P, "SRGGB10P", Bayer(BayerOrder::kRggb, 10, true)},
    {V4L2_PIX_FMT_SGRBG10P, "SGRBG10P", Bayer(BayerOrder::kGrbg, 10, true)},
    {V4L2_PIX_FMT_SGBRG10P, "SGBRG10P", Bayer(BayerOrder::kGbrg, 10, true)},
    {V4L2_PIX_FMT_SBGGR10P, "SBGGR10P", Bayer(BayerOrder::kBggr, 10, true)},
    {V4L2_PIX_FMT_SRGGB12, "SRGGB12", Bayer(BayerOrder::kRggb, 12, false)},
    {V4L2_PIX_FMT_SGRBG12, "SGRBG12", Bayer(BayerOrder::kGrbg, 12, false)},
    {V4L2_PIX_FMT_SGBRG12, "SGBRG12", Bayer(BayerOrder::kGbrg, 12, false)},
    {V4L2_PIX_FMT_SBGGR12, "SBGGR12", Bayer(BayerOrder::kBggr, 12, false)},
    {V4L2_PIX_FMT_SRGGB12P, "SRGGB12P", Bayer(BayerOrder::kRggb, 12, true)},
    {V4L2_PIX_FMT_SGRBG12P, "SGRBG12P", Bayer(BayerOrder::kGrbg, 12, true)},
    {V4L2_PIX_FMT_SGBRG12P, "SGBRG12P", Bayer(BayerOrder::kGbrg, 12, true)},
    {V4L2_PIX_FMT_SBGGR12P, "SBGGR12P", Bayer(BayerOrder::kBggr, 12, true)},
};

const NamedFormat* Find(const PixelFormat& format) {
  const auto* found = std::find_if(std::begin(kFormats),
                                   std::end(kFormats),
                                   [&](const auto& entry) { return entry.format == format; });
  return found == std::end(kFormats) ? nullptr : found;
}

}  // namespace

std::optional<PixelFormat> PixelFormatOf(std::uint32_t fourcc) {
  // Motion-JPEG under its other code, which some webcams use.
  if (fourcc == V4L2_PIX_FMT_JPEG) return PixelFormat{PixelCoding::kMjpeg};
  for (const NamedFormat& entry : kFormats) {
    if (entry.fourcc == fourcc) return entry.format;
  }
  return std::nullopt;
}

std::uint32_t FourccOf(const PixelFormat& format) {
  const NamedFormat* entry = Find(format);
  return entry == nullptr ? 0 : entry->fourcc;
}

std::string NameOf(const PixelFormat& format) {
  const NamedFormat* entry = Find(format);
  return entry == nullptr ? "unknown" : entry->name;
}

std::optional<PixelFormat> PixelFormatNamed(std::string_view name) {
  const auto same = [](char a, char b) { return std::toupper(static_cast<unsigned char>(a)) == b; };
  for (const NamedFormat& entry : kFormats) {
    if (std::ranges::equal(name, std::string_view(entry.name), same)) return entry.format;
  }
  return std::nullopt;
}

}  // namespace pleinair
