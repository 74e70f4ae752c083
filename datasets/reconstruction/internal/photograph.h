// Photographs of a reconstruction: what their EXIF data say, and their pixels.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "calib/exif_exposure.h"
#include "calib/exif_place.h"
#include "scene/utc_time.h"

namespace pleinair {

struct Photograph {
  std::filesystem::path file;
  ExifPlace place;
  ExifExposure exposure;
  std::optional<UtcTime> time;  // As far as EXIF data and the offset say it.
};

// When a picture was taken: by its EXIF time and the offset that it states, or else `utc_offset`,
// or else the offset that the receiver's UTC implies; or that UTC. None: nothing says it.
std::optional<UtcTime> TimeOf(const std::filesystem::path& file,
                              const ExifPlace& place,
                              std::optional<std::chrono::minutes> utc_offset);

// None where there is no such file.
std::optional<Photograph> FindPhotograph(const std::filesystem::path& folder,
                                         const std::string& name,
                                         std::optional<std::chrono::minutes> utc_offset);

}  // namespace pleinair
