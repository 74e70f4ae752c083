#include "session/settings.h"

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "scene/trimmed.h"
#include "session/internal/settings_table.h"

namespace pleinair {
namespace {

// Letters to change, add or leave out (Levenshtein's distance).
std::size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({changed, row[j] + 1, row[j - 1] + 1}));
    }
  }
  return row.back();
}

}  // namespace

const std::vector<Setting>& Settings() {
  static const std::vector<Setting> kSettings = internal::MakeSettings();
  return kSettings;
}

const Setting& SettingOf(std::string_view name) {
  const auto distance = [&](const Setting& setting) { return EditDistance(name, setting.name); };
  const auto nearest = std::min_element(
      Settings().begin(), Settings().end(), [&](const Setting& a, const Setting& b) {
        return distance(a) < distance(b);
      });
  if (nearest->name == name) return *nearest;
  throw std::invalid_argument(
      fmt::format("'{}' is no setting: expected one that `pleinair settings` lists, such as {}",
                  name,
                  nearest->name));
}

std::pair<std::string, std::string> NameAndValue(const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos) {
    throw std::invalid_argument(
        fmt::format("'{}': expected name=value, as `pleinair settings` lists them", assignment));
  }
  const std::string_view text = assignment;
  return {std::string(Trimmed(text.substr(0, equals))),
          std::string(Trimmed(text.substr(equals + 1)))};
}

void ApplySetting(const std::string& assignment, SessionOptions& options) {
  const auto [name, value] = NameAndValue(assignment);
  SettingOf(name).set(value, options);
}

std::vector<std::string> ApplySettings(const std::filesystem::path& file, SessionOptions& options) {
  std::ifstream lines(file);
  if (!lines) throw std::runtime_error(file.string() + ": expected a file of settings, found none");
  SessionOptions changed = options;
  std::vector<std::string> assignments;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    const std::string text(Trimmed(line));
    if (text.empty() || text.front() == '#') continue;
    assignments.push_back(text);
    try {
      ApplySetting(text, changed);
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(fmt::format("{}:{}: {}", file.string(), number, error.what()));
    }
  }
  if (lines.bad()) throw std::runtime_error(file.string() + ": cannot be read to its end");
  options = std::move(changed);
  return assignments;
}

}  // namespace pleinair
