// `pleinair regress`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/sequence_figures.h"

namespace pleinair {

struct RegressCommandOptions {
  std::filesystem::path folder;    // A sequence, or a folder of sequences.
  std::filesystem::path baseline;  // Empty: baseline.json in `folder`.
  std::filesystem::path out;       // JSON to write; empty: none.
  std::filesystem::path cache;     // Empty: the user's cache folder.
  std::optional<int> seeds;        // None: 5 for a baseline, else 1.
  bool write_baseline = false;
  // Only for a new baseline: a check measures with its baseline's settings.
  FigureSettings settings;
};

struct RegressResult {
  std::string table;                 // For people.
  std::vector<std::string> reasons;  // Why something got worse, a line each; empty: nothing has.
};

// Compares with the baseline, or writes it: entries of sequences that are not in `folder` stay.
// Throws std::runtime_error or std::invalid_argument for bad input, one line.
RegressResult RunRegressCommand(const RegressCommandOptions& options);

}  // namespace pleinair
