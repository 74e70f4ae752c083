// Checks of an image file's own data before a decoder allocates or prints anything.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace pleinair {

inline constexpr std::int64_t kMaxImagePixels = std::int64_t{1} << 28;

// No picture of ours is packed more tightly: a flat PNG of one bit has 8256 pixels in a byte
// (deflate packs 1032 to 1), an OpenEXR one of DWA 11000.
inline constexpr std::int64_t kMaxPixelsInAByte = std::int64_t{1} << 14;

// Throws std::runtime_error naming the file unless 1 <= width * height <= kMaxImagePixels, and the
// file's bytes can hold that many: before there is memory for them.
void RequireImageSize(const std::filesystem::path& file,
                      std::int64_t width,
                      std::int64_t height,
                      std::uintmax_t file_bytes);

// The text without line breaks and trailing blanks: libraries' messages have both.
std::string OneLine(std::string_view text);

// Walks a PNG's chunks: signature, size, depth, check sums, end. Throws std::runtime_error naming
// the file when one is wrong. Returns the picture without what its codes do not depend on: gamma
// and colour profiles, which libpng would apply, and texts.
std::vector<std::byte> CheckedPng(const std::filesystem::path& file,
                                  std::span<const std::byte> bytes);

// Walks a JPEG's segments to its end marker. Throws std::runtime_error naming the file when that is
// missing: libjpeg would fill the rest of a truncated picture with grey.
void CheckJpeg(const std::filesystem::path& file, std::span<const std::byte> bytes);

}  // namespace pleinair
