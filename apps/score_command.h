// `pleinair score`.
#pragma once

#include <filesystem>
#include <string>

namespace pleinair {

struct ScoreCommandOptions {
  std::filesystem::path sequence;  // With truth/.
  std::filesystem::path out;       // What `run` wrote; score.json is put there.
  bool json = false;               // The text is JSON in place of a table.
};

// Scores the run, writes OUT/score.json (completely or not at all) and returns what to print.
// Throws std::runtime_error naming file and place.
std::string RunScoreCommand(const ScoreCommandOptions& options);

}  // namespace pleinair
