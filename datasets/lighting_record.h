// lighting.jsonl, as `pleinair run` writes it, read back.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace pleinair {

struct RecordedLight {
  std::optional<glm::dvec3> sun_direction_enu;  // Unit.
  std::optional<glm::dvec3> sun_irradiance_rgb;
  std::optional<glm::dvec3> sky_irradiance_rgb;
  std::optional<glm::dvec3> sun_irradiance_stddev_rgb;
  std::optional<glm::dvec3> sky_irradiance_stddev_rgb;
};

struct LightingRecord {
  int frame = 0;
  std::optional<std::string> error;  // Of a frame that failed; then there is no light.
  RecordedLight light;
  std::optional<RecordedLight> raw;                // Before the filter over time.
  std::map<std::string, glm::dvec3> sky_shape;     // Share of each shape; empty where not given.
  std::optional<std::filesystem::path> sky_image;  // Whose shape the sky has; as seen from here.
  std::optional<bool> sun_observable;
};

// One entry a line, in the file's order; sky_image is relative to the file; keys that are not in
// the structs above are passed over, and null stands for what a source cannot know. Throws
// std::runtime_error naming file, line, key and what was expected; for a frame given twice.
std::vector<LightingRecord> ReadLightingRecords(const std::filesystem::path& file);

}  // namespace pleinair
