// What a JPEG's EXIF data say of its lens.
#pragma once

#include <filesystem>
#include <optional>

namespace pleinair {

// The focal length that gives the same view on 35 mm film, whose diagonal is 43.27 mm: nominal, a
// whole number of millimetres, and of the camera's own crop. None where the file is no JPEG or does
// not say.
std::optional<double> ReadExifFocalLength35mm(const std::filesystem::path& file);

}  // namespace pleinair
