// Where a JPEG's EXIF data say that it was taken, and how the camera was held.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace pleinair {

struct ExifPlace {
  // WGS84, degrees, north and east positive; both or none.
  std::optional<double> latitude_deg;
  std::optional<double> longitude_deg;
  std::optional<double> altitude_m;        // Over the sea, as receivers state it.
  std::optional<double> position_sigma_m;  // Horizontal, where the receiver states one.
  // Azimuth that the camera looked to, from true north, by its compass.
  std::optional<double> heading_deg;
  std::string utc;  // ISO 8601 with Z, the receiver's clock; empty: none.
  // Which way up the picture is to be shown, 1 to 8 as EXIF counts; 1 where it is not said.
  int orientation = 1;
};

// Empty where the file is no JPEG, has no EXIF data, or impossible values.
ExifPlace ReadExifPlace(const std::filesystem::path& file);

}  // namespace pleinair
