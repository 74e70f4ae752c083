#include "apps/help_text.h"

#include <regex>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace pleinair {
namespace {

// What stands before and after the first colon of CLI11's name of a type: its word and its check.
std::string WordOf(const std::string& type) { return type.substr(0, type.find(':')); }

std::string CheckOf(const std::string& type) {
  const std::size_t colon = type.find(':');
  return colon == std::string::npos ? std::string() : type.substr(colon + 1);
}

// The values that a check accepts; empty where CLI11's name of it says nothing to a person.
std::string Accepted(const std::string& check) {
  static const std::regex either(R"(\((.*)\) OR \((.*)\))");
  static const std::regex range(R"(\w+ in \[(\S+) - (\S+)\])");
  static const std::regex list(R"(\{(.*)\})");
  static const std::regex comma(",");
  if (check == "POSITIVE") return "above 0";
  if (check == "NONNEGATIVE" || check == "WHOLE") return "0 or more";
  std::smatch found;
  if (std::regex_match(check, found, either)) {
    return Accepted(found[1]) + " or " + Accepted(found[2]);
  }
  if (std::regex_match(check, found, range)) return found[1].str() + " to " + found[2].str();
  if (!std::regex_match(check, found, list)) return {};
  return std::regex_replace(found[1].str(), comma, ", ");
}

std::string NamesOf(const std::set<CLI::Option*>& options) {
  std::vector<std::string> names;
  names.reserve(options.size());
  for (const CLI::Option* option : options) names.push_back(option->get_name());
  return fmt::format("{}", fmt::join(names, ", "));
}

// Without some groups, which it names instead.
class ShortHelp final : public HelpText {
 public:
  explicit ShortHelp(const std::set<std::string>& left_out) : left_out_(left_out) {}

  std::string make_group(std::string group,
                         bool is_positional,
                         std::vector<const CLI::Option*> options) const override {
    if (left_out_.contains(group)) return {};
    return HelpText::make_group(std::move(group), is_positional, std::move(options));
  }
  std::string make_footer(const CLI::App* app) const override {
    return fmt::format("Further options, by --help-all: {}\n{}",
                       fmt::join(left_out_, ", "),
                       HelpText::make_footer(app));
  }

 private:
  const std::set<std::string>& left_out_;
};

}  // namespace

std::string HelpText::make_help(const CLI::App* app,
                                std::string name,
                                CLI::AppFormatMode mode) const {
  if (!rare_groups_.empty() && mode == CLI::AppFormatMode::Normal) {
    return ShortHelp(rare_groups_).make_help(app, std::move(name), mode);
  }
  // CLI11 leaves a blank line after each group, and one more before the next.
  static const std::regex blank_lines("\n{3,}");
  return std::regex_replace(
      CLI::Formatter::make_help(app, std::move(name), mode), blank_lines, "\n\n");
}

// "--video[=RATE]" in place of "--video{auto}".
std::string HelpText::make_option_name(const CLI::Option* option, bool is_positional) const {
  static const std::regex preset(R"(\{[^}]*\})");
  return std::regex_replace(CLI::Formatter::make_option_name(option, is_positional),
                            preset,
                            "[=" + WordOf(option->get_type_name()) + "]");
}

std::string HelpText::make_option_opts(const CLI::Option* option) const {
  if (!option->get_option_text().empty()) return " " + option->get_option_text();
  const bool is_flag = option->get_type_size() == 0 || option->get_expected_min() == 0;
  if (is_flag) return {};
  std::string word = WordOf(option->get_type_name());
  if (word == "INT" || word == "UINT" || word == "FLOAT") word = "NUMBER";
  std::string text = word.empty() ? word : " " + word;
  const bool is_list = option->get_expected_max() == CLI::detail::expected_max_vector_size;
  if (is_list && !word.ends_with("...")) text += " ...";
  if (option->get_required()) text += " " + get_label("REQUIRED");
  return text;
}

std::string HelpText::make_option_desc(const CLI::Option* option) const {
  const std::string& said = option->get_description();
  if (!option->get_option_text().empty()) return said;
  std::vector<std::string> notes;
  const auto add = [&](const std::string& note) {
    if (!note.empty()) notes.push_back(note);
  };
  if (option->get_type_size() != 0) {
    add(Accepted(CheckOf(option->get_type_name())));
    const std::string& preset = option->get_default_str();
    const bool is_said = said.find("(default") != std::string::npos;
    if (!preset.empty() && preset != "[]" && !is_said) add("default: " + preset);
  }
  if (!option->get_needs().empty()) add("only with " + NamesOf(option->get_needs()));
  if (!option->get_excludes().empty()) add("not with " + NamesOf(option->get_excludes()));
  if (notes.empty()) return said;
  const std::string all = fmt::format("{}", fmt::join(notes, "; "));
  // A default that the description itself states, at its end.
  const std::size_t stated = said.ends_with(')') ? said.rfind("(default") : std::string::npos;
  if (stated == std::string::npos) return said + " (" + all + ")";
  return said.substr(0, stated + 1) + all + "; " + said.substr(stated + 1);
}

}  // namespace pleinair
