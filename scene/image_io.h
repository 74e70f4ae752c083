// Image files: OpenEXR and Radiance HDR for light, PNG and JPEG for what a display shows.
#pragma once

#include <cstdint>
#include <filesystem>

#include "scene/image.h"

namespace pleinair {

// What a radiance image holds beside finite, non-negative values, in pixels.
struct ImageDefects {
  std::int64_t not_finite = 0;  // A channel is NaN or infinite.
  std::int64_t negative = 0;    // A channel is below zero (and all are finite).
  std::int64_t Count() const { return not_finite + negative; }
};

// Reads scene-linear RGB radiance from .exr or .hdr, values as stored, defects included.
//
// Throws  std::runtime_error naming the file and what was expected, when it cannot be read, is
//         truncated, is not of those formats, lacks R, G or B, or exceeds 2^28 pixels.
RgbImage ReadRadianceImage(const std::filesystem::path& file);

// Reads 8-bit RGB code values from .png or .jpg (grey is spread to three channels).
Rgb8Image ReadDisplayImage(const std::filesystem::path& file);

// Reads the first channel of an 8-bit .png or .jpg.
Gray8Image ReadMaskImage(const std::filesystem::path& file);

// Counts defects and mends them: a NaN or negative channel becomes 0, an infinite one (a sun that
// overflowed half float) the largest finite value of its channel in the image.
ImageDefects RepairRadiance(RgbImage& image);

enum class ExrPrecision { kHalf, kFloat };

// The writers go through a temporary file beside the target and rename it, so that a file under its
// final name is whole. Throw std::runtime_error naming the file when that fails. EXR is lossless
// (ZIP); kHalf refuses values beyond half float's 65504 with std::invalid_argument.
void WriteExr(const std::filesystem::path& file, const RgbImage& image, ExrPrecision precision);
void WriteHdr(const std::filesystem::path& file, const RgbImage& image);
void WritePng(const std::filesystem::path& file, const Rgb8Image& image);
void WritePng(const std::filesystem::path& file, const Gray8Image& image);

}  // namespace pleinair
