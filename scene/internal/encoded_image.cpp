#include "scene/internal/encoded_image.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "scene/whole_file.h"

namespace pleinair {
namespace {

// Big-endian number of `count` bytes.
std::uint32_t NumberAt(std::span<const std::byte> bytes, std::size_t offset, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    value = value << 8 | std::to_integer<std::uint32_t>(bytes[offset + i]);
  }
  return value;
}

// CRC-32 as PNG uses it (ISO 3309).
std::uint32_t Crc32(std::span<const std::byte> bytes) {
  static const std::array<std::uint32_t, 256> table = [] {
    std::array<std::uint32_t, 256> entries{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t value = i;
      for (int bit = 0; bit < 8; ++bit) {
        value = (value & 1u) != 0 ? 0xedb88320u ^ (value >> 1) : value >> 1;
      }
      entries[i] = value;
    }
    return entries;
  }();
  std::uint32_t crc = 0xffffffffu;
  for (const std::byte byte : bytes) {
    crc = table[(crc ^ std::to_integer<std::uint32_t>(byte)) & 0xffu] ^ (crc >> 8);
  }
  return ~crc;
}

constexpr std::uint32_t ChunkType(const char (&name)[5]) {
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(name[i]);
  return value;
}

}  // namespace

void RequireImageSize(const std::filesystem::path& file,
                      std::int64_t width,
                      std::int64_t height,
                      std::uintmax_t file_bytes) {
  const std::string size =
      "image size " + std::to_string(width) + "x" + std::to_string(height) + ": expected ";
  if (width < 1 || height < 1 || width > kMaxImagePixels / height) {
    RefuseFile(file, size + "at least 1x1 and at most 2^28 pixels");
  }
  if (static_cast<std::uintmax_t>(width * height / kMaxPixelsInAByte) > file_bytes) {
    RefuseFile(file,
               size + "no more pixels than " + std::to_string(file_bytes) + " bytes can hold");
  }
}

std::string OneLine(std::string_view text) {
  std::string line(text);
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == '\n' || c == '\r' || c == '\t'; }, ' ');
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

std::vector<std::byte> CheckedPng(const std::filesystem::path& file,
                                  std::span<const std::byte> bytes) {
  constexpr std::array<unsigned char, 8> kSignature = {0x89, 'P', 'N', 'G', 13, 10, 26, 10};
  const bool signed_as_png =
      bytes.size() >= kSignature.size() &&
      std::equal(kSignature.begin(), kSignature.end(), bytes.begin(), [](auto a, std::byte b) {
        return std::byte{a} == b;
      });
  if (!signed_as_png) RefuseFile(file, "not a PNG image");

  std::vector<std::byte> kept(bytes.begin(), bytes.begin() + kSignature.size());
  bool first = true;
  for (std::size_t offset = kSignature.size();;) {
    // length (4), type (4), data, check sum (4)
    if (bytes.size() - offset < 12) RefuseFile(file, "the PNG image is truncated");
    const std::size_t length = NumberAt(bytes, offset, 4);
    if (bytes.size() - offset - 12 < length) RefuseFile(file, "the PNG image is truncated");
    const std::uint32_t type = NumberAt(bytes, offset + 4, 4);
    if (Crc32(bytes.subspan(offset + 4, length + 4)) != NumberAt(bytes, offset + 8 + length, 4)) {
      RefuseFile(file,
                 "the PNG image is damaged (check sum at byte " + std::to_string(offset) + ")");
    }
    if (first) {
      if (type != ChunkType("IHDR") || length < 13) RefuseFile(file, "not a PNG image");
      RequireImageSize(
          file, NumberAt(bytes, offset + 8, 4), NumberAt(bytes, offset + 12, 4), bytes.size());
      const std::uint32_t depth = NumberAt(bytes, offset + 16, 1);
      if (depth > 8) {
        RefuseFile(file, std::to_string(depth) + " bits a channel: expected 8");
      }
      first = false;
    }
    const std::span<const std::byte> chunk = bytes.subspan(offset, length + 12);
    const bool is_critical = (type & 0x20000000u) == 0;  // Its first letter is a capital.
    if (is_critical || type == ChunkType("tRNS")) {
      kept.insert(kept.end(), chunk.begin(), chunk.end());
    }
    if (type == ChunkType("IEND")) return kept;
    offset += chunk.size();
  }
}

void CheckJpeg(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  if (bytes.size() < 4 || NumberAt(bytes, 0, 2) != 0xffd8u) RefuseFile(file, "not a JPEG image");
  const auto truncated = [&]() { RefuseFile(file, "the JPEG image is truncated"); };
  std::size_t offset = 2;
  while (true) {
    // To the next marker: over a scan's data, in which 0xff is followed by 0 or a restart marker.
    std::uint32_t marker = 0;
    while (true) {
      while (offset < bytes.size() && bytes[offset] != std::byte{0xff}) ++offset;
      while (offset < bytes.size() && bytes[offset] == std::byte{0xff}) ++offset;
      if (offset >= bytes.size()) truncated();
      marker = NumberAt(bytes, offset++, 1);
      const bool inside_scan = marker == 0 || (marker >= 0xd0u && marker <= 0xd7u);
      if (!inside_scan) break;
    }
    if (marker == 0xd9u) return;                       // End of image.
    if (marker == 0x01u || marker == 0xd8u) continue;  // Markers without a segment.
    if (bytes.size() - offset < 2) truncated();
    const std::size_t length = NumberAt(bytes, offset, 2);
    if (length < 2 || bytes.size() - offset < length) truncated();
    // Start of frame: C0..CF except for the tables DHT, JPG and DAC.
    const bool frame =
        marker >= 0xc0u && marker <= 0xcfu && marker != 0xc4u && marker != 0xc8u && marker != 0xccu;
    if (frame && length >= 8) {
      RequireImageSize(
          file, NumberAt(bytes, offset + 5, 2), NumberAt(bytes, offset + 3, 2), bytes.size());
      const std::uint32_t depth = NumberAt(bytes, offset + 2, 1);
      if (depth != 8) RefuseFile(file, std::to_string(depth) + " bits a channel: expected 8");
    }
    offset += length;
  }
}

}  // namespace pleinair
