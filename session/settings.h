// The settings of a session by name: one table for `--set`, for files of settings and for the list
// that `pleinair settings` prints.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "session/session_options.h"

namespace pleinair {

struct Setting {
  std::string name;      // Where it is in SessionOptions: "light.samples".
  std::string meaning;   // With its unit.
  std::string values;    // "1 to 100000", "tukey, huber or squares".
  std::string standard;  // What holds where nothing is said, in words where the sequence decides.
  // Reads `text` into the options. Throws std::invalid_argument, one line, for what is not among
  // the values.
  std::function<void(const std::string& text, SessionOptions& options)> set;
};

// In the order in which they are listed: by the part of the work that they are about.
const std::vector<Setting>& Settings();

// Throws std::invalid_argument for an unknown name, with the nearest known one.
const Setting& SettingOf(std::string_view name);

// Of "name=value". Throws std::invalid_argument, one line, as SettingOf and Setting::set, and for
// text without a name.
void ApplySetting(const std::string& assignment, SessionOptions& options);

// A "name=value" a line; empty lines and those that begin with # are passed over. All of a file or
// nothing is applied. Throws std::runtime_error, one line with file and line number.
void ApplySettings(const std::filesystem::path& file, SessionOptions& options);

}  // namespace pleinair
