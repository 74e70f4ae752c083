#include "apps/regression_baseline.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "calib/json_cursor.h"
#include "scene/whole_file.h"
#include "session/settings.h"

namespace pleinair {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "pleinair-baseline-2";
constexpr std::size_t kMostSettings = 1000;

// "name=value" of a setting that allows the value.
std::string KnownAssignment(const JsonCursor& at) {
  std::string assignment = at.Text();
  try {
    SessionOptions allowed;
    ApplySetting(assignment, allowed);
  } catch (const std::invalid_argument& error) {
    at.Fail(fmt::format("a setting ({})", error.what()));
  }
  return assignment;
}

FigureSettings SettingsFrom(const JsonCursor& at) {
  constexpr int kMost = std::numeric_limits<int>::max();
  at.CheckKeys({"frames_limit", "pictures", "set"});
  FigureSettings settings;
  if (const auto limit = at.Optional("frames_limit")) {
    settings.frames_limit = limit->IntegerIn(0, kMost);
  }
  if (const auto pictures = at.Optional("pictures")) settings.pictures = pictures->Boolean();
  if (const auto assignments = at.Optional("set")) {
    for (const JsonCursor& assignment : assignments->List(0, kMostSettings)) {
      settings.assignments.push_back(KnownAssignment(assignment));
    }
  }
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
  if (!settings.assignments.empty()) json["set"] = settings.assignments;
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
