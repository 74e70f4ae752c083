// PNG and JPEG pictures to code values, and back.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include <glm/vec4.hpp>

#include "scene/image.h"

namespace pleinair {

// RGB and alpha, which is 255 where the picture has none; grey is spread to three channels. Pixels
// stay where the picture stores them (an EXIF orientation is not applied), and codes are as stored
// (a PNG's gamma and colour profile are not applied).
//
// Throws   std::runtime_error naming `file`, in one line, when the bytes are neither format, are
//          truncated or damaged, have more than 8 bits a channel, are CMYK, or exceed
//          kMaxImagePixels. A JPEG's extraneous bytes between segments are no damage.
// Prints   nothing: libpng and libjpeg by themselves write warnings to the error stream.
Image<glm::u8vec4> DecodePicture(const std::filesystem::path& file,
                                 std::span<const std::byte> bytes);

// Packed fast rather than small: a camera's pictures are written as they come. Throws
// std::runtime_error, in one line, where the picture is too large for the format.
std::vector<std::byte> EncodePng(const Rgb8Image& image);
std::vector<std::byte> EncodePng(const Gray8Image& image);
// Colours at half the resolution. `quality` from 0 to 100. Throws as EncodePng.
std::vector<std::byte> EncodeJpeg(const Rgb8Image& image, int quality);

}  // namespace pleinair
