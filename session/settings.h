// The settings of a session by name: one table for `--set`, for files of settings and for the list
// that `pleinair settings` prints.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "session/session_options.h"

namespace pleinair {

// One named setting.
struct Setting {
  std::string name;      // Its place in SessionOptions: "light.samples".
  std::string meaning;   // With its unit.
  std::string values;    // "1 to 100000", "tukey, huber or squares".
  std::string standard;  // The default, in words where the sequence decides.
  // Reads `text` into the options. Throws std::invalid_argument, one line, for a value that is not
  // allowed.
  std::function<void(const std::string& text, SessionOptions& options)> set;
};

// All settings, in the order of the list: by the part of the work that they belong to.
const std::vector<Setting>& Settings();

// Throws std::invalid_argument for an unknown name, with the nearest known one.
const Setting& SettingOf(std::string_view name);

// Applies "name=value". Throws std::invalid_argument, one line, as SettingOf and Setting::set, and
// for text without a name.
void ApplySetting(const std::string& assignment, SessionOptions& options);

// Splits "name=value". Throws std::invalid_argument, one line, for text without a name.
std::pair<std::string, std::string> NameAndValue(const std::string& assignment);

// Applies a file of one "name=value" per line, and returns these; empty lines and those that begin
// with # are ignored. All of a file or nothing is applied. Throws std::runtime_error, one line with
// file and line number.
std::vector<std::string> ApplySettings(const std::filesystem::path& file, SessionOptions& options);

}  // namespace pleinair
