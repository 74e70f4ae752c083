#include "datasets/lighting_record.h"

#include <fstream>
#include <limits>
#include <set>

#include <glm/geometric.hpp>

#include "calib/json_cursor.h"
#include "datasets/internal/json_vectors.h"
#include "datasets/internal/sequence_values.h"

namespace pleinair {
namespace {

std::optional<JsonCursor> Known(const JsonCursor& at, const char* key) {
  auto found = at.Optional(key);
  if (!found || found->Value().is_null()) return std::nullopt;
  return found;
}

std::optional<glm::dvec3> Vector(const JsonCursor& at, const char* key) {
  const auto found = Known(at, key);
  if (!found) return std::nullopt;
  return ReadVector3(*found);
}

std::optional<glm::dvec3> Direction(const JsonCursor& at, const char* key) {
  const auto found = Known(at, key);
  if (!found) return std::nullopt;
  return ReadDirection(*found);
}

LightUnits Units(const JsonCursor& at) {
  const auto named = Known(at, "units");
  if (!named) return LightUnits::kAbsolute;
  for (const LightUnits units :
       {LightUnits::kAbsolute, LightUnits::kRelative, LightUnits::kRelativePerFrame}) {
    if (named->Text() == NameOf(units)) return units;
  }
  named->Fail("absolute, relative, or relative per frame");
}

RecordedLight Light(const JsonCursor& at, LightUnits units) {
  return {Direction(at, "sun_direction_enu"),
          Vector(at, "sun_irradiance_rgb"),
          Vector(at, "sky_irradiance_rgb"),
          Vector(at, "sun_irradiance_stddev_rgb"),
          Vector(at, "sky_irradiance_stddev_rgb"),
          units};
}

std::map<std::string, glm::dvec3> Shares(const JsonCursor& at) {
  std::map<std::string, glm::dvec3> shares;
  for (const JsonCursor::Entry& entry : at.Entries()) {
    if (const auto share = Vector(at, entry.key.c_str())) shares.emplace(entry.key, *share);
  }
  return shares;
}

}  // namespace

std::vector<LightingRecord> ReadLightingRecords(const std::filesystem::path& file) {
  std::error_code error;
  std::ifstream stream(file);
  if (!std::filesystem::is_regular_file(file, error) || !stream) {
    throw JsonError(file.string() +
                    ": expected the lighting.jsonl of a run, found nothing to read");
  }
  std::vector<LightingRecord> records;
  std::set<int> seen;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (line.empty()) continue;
    const std::string label = file.string() + ":" + std::to_string(number);
    const nlohmann::json document = ParseJson(line, label);
    const JsonCursor at(document, label);
    LightingRecord record;
    const JsonCursor frame = at.Required("frame");
    record.frame = frame.IntegerIn(0, std::numeric_limits<int>::max());
    if (!seen.insert(record.frame).second) frame.Fail("each frame once");
    if (const auto time = Known(at, "time_utc")) record.time = ReadTime(*time);
    if (const auto reason = Known(at, "error")) record.error = reason->Text();
    if (const auto observable = Known(at, "sun_observable")) {
      record.sun_observable = observable->Boolean();
    }
    const LightUnits units = Units(at);
    record.light = Light(at, units);
    if (const auto raw = Known(at, "raw")) record.raw = Light(*raw, units);
    if (const auto shape = Known(at, "sky_shape")) record.sky_shape = Shares(*shape);
    if (const auto image = Known(at, "sky_image")) {
      record.sky_image = file.parent_path() / image->Text();
    }
    records.push_back(std::move(record));
  }
  return records;
}

}  // namespace pleinair
