// The time of a picture from a JPEG's EXIF data.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace pleinair {

// Texts as in the file.
struct ExifTime {
  std::string local_time;  // ISO 8601, the camera's clock: "2005-06-21T11:50:00.25".
  std::string utc_offset;  // "+02:00", or empty: cameras before 2016 state none.
};

// None where the file is no JPEG, or its EXIF data have no time or an impossible one. The texts'
// numbers may still be out of range.
std::optional<ExifTime> ReadExifTime(const std::filesystem::path& file);

}  // namespace pleinair
