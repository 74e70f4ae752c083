#include "apps/arguments.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include <CLI/CLI.hpp>

#include "apps/message_text.h"
#include "apps/one_of.h"
#include "session/sequence_site.h"

namespace pleinair {

int Print(const std::string& text) {
  std::fputs(OutputText(text).c_str(), stdout);
  if (!text.empty() && text.back() != '\n') std::fputc('\n', stdout);
  return 0;
}

void PrintError(const std::string& reason) {
  std::fflush(stdout);
  std::fprintf(stderr, "pleinair: %s\n", MessageText(reason).c_str());
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

CLI::Validator WholeNumber() {
  return CLI::Validator(
      [](const std::string& text) {
        std::uint64_t number = 0;
        const char* const end = text.data() + text.size();
        const auto [parsed_to, error] = std::from_chars(text.data(), end, number);
        return error == std::errc() && parsed_to == end
                   ? std::string()
                   : "is " + text + ": expected an integer from 0 to 2^64 - 1";
      },
      "WHOLE");
}

void AddBounces(CLI::App& command, int& bounces) {
  command
      .add_option_function<std::string>(
          "--bounces",
          [&bounces](const std::string& text) {
            bounces = text == "all" ? kAllBounces : std::stoi(text);
          },
          "reflections between surfaces: 0 (as jensen-2006), 1, ..., all")
      ->check(CLI::IsMember({"all"}) | CLI::Range(0, 100))
      ->type_name("N|all")
      ->default_str("all");
}

void AddGroundAlbedo(CLI::App& command, double& albedo) {
  command
      .add_option("--ground-albedo",
                  albedo,
                  "lay a ground of this albedo at the mesh's foot, out to the horizon: light from "
                  "below the horizon; 0: none")
      ->check(CLI::Range(0.0, 0.99))
      ->capture_default_str();
}

CLI::Option* AddFrames(CLI::App& command, FrameKind& frames) {
  return command.add_option("--frames", frames, "which frames where there are both: linear or ldr")
      ->transform(OneOf<FrameKind>({{"linear", FrameKind::kLinear}, {"ldr", FrameKind::kLdr}}))
      ->type_name("KIND")
      ->default_str("linear");
}

CLI::Option* AddCache(CLI::App& command, std::filesystem::path& cache) {
  return command
      .add_option("--cache",
                  cache,
                  "folder for prepared data (default: pleinair in the user's cache folder)")
      ->type_name("FOLDER");
}

}  // namespace pleinair
