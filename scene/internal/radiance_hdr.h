// Radiance pictures (RGBE, .hdr) to and from memory. By hand, because OpenCV's reader prints to the
// error stream and its writer rounds every value down, by 0.2 % on average.
//
// Source  Ward, Real Pixels, Graphics Gems II, 1991; the run-length form as Radiance writes it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "scene/image.h"

namespace pleinair {

// Throws std::runtime_error naming the file. Row order as the resolution line says; the EXPOSURE
// lines are divided out, so that values are what the scene had. XYZE pictures are refused.
RgbImage DecodeRadianceHdr(const std::filesystem::path& file, std::span<const std::byte> bytes);

// Each pixel to within 1/256 of its largest channel. Values must be finite, not negative, and below
// 2^126: throws std::invalid_argument naming the pixel.
std::vector<std::byte> EncodeRadianceHdr(const RgbImage& image);

}  // namespace pleinair
