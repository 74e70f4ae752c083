#include "apps/camera_stand_in/shim/renderer.h"

#include <linux/videodev2.h>
#include <turbojpeg.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "apps/camera_stand_in/shim/controls.h"  // RawBits, BlackLevel
#include "scene/srgb.h"

namespace pleinair::stand_in {
namespace {

constexpr PixelFormatInfo kPixelFormats[] = {
    {V4L2_PIX_FMT_YUYV, "YUYV 4:2:2"},
    {V4L2_PIX_FMT_NV12, "Y/UV 4:2:0"},
    {V4L2_PIX_FMT_MJPEG, "Motion-JPEG"},
    {V4L2_PIX_FMT_GREY, "8-bit Greyscale"},
    {V4L2_PIX_FMT_RGB24, "24-bit RGB 8-8-8"},
    {V4L2_PIX_FMT_SRGGB8, "8-bit Bayer RGRG/GBGB"},
    {V4L2_PIX_FMT_SRGGB10, "10-bit Bayer RGRG/GBGB"},
    {V4L2_PIX_FMT_SRGGB10P, "10-bit Bayer RGRG/GBGB Packed"},
    {V4L2_PIX_FMT_SRGGB12, "12-bit Bayer RGRG/GBGB"},
    {V4L2_PIX_FMT_SRGGB12P, "12-bit Bayer RGRG/GBGB Packed"},
};

constexpr int kJpegQuality = 95;
constexpr int kJpegSubsampling = TJSAMP_422;  // As most webcams.

std::size_t PixelCount(Size size) {
  return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
}

// The value of a half float's 16 bits; infinity and NaN, which no picture of ours has, as 0.
float HalfValue(std::uint32_t bits) {
  const int exponent = static_cast<int>((bits >> 10) & 31u);
  const int mantissa = static_cast<int>(bits & 1023u);
  if (exponent == 31) return 0.0f;
  const float magnitude = exponent == 0
                              ? std::ldexp(static_cast<float>(mantissa), -24)
                              : std::ldexp(static_cast<float>(mantissa + 1024), exponent - 25);
  return (bits & 0x8000u) != 0 ? -magnitude : magnitude;
}

struct Tap {
  int first = 0;
  std::vector<float> weights;
};

// Means over each new pixel's extent where pixels become fewer, linear interpolation where more.
std::vector<Tap> TapsOf(int from, int to) {
  const double step = static_cast<double>(from) / to;
  const double radius = std::max(step, 1.0) / 2.0;
  std::vector<Tap> taps(static_cast<std::size_t>(to));
  for (int i = 0; i < to; ++i) {
    Tap& tap = taps[static_cast<std::size_t>(i)];
    const double low = std::clamp((i + 0.5) * step - radius, 0.0, from - 2.0 * radius);
    const double high = low + 2.0 * radius;
    tap.first = std::min(static_cast<int>(low), from - 1);
    for (int k = tap.first; k < std::min(from, static_cast<int>(std::ceil(high))); ++k) {
      tap.weights.push_back(static_cast<float>(
          (std::min(high, k + 1.0) - std::max(low, static_cast<double>(k))) / (2.0 * radius)));
    }
  }
  return taps;
}

void Resample(const std::vector<std::uint16_t>& from,
              Size from_size,
              std::vector<std::uint16_t>& to,
              Size to_size) {
  const std::vector<Tap> columns = TapsOf(from_size.width, to_size.width);
  const std::vector<Tap> rows = TapsOf(from_size.height, to_size.height);
  const std::size_t from_line = static_cast<std::size_t>(from_size.width) * 3;
  std::vector<float> line(from_line);
  to.resize(PixelCount(to_size) * 3);
  std::uint16_t* out = to.data();
  for (const Tap& row : rows) {
    std::fill(line.begin(), line.end(), 0.0f);
    for (std::size_t k = 0; k < row.weights.size(); ++k) {
      const std::uint16_t* in = &from[(static_cast<std::size_t>(row.first) + k) * from_line];
      for (std::size_t i = 0; i < from_line; ++i) line[i] += row.weights[k] * in[i];
    }
    for (const Tap& column : columns) {
      float sum[3] = {0.5f, 0.5f, 0.5f};
      const float* in = &line[static_cast<std::size_t>(column.first) * 3];
      for (const float weight : column.weights) {
        for (int c = 0; c < 3; ++c) sum[c] += weight * *in++;
      }
      for (const float value : sum) *out++ = static_cast<std::uint16_t>(value);
    }
  }
}

// Y'CbCr of 8-bit R'G'B' in fixed point of 16 bits.
class YcbcrMatrix {
 public:
  YcbcrMatrix(std::uint32_t encoding, std::uint32_t quantization) {
    double red = 0.299, blue = 0.114;  // BT.601.
    if (encoding == V4L2_YCBCR_ENC_709) red = 0.2126, blue = 0.0722;
    if (encoding == V4L2_YCBCR_ENC_BT2020) red = 0.2627, blue = 0.0593;
    const bool is_full = quantization == V4L2_QUANTIZATION_FULL_RANGE;
    const double luma = is_full ? 1.0 : 219.0 / 255.0;
    const double chroma = is_full ? 1.0 : 224.0 / 255.0;
    const double weights[3] = {red, 1.0 - red - blue, blue};
    for (int c = 0; c < 3; ++c) {
      y_[c] = Fixed(luma * weights[c]);
      cb_[c] = Fixed(chroma * ((c == 2 ? 1.0 : 0.0) - weights[c]) / (2.0 * (1.0 - blue)));
      cr_[c] = Fixed(chroma * ((c == 0 ? 1.0 : 0.0) - weights[c]) / (2.0 * (1.0 - red)));
    }
    offset_ = is_full ? 0 : 16;
  }

  std::uint8_t Y(const std::uint16_t* rgb) const {
    return Code(y_, {rgb[0], rgb[1], rgb[2]}, 1, offset_);
  }
  // Chroma from the sums over `count` pixels.
  std::uint8_t Cb(int r, int g, int b, int count) const { return Code(cb_, {r, g, b}, count, 128); }
  std::uint8_t Cr(int r, int g, int b, int count) const { return Code(cr_, {r, g, b}, count, 128); }

 private:
  static int Fixed(double value) { return static_cast<int>(std::lround(value * 65536.0)); }
  static std::uint8_t Code(const int (&weights)[3], const int (&rgb)[3], int count, int offset) {
    const int sum = (weights[0] * rgb[0] + weights[1] * rgb[1] + weights[2] * rgb[2]) / count;
    return static_cast<std::uint8_t>(std::clamp(((sum + 32768) >> 16) + offset, 0, 255));
  }
  int y_[3], cb_[3], cr_[3];
  int offset_ = 0;
};

void WriteYuyv(const std::vector<std::uint16_t>& rgb,
               const YcbcrMatrix& matrix,
               std::uint8_t* out) {
  for (std::size_t i = 0; i + 5 < rgb.size(); i += 6) {
    const std::uint16_t* p = &rgb[i];
    *out++ = matrix.Y(p);
    *out++ = matrix.Cb(p[0] + p[3], p[1] + p[4], p[2] + p[5], 2);
    *out++ = matrix.Y(p + 3);
    *out++ = matrix.Cr(p[0] + p[3], p[1] + p[4], p[2] + p[5], 2);
  }
}

void WriteNv12(const std::vector<std::uint16_t>& rgb,
               Size size,
               const YcbcrMatrix& matrix,
               std::uint8_t* out) {
  for (std::size_t i = 0; i < rgb.size(); i += 3) *out++ = matrix.Y(&rgb[i]);
  const std::size_t line = static_cast<std::size_t>(size.width) * 3;
  for (int y = 0; y < size.height; y += 2) {
    const std::uint16_t* p = &rgb[static_cast<std::size_t>(y) * line];
    for (int x = 0; x < size.width; x += 2, p += 6) {
      int sum[3];
      for (int c = 0; c < 3; ++c) sum[c] = p[c] + p[c + 3] + p[line + c] + p[line + c + 3];
      *out++ = matrix.Cb(sum[0], sum[1], sum[2], 4);
      *out++ = matrix.Cr(sum[0], sum[1], sum[2], 4);
    }
  }
}

// RGRG/GBGB, in place: one value a pixel.
void Mosaic(std::vector<std::uint16_t>& rgb, Size size) {
  std::size_t i = 0;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x, ++i) {
      rgb[i] = rgb[3 * i + static_cast<std::size_t>((y & 1) + (x & 1))];
    }
  }
}

// MIPI packing: the high 8 bits of each of a group's values, then their low bits together.
void WritePacked(const std::uint16_t* values, std::size_t count, int bits, std::uint8_t* out) {
  const int low_bits = bits - 8;
  const std::size_t group = static_cast<std::size_t>(8 / low_bits);
  for (std::size_t i = 0; i < count; i += group) {
    unsigned low = 0;
    for (std::size_t k = 0; k < group; ++k) {
      *out++ = static_cast<std::uint8_t>(values[i + k] >> low_bits);
      low |= (values[i + k] & ((1u << low_bits) - 1u)) << (low_bits * static_cast<int>(k));
    }
    *out++ = static_cast<std::uint8_t>(low);
  }
}

bool IsPacked(std::uint32_t pixel_format) {
  return pixel_format == V4L2_PIX_FMT_SRGGB10P || pixel_format == V4L2_PIX_FMT_SRGGB12P;
}

}  // namespace

std::span<const PixelFormatInfo> PixelFormats() { return kPixelFormats; }

bool HasPixelFormat(std::uint32_t pixel_format) {
  return std::any_of(std::begin(kPixelFormats), std::end(kPixelFormats), [&](const auto& info) {
    return info.pixel_format == pixel_format;
  });
}

bool Fits(std::uint32_t pixel_format, Size size) {
  switch (pixel_format) {
    case V4L2_PIX_FMT_MJPEG:
    case V4L2_PIX_FMT_GREY:
    case V4L2_PIX_FMT_RGB24:
      return true;
    case V4L2_PIX_FMT_YUYV:
      return size.width % 2 == 0;
    case V4L2_PIX_FMT_SRGGB10P:
      return size.width % 4 == 0 && size.height % 2 == 0;
    default:
      return size.width % 2 == 0 && size.height % 2 == 0;
  }
}

std::size_t BytesPerLine(const Format& format) {
  const auto width = static_cast<std::size_t>(format.size.width);
  switch (format.pixel_format) {
    case V4L2_PIX_FMT_MJPEG:
      return 0;
    case V4L2_PIX_FMT_RGB24:
      return width * 3;
    case V4L2_PIX_FMT_YUYV:
    case V4L2_PIX_FMT_SRGGB10:
    case V4L2_PIX_FMT_SRGGB12:
      return width * 2;
    case V4L2_PIX_FMT_SRGGB10P:
      return width * 5 / 4;
    case V4L2_PIX_FMT_SRGGB12P:
      return width * 3 / 2;
    default:
      return width;
  }
}

std::size_t BufferBytes(const Format& format) {
  if (format.pixel_format == V4L2_PIX_FMT_MJPEG) {
    return tjBufSize(format.size.width, format.size.height, kJpegSubsampling);
  }
  const std::size_t bytes = BytesPerLine(format) * static_cast<std::size_t>(format.size.height);
  return format.pixel_format == V4L2_PIX_FMT_NV12 ? bytes * 3 / 2 : bytes;
}

Renderer::~Renderer() {
  if (jpeg_ != nullptr) tjDestroy(jpeg_);
}

const Renderer::Tables& Renderer::TablesFor(bool from_linear, int bits, const Gains& gains) {
  if (!tables_.value_of[0].empty() && tables_.from_linear == from_linear && tables_.bits == bits &&
      tables_.gains == gains) {
    return tables_;
  }
  tables_ = {from_linear, bits, gains, {}};
  const double white = bits == 0 ? 255.0 : std::ldexp(1.0, bits) - 1.0;
  const double black = bits == 0 ? 0.0 : BlackLevel(bits);
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<std::uint16_t>& values = tables_.value_of[c];
    values.resize(from_linear ? 65536 : 256);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double stored = from_linear
                                ? static_cast<double>(HalfValue(static_cast<std::uint32_t>(i)))
                                : LinearFromSrgb(static_cast<double>(i) / 255.0);
      const double light = std::clamp(stored * static_cast<double>(gains[c]), 0.0, 1.0);
      const double share = bits == 0 ? SrgbFromLinear(light) : light;
      values[i] = static_cast<std::uint16_t>(std::lround(black + share * (white - black)));
    }
  }
  return tables_;
}

bool Renderer::Read(std::int64_t offset, std::size_t bytes) {
  stored_.resize(bytes);
  for (std::size_t done = 0; done < bytes;) {
    const ssize_t got = pread(pictures_fd_,
                              &stored_[done],
                              bytes - done,
                              static_cast<off_t>(offset + static_cast<std::int64_t>(done)));
    if (got <= 0) return false;
    done += static_cast<std::size_t>(got);
  }
  return true;
}

bool Renderer::Fill(const Shot& shot, Size size, int bits) {
  const PictureLevel* level = &state_.levels[0];
  for (int i = 0; i < state_.level_count; ++i) {
    if (state_.levels[i].size == size) level = &state_.levels[i];
  }
  const bool is_plain = bits == 0 && shot.gains == Gains{1.0f, 1.0f, 1.0f};
  const bool from_linear = state_.has_linear && !is_plain && (bits != 0 || state_.codes_follow);
  const std::size_t samples = PixelCount(level->size) * 3;
  const std::size_t bytes = samples * (from_linear ? 2 : 1);
  const std::int64_t first = from_linear ? level->linear_offset : level->codes_offset;
  if (!Read(first + shot.picture * static_cast<std::int64_t>(bytes), bytes)) return false;

  std::vector<std::uint16_t>& rgb = level->size == size ? rgb_ : level_rgb_;
  rgb.resize(samples);
  if (is_plain) {
    std::copy(stored_.begin(), stored_.end(), rgb.begin());
  } else {
    const Tables& tables = TablesFor(from_linear, bits, shot.gains);
    for (std::size_t i = 0; i < samples; i += 3) {
      for (std::size_t c = 0; c < 3; ++c) {
        std::uint16_t sample = 0;
        from_linear ? static_cast<void>(std::memcpy(&sample, &stored_[2 * (i + c)], 2))
                    : static_cast<void>(sample = stored_[i + c]);
        rgb[i + c] = tables.value_of[c][sample];
      }
    }
  }
  if (level->size != size) Resample(level_rgb_, level->size, rgb_, size);
  return true;
}

std::size_t Renderer::Compress(Size size, std::span<std::uint8_t> out) {
  if (jpeg_ == nullptr) jpeg_ = tjInitCompress();
  stored_.assign(rgb_.begin(), rgb_.end());
  unsigned char* to = out.data();
  unsigned long bytes = out.size();
  const int failed = tjCompress2(jpeg_,
                                 stored_.data(),
                                 size.width,
                                 0,
                                 size.height,
                                 TJPF_RGB,
                                 &to,
                                 &bytes,
                                 kJpegSubsampling,
                                 kJpegQuality,
                                 TJFLAG_NOREALLOC);
  return failed == 0 ? bytes : 0;
}

std::size_t Renderer::Render(const Shot& shot, const Format& format, std::span<std::uint8_t> out) {
  const int bits = RawBits(format.pixel_format);
  const std::size_t bytes = BufferBytes(format);
  if (out.size() < bytes || !Fill(shot, format.size, bits)) return 0;
  const std::size_t pixels = PixelCount(format.size);
  switch (format.pixel_format) {
    case V4L2_PIX_FMT_MJPEG:
      return Compress(format.size, out);
    case V4L2_PIX_FMT_RGB24:
      std::copy(rgb_.begin(), rgb_.end(), out.begin());
      return bytes;
    case V4L2_PIX_FMT_GREY: {
      const YcbcrMatrix matrix(V4L2_YCBCR_ENC_601, V4L2_QUANTIZATION_FULL_RANGE);
      for (std::size_t i = 0; i < pixels; ++i) out[i] = matrix.Y(&rgb_[3 * i]);
      return bytes;
    }
    case V4L2_PIX_FMT_YUYV:
      WriteYuyv(rgb_, {state_.ycbcr_encoding, state_.quantization}, out.data());
      return bytes;
    case V4L2_PIX_FMT_NV12:
      WriteNv12(rgb_, format.size, {state_.ycbcr_encoding, state_.quantization}, out.data());
      return bytes;
    default:
      break;
  }
  Mosaic(rgb_, format.size);
  if (bits == 8) {
    std::copy_n(rgb_.begin(), pixels, out.begin());
  } else if (IsPacked(format.pixel_format)) {
    WritePacked(rgb_.data(), pixels, bits, out.data());
  } else {
    std::memcpy(out.data(), rgb_.data(), pixels * sizeof(std::uint16_t));
  }
  return bytes;
}

}  // namespace pleinair::stand_in
