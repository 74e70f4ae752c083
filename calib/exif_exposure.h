// Exposure settings from a JPEG's EXIF data.
#pragma once

#include <filesystem>
#include <optional>

namespace pleinair {

// Absent values are none.
struct ExifExposure {
  std::optional<double> exposure_s;
  std::optional<double> iso;
  std::optional<double> f_number;

  // t ISO / N^2, missing values left out (it cancels in a bracket that changes only the time);
  // none without an exposure time.
  std::optional<double> RelativeExposure() const;
};

// Empty where the file is no JPEG, has no EXIF, or impossible values. Shutter times are
// nominal: off by some per cent.
ExifExposure ReadExifExposure(const std::filesystem::path& file);

}  // namespace pleinair
