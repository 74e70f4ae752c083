#include "apps/settings_arguments.h"

#include <memory>
#include <utility>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "pipeline/effect.h"
#include "session/settings.h"

namespace pleinair {
namespace {

std::string ListOfSettings() {
  std::string text =
      "Set one by --set name=value, or many by --settings FILE with a name=value a line.\n";
  for (const Setting& setting : Settings()) {
    text += fmt::format("\n{}\n    {}\n    {} (default: {})\n",
                        setting.name,
                        setting.meaning,
                        setting.values,
                        setting.standard);
  }
  text += "\nEffects, for --effects\n";
  for (const Effect effect : kAllEffects) {
    text += fmt::format("    {}: {}\n", NameOf(effect), HelpOf(effect));
  }
  return text;
}

std::string JsonOfSettings() {
  auto list = nlohmann::ordered_json::array();
  for (const Setting& setting : Settings()) {
    list.push_back({{"name", setting.name},
                    {"meaning", setting.meaning},
                    {"values", setting.values},
                    {"default", setting.standard}});
  }
  auto effects = nlohmann::ordered_json::array();
  for (const Effect effect : kAllEffects) {
    effects.push_back({{"name", NameOf(effect)}, {"meaning", HelpOf(effect)}});
  }
  list.push_back({{"name", "effects"},
                  {"meaning", "which effects are run"},
                  {"values", "plan, all, or names"},
                  {"default", "plan"},
                  {"effects", std::move(effects)}});
  constexpr int kIndent = 1;
  return list.dump(kIndent) + "\n";
}

}  // namespace

std::vector<std::string> GivenSettings::ApplyTo(SessionOptions& options) const {
  if (before) before(options);
  std::vector<std::string> all;
  if (!file.empty()) all = ApplySettings(file, options);
  for (const std::string& assignment : assignments) ApplySetting(assignment, options);
  all.insert(all.end(), assignments.begin(), assignments.end());
  return all;
}

void AddSettingOption(CLI::App& command,
                      const std::string& option,
                      const std::string& setting,
                      GivenSettings& given,
                      const std::string& group) {
  const Setting& known = SettingOf(setting);
  command
      .add_option_function<std::string>(
          option,
          [&given, setting](const std::string& text) {
            given.assignments.push_back(setting + "=" + text);
          },
          fmt::format("{} ({}; default: {})", known.meaning, known.values, known.standard))
      ->type_name("")
      ->group(group);
}

void AddSettings(CLI::App& command, GivenSettings& given) {
  constexpr const char* kGroup = "All other settings";
  command
      .add_option_function<std::vector<std::string>>(
          "--set",
          [&given](const std::vector<std::string>& assignments) {
            given.assignments.insert(
                given.assignments.end(), assignments.begin(), assignments.end());
          },
          "name=value, of what `pleinair settings` lists; repeatable")
      ->allow_extra_args(false)
      ->type_name("NAME=VALUE")
      ->group(kGroup);
  command.add_option("--settings", given.file, "a file with a name=value a line")
      ->type_name("FILE")
      ->group(kGroup);
}

void AddSettingsCommand(CLI::App& app, Work& work) {
  auto json = std::make_shared<bool>(false);
  CLI::App& settings = *app.add_subcommand(
      "settings", "All settings of the commands that take --set: meaning, unit, values, default");
  settings.footer("Example: pleinair settings");
  settings.add_flag("--json", *json, "print JSON");
  settings.callback([json, &work] {
    work = [json] { return Print(*json ? JsonOfSettings() : ListOfSettings()); };
  });
}

}  // namespace pleinair
