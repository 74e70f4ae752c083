#include "apps/arguments.h"

#include <cmath>
#include <cstdio>

#include <CLI/CLI.hpp>

namespace pleinair {

int Print(const std::string& text) {
  std::fputs(text.c_str(), stdout);
  if (!text.empty() && text.back() != '\n') std::fputc('\n', stdout);
  return 0;
}

CLI::Validator Positive() {
  return CLI::Validator(
      [](const std::string& text) {
        double number = 0.0;
        const bool is_number = CLI::detail::lexical_cast(text, number);
        return is_number && number > 0.0 && std::isfinite(number)
                   ? std::string()
                   : "is " + text + ": expected a number above 0";
      },
      "POSITIVE");
}

CLI::Validator NotNegative() {
  return CLI::Validator(
      [](const std::string& text) {
        double number = 0.0;
        const bool is_number = CLI::detail::lexical_cast(text, number);
        return is_number && number >= 0.0 && std::isfinite(number)
                   ? std::string()
                   : "is " + text + ": expected 0 or a number above";
      },
      "NONNEGATIVE");
}

}  // namespace pleinair
