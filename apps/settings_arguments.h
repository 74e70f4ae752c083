// Settings on a command line: options of their own for the common ones, --set and --settings for
// all.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "apps/arguments.h"
#include "session/session_options.h"

namespace pleinair {

// Settings as given, in the order in which they apply: `before`, the file, then the assignments.
struct GivenSettings {
  std::function<void(SessionOptions&)> before;
  std::filesystem::path file;
  std::vector<std::string> assignments;  // "name=value"

  // Returns the assignments that apply, those of the file first. Throws as ApplySetting and
  // ApplySettings.
  std::vector<std::string> ApplyTo(SessionOptions& options) const;
};

// An option that is short for --set `setting`=...; its help is the setting's.
void AddSettingOption(CLI::App& command,
                      const std::string& option,
                      const std::string& setting,
                      GivenSettings& given,
                      const std::string& group);

// --set and --settings
void AddSettings(CLI::App& command, GivenSettings& given);

// `pleinair settings`
void AddSettingsCommand(CLI::App& app, Work& work);

}  // namespace pleinair
