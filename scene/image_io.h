// Image files: OpenEXR and Radiance HDR for light, PNG and JPEG for what a display shows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "scene/image.h"

namespace pleinair {

// Defects of a radiance image: counts of pixels.
struct ImageDefects {
  std::int64_t not_finite = 0;  // A channel is NaN or infinite.
  std::int64_t negative = 0;    // A channel is below zero (and all are finite).
  std::int64_t Count() const { return not_finite + negative; }
};

// The format is read from a file's content; names and their endings are ignored.

// Whether a file holds scene-linear light (OpenEXR or Radiance HDR). Throws std::runtime_error
// naming the file when it is none, or empty.
bool HoldsRadiance(const std::filesystem::path& file);

// Describes a file's content for messages: "a JPEG picture", "an MP4 video", "text". Throws as
// HoldsRadiance.
std::string DescribeContent(const std::filesystem::path& file);

// Reads scene-linear RGB radiance from OpenEXR or Radiance HDR, values as stored, defects included.
// EXR: any pixel type and compression, the display window of the first part, which the data window
// must cover. HDR: EXPOSURE lines divided out.
//
// Throws  std::runtime_error naming the file and what was expected, when it cannot be read, is
//         truncated, is not of those formats, lacks R, G or B, or exceeds 2^28 pixels.
RgbImage ReadRadianceImage(const std::filesystem::path& file);

// Reads 8-bit RGB code values from PNG or JPEG (grey is spread to three channels, alpha left out).
// Pixels stay where the file stores them: an EXIF orientation is not applied, because a camera's
// intrinsics refer to the sensor's rows and columns. Throws as above, also for 16-bit files.
Rgb8Image ReadDisplayImage(const std::filesystem::path& file);

// Reads the first channel of an 8-bit PNG or JPEG.
Gray8Image ReadMaskImage(const std::filesystem::path& file);

// Counts the defects of an image.
ImageDefects DefectsOf(const RgbImage& image);

// Counts defects and repairs them. A NaN or negative channel becomes 0, also -infinity. +infinity
// (a sun that overflowed half float) becomes the largest finite value of its channel in the image.
ImageDefects RepairRadiance(RgbImage& image);

enum class ExrPrecision { kHalf, kFloat };

// The writers go through a temporary file beside the target and rename it, so that a file under its
// final name is complete. Throw std::runtime_error naming the file when that fails. EXR is lossless
// (ZIP). kHalf refuses finite values beyond half float's 65504 with std::invalid_argument, and
// keeps NaN and infinities, so that values read from half floats are written back bit for bit. HDR
// holds each pixel to 1/256 of its largest channel, and refuses what is not finite, negative or
// beyond 2^126.
void WriteExr(const std::filesystem::path& file, const RgbImage& image, ExrPrecision precision);
void WriteHdr(const std::filesystem::path& file, const RgbImage& image);
void WritePng(const std::filesystem::path& file, const Rgb8Image& image);
void WritePng(const std::filesystem::path& file, const Gray8Image& image);
// `quality` from 0 to 100, as the JPEG library counts it. Throws std::invalid_argument beyond.
void WriteJpeg(const std::filesystem::path& file, const Rgb8Image& image, int quality);
// What WriteJpeg writes, for a file of another kind. Throws std::runtime_error, in one line, where
// the picture is too large for it.
std::vector<std::byte> JpegOf(const Rgb8Image& image, int quality);

}  // namespace pleinair
