#include "apps/regression_baseline.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "apps/whole_text.h"
#include "calib/json_cursor.h"

namespace pleinair {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "pleinair-baseline-1";

FigureSettings SettingsFrom(const JsonCursor& at) {
  constexpr int kMost = std::numeric_limits<int>::max();
  at.CheckKeys({"frames_limit", "pictures", "patch_size_m", "rays"});
  FigureSettings settings;
  if (const auto limit = at.Optional("frames_limit")) {
    settings.frames_limit = limit->IntegerIn(0, kMost);
  }
  if (const auto pictures = at.Optional("pictures")) settings.pictures = pictures->Boolean();
  if (const auto size_m = at.Optional("patch_size_m")) settings.patch_size_m = size_m->Number();
  if (const auto rays = at.Optional("rays")) settings.rays = rays->IntegerIn(1, kMost);
  return settings;
}

SeededFigures FiguresFrom(const JsonCursor& at) {
  SeededFigures figures;
  for (const JsonCursor::Entry& figure : at.Entries()) {
    // One for each seed.
    for (const JsonCursor& value : figure.at.List(1, std::numeric_limits<std::size_t>::max())) {
      figures[figure.key].push_back(value.Number());
    }
  }
  return figures;
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
  std::error_code error;
  if (!std::filesystem::exists(file, error)) {
    throw std::runtime_error(file.string() + ": expected a baseline there (see --write-baseline)");
  }
  const nlohmann::json document = LoadJson(file);
  const JsonCursor root(document, file.string());
  root.Required("format").OneOf({kFormat});
  RegressionBaseline baseline;
  for (const JsonCursor::Entry& sequence : root.Required("sequences").Entries()) {
    baseline[sequence.key] = {SettingsFrom(sequence.at.Required("settings")),
                              FiguresFrom(sequence.at.Required("figures"))};
  }
  return baseline;
}

void WriteRegressionBaseline(const RegressionBaseline& baseline,
                             const std::filesystem::path& file) {
  // One figure a line, so that the changes of an update can be read.
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
