// `pleinair tradeoff`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/tradeoff_trials.h"

namespace pleinair {

struct TradeoffCommandOptions {
  std::vector<std::filesystem::path> sequences;  // One; of imperfections any number.
  TrialSettings trials;                          // Their sequence is set from those.
  std::optional<int> frames_limit;               // Frames of the trials; none: by sweep.
  std::filesystem::path out;
  int most_combinations = 60;  // Combinations that are tried for the front.
  // Names of axes, or kFrontSweep; empty: all that mean something here. Or of imperfections,
  // kImperfectionSweep for all of them.
  std::vector<std::string> sweep;
};

inline constexpr const char* kFrontSweep = "front";
inline constexpr const char* kImperfectionSweep = "imperfections";

// Writes OUT/tradeoff.csv and .html for axes; OUT/front.csv, .html and .svg for combinations of
// settings; OUT/imperfections.csv, .html, .md and .svg for those. Each is written completely or not
// at all. Returns what to print. Throws std::runtime_error or std::invalid_argument, one line.
std::string RunTradeoffCommand(const TradeoffCommandOptions& options);

}  // namespace pleinair
