// Options in a command's help, as a person writes them.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace pleinair {

// "--seeds NUMBER" and "draws of samples (1 to 1000; default: 20; only with --sweep)" in place of
// CLI11's own "--seeds INT:INT in [1 - 1000]=20 Needs: --sweep".
class HelpText final : public CLI::Formatter {
 public:
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_desc(const CLI::Option* option) const override;
};

}  // namespace pleinair
