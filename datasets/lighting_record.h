// lighting.jsonl, as `pleinair run` writes it, read back.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/lighting.h"
#include "scene/utc_time.h"

namespace pleinair {

// Sun and sky of one line, in the run's radiance units times sr: sun normal to the beam, sky
// horizontal.
struct RecordedLight {
  std::optional<glm::dvec3> sun_direction_enu;  // Unit.
  std::optional<glm::dvec3> sun_irradiance_rgb;
  std::optional<glm::dvec3> sky_irradiance_rgb;
  std::optional<glm::dvec3> sun_irradiance_stddev_rgb;
  std::optional<glm::dvec3> sky_irradiance_stddev_rgb;
  LightUnits units = LightUnits::kAbsolute;
};

// One line of lighting.jsonl.
struct LightingRecord {
  int frame = 0;
  std::optional<UtcTime> time;       // As the line's `time_utc` states it.
  std::optional<std::string> error;  // The reason of a failed frame; then there is no light.
  RecordedLight light;
  std::optional<RecordedLight> raw;             // Before the filter over time.
  std::map<std::string, glm::dvec3> sky_shape;  // Share of each shape; empty where not given.
  // Image with the sky's shape; absolute, or relative to the working folder.
  std::optional<std::filesystem::path> sky_image;
  std::optional<bool> sun_observable;
};

// Returns one entry for each line, in the file's order. sky_image is relative to the file. Keys
// that are not in the structs above are ignored; null is a value that the source does not know.
// Throws std::runtime_error naming file, line, key and what was expected; for a frame given twice.
std::vector<LightingRecord> ReadLightingRecords(const std::filesystem::path& file);

}  // namespace pleinair
