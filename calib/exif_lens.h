// The focal length from a JPEG's EXIF data.
#pragma once

#include <filesystem>
#include <optional>

namespace pleinair {

// The focal length that gives the same view on 35 mm film, whose diagonal is 43.27 mm: nominal, an
// integer number of millimetres, and for the camera's own crop. None where the file is no JPEG or
// does not state it.
std::optional<double> ReadExifFocalLength35mm(const std::filesystem::path& file);

}  // namespace pleinair
