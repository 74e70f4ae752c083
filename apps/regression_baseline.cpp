#include "apps/regression_baseline.h"

#include <cmath>
#include <fstream>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/whole_text.h"

namespace pleinair {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "pleinair-baseline-1";

[[noreturn]] void Refuse(const std::filesystem::path& file, const std::string& what) {
  throw std::runtime_error(file.string() + ": " + what);
}

// Also of numbers that an int would hold only in part.
bool IsIntegerFrom(int least, const Json& value) {
  return value.is_number_integer() && value.get<double>() >= least &&
         value.get<double>() <= std::numeric_limits<int>::max();
}

FigureSettings SettingsFrom(const std::filesystem::path& file,
                            const std::string& name,
                            const Json& json) {
  FigureSettings settings;
  for (const auto& [key, value] : json.items()) {
    const std::string where = fmt::format("sequences.{}.settings.{}", name, key);
    if (key == "frames_limit" && IsIntegerFrom(0, value)) {
      settings.frames_limit = value.get<int>();
    } else if (key == "pictures" && value.is_boolean()) {
      settings.pictures = value.get<bool>();
    } else if (key == "patch_size_m" && value.is_number()) {
      settings.patch_size_m = value.get<double>();
    } else if (key == "rays" && IsIntegerFrom(1, value)) {
      settings.rays = value.get<int>();
    } else {
      Refuse(file,
             where + " is " + value.dump() +
                 ": expected frames_limit (0 or more), pictures (true or false), patch_size_m or "
                 "rays (numbers)");
    }
  }
  return settings;
}

SeededFigures FiguresFrom(const std::filesystem::path& file,
                          const std::string& name,
                          const Json& json) {
  SeededFigures figures;
  for (const auto& [key, values] : json.items()) {
    const std::string where = fmt::format("sequences.{}.figures.{}", name, key);
    if (!values.is_array() || values.empty()) {
      Refuse(file, where + ": expected a list of numbers, one for each seed");
    }
    for (const Json& value : values) {
      if (!value.is_number()) Refuse(file, where + ": expected numbers, found " + value.dump());
      figures[key].push_back(value.get<double>());
    }
  }
  return figures;
}

const Json& At(const std::filesystem::path& file,
               const Json& json,
               const std::string& key,
               const std::string& where) {
  if (!json.is_object() || !json.contains(key) || !json[key].is_object()) {
    Refuse(file, where + key + ": expected an object");
  }
  return json[key];
}

Json ToJson(const FigureSettings& settings) {
  Json json = {{"frames_limit", settings.frames_limit}, {"pictures", settings.pictures}};
  if (settings.patch_size_m) json["patch_size_m"] = *settings.patch_size_m;
  if (settings.rays) json["rays"] = *settings.rays;
  return json;
}

// Six digits are more than a figure's noise leaves a meaning, and keep the file readable.
double Rounded(double value) {
  if (value == 0.0) return 0.0;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 5.0);
  return std::stod(std::to_string(std::llround(value / unit)) + "e" +
                   std::to_string(std::lround(std::log10(unit))));
}

}  // namespace

RegressionBaseline ReadRegressionBaseline(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) Refuse(file, "expected a baseline there (see --write-baseline)");
  Json json;
  try {
    json = Json::parse(stream);
  } catch (const Json::exception&) {
    Refuse(file, "expected JSON, as --write-baseline makes it");
  }
  if (!json.is_object() || json.value("format", Json()) != kFormat) {
    Refuse(file, std::string("format: expected \"") + kFormat + "\"");
  }
  RegressionBaseline baseline;
  for (const auto& [name, entry] : At(file, json, "sequences", "").items()) {
    const std::string where = "sequences." + name + ".";
    baseline[name] = {SettingsFrom(file, name, At(file, entry, "settings", where)),
                      FiguresFrom(file, name, At(file, entry, "figures", where))};
  }
  return baseline;
}

void WriteRegressionBaseline(const RegressionBaseline& baseline,
                             const std::filesystem::path& file) {
  // A figure a line: what an update changes can be read.
  std::string text = std::string("{\n\"format\": \"") + kFormat + "\",\n\"sequences\": {";
  const char* next_sequence = "\n";
  for (const auto& [name, entry] : baseline) {
    text += next_sequence + Json(name).dump() + ": {\n  \"settings\": ";
    text += ToJson(entry.settings).dump() + ",\n  \"figures\": {";
    next_sequence = ",\n";
    const char* next_figure = "\n";
    for (const auto& [figure, values] : entry.figures) {
      Json list = Json::array();
      for (const double value : values) list.push_back(Rounded(value));
      text += next_figure + std::string("    ") + Json(figure).dump() + ": " + list.dump();
      next_figure = ",\n";
    }
    text += "\n  }\n}";
  }
  WriteWholeText(file, text + "\n}\n}\n");
}

}  // namespace pleinair
