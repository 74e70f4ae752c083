// `pleinair tradeoff`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/tradeoff_trials.h"

namespace pleinair {

struct TradeoffCommandOptions {
  TrialSettings trials;
  std::filesystem::path out;
  std::vector<std::string> sweep;  // Names of axes; empty: all that mean something here.
};

// Writes OUT/tradeoff.csv and OUT/tradeoff.html, each whole or not at all; returns what to print.
// Throws std::runtime_error or std::invalid_argument, one line.
std::string RunTradeoffCommand(const TradeoffCommandOptions& options);

}  // namespace pleinair
