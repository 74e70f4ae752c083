// Raw pictures as sensors lay them out, written from the definitions of the formats.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "datasets/camera/pixel_format.h"

namespace pleinair {

inline constexpr BayerOrder kAllOrders[] = {
    BayerOrder::kRggb, BayerOrder::kGrbg, BayerOrder::kGbrg, BayerOrder::kBggr};

// 0, 1, 2 for R, G, B.
inline int ColourAt(BayerOrder order, int x, int y) {
  constexpr int kColours[4][2][2] = {
      {{0, 1}, {1, 2}}, {{1, 0}, {2, 1}}, {{1, 2}, {0, 1}}, {{2, 1}, {1, 0}}};
  return kColours[static_cast<int>(order)][y % 2][x % 2];
}

inline int RawRowBytes(const PixelFormat& format, int width_px) {
  if (format.is_packed) return (width_px * format.bits + 7) / 8;
  return format.bits > 8 ? 2 * width_px : width_px;
}

// MIPI CSI-2, RAW10 and RAW12: the upper eight bits of 4 (or 2) pixels, a byte each, then one byte
// of their lower bits, the first pixel's lowest. Elsewhere a byte, or two of them, little-endian.
inline void PackRow(const PixelFormat& format, const std::vector<int>& codes, std::byte* out) {
  const auto byte = [](int value) { return static_cast<std::byte>(value & 0xff); };
  if (!format.is_packed) {
    for (const int code : codes) {
      *out++ = byte(code);
      if (format.bits > 8) *out++ = byte(code >> 8);
    }
    return;
  }
  const int lower_bits = format.bits - 8;
  const std::size_t group = lower_bits == 2 ? 4 : 2;
  for (std::size_t x = 0; x < codes.size(); x += group) {
    int lower = 0;
    for (std::size_t k = 0; k < group && x + k < codes.size(); ++k) {
      *out++ = byte(codes[x + k] >> lower_bits);
      lower |= (codes[x + k] & ((1 << lower_bits) - 1)) << (static_cast<int>(k) * lower_bits);
    }
    *out++ = byte(lower);
  }
}

// Of code_of(x, y), with rows `padding_bytes` apart that hold 0xff.
inline std::vector<std::byte> RawPicture(PictureLayout& layout,
                                         const std::function<int(int, int)>& code_of,
                                         int padding_bytes = 0) {
  layout.stride_bytes = RawRowBytes(layout.format, layout.width_px) + padding_bytes;
  const auto stride = static_cast<std::size_t>(layout.stride_bytes);
  std::vector<std::byte> bytes(stride * static_cast<std::size_t>(layout.height_px),
                               std::byte{0xff});
  std::vector<int> row(static_cast<std::size_t>(layout.width_px));
  for (int y = 0; y < layout.height_px; ++y) {
    for (int x = 0; x < layout.width_px; ++x) row[static_cast<std::size_t>(x)] = code_of(x, y);
    PackRow(layout.format, row, bytes.data() + stride * static_cast<std::size_t>(y));
  }
  return bytes;
}

}  // namespace pleinair
