// PNG and JPEG pictures to code values.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

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

}  // namespace pleinair
