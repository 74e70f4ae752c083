// Place and orientation of the camera from a JPEG's EXIF data.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace pleinair {

// Absent values are none.
struct ExifPlace {
  // WGS84, degrees, north and east positive; both or none.
  std::optional<double> latitude_deg;
  std::optional<double> longitude_deg;
  std::optional<double> altitude_m;        // Over the sea, as receivers state it.
  std::optional<double> position_sigma_m;  // Horizontal, where the receiver states one.
  // Azimuth of the view, from true north, by the camera's compass.
  std::optional<double> heading_deg;
  std::string utc;  // ISO 8601 with Z, the receiver's clock; empty: none.
  // Orientation in which the picture is to be shown, 1 to 8 as in EXIF.
  std::optional<int> orientation;
};

// Empty where the file is no JPEG, has no EXIF data, or impossible values.
ExifPlace ReadExifPlace(const std::filesystem::path& file);

}  // namespace pleinair
