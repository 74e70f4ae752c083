// Options in a command's help, as a person writes them.
#pragma once

#include <set>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>

namespace pleinair {

// "--seeds NUMBER" and "draws of samples (1 to 1000; default: 20; only with --sweep)" in place of
// CLI11's own "--seeds INT:INT in [1 - 1000]=20 Needs: --sweep".
class HelpText : public CLI::Formatter {
 public:
  HelpText() = default;
  // Options of these groups are shown by --help-all alone, which the command then needs
  // (CLI::App::set_help_all_flag).
  explicit HelpText(std::set<std::string> rare_groups) : rare_groups_(std::move(rare_groups)) {}

  std::string make_help(const CLI::App* app,
                        std::string name,
                        CLI::AppFormatMode mode) const override;
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override;
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_desc(const CLI::Option* option) const override;

 private:
  std::set<std::string> rare_groups_;
};

}  // namespace pleinair
