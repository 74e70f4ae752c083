// What a JPEG's EXIF data say of its exposure.
#pragma once

#include <filesystem>
#include <optional>

namespace pleinair {

struct ExifExposure {
  std::optional<double> exposure_s;
  std::optional<double> iso;
  std::optional<double> f_number;

  // t ISO / N^2, what is not told left out (it cancels in a bracket that changes only the time);
  // none without an exposure time.
  std::optional<double> RelativeExposure() const;
};

// Nothing told where the file is no JPEG, has no EXIF, or values that cannot be. Shutter times are
// nominal: off by some per cent.
ExifExposure ReadExifExposure(const std::filesystem::path& file);

}  // namespace pleinair
