// OpenEXR images to and from memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "scene/image_io.h"

namespace pleinair {

RgbImage ReadExr(const std::filesystem::path& file);

std::vector<std::byte> EncodeExr(const RgbImage& image, ExrPrecision precision);

}  // namespace pleinair
