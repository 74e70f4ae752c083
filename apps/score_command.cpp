#include "apps/score_command.h"

#include "datasets/scoring.h"
#include "scene/whole_file.h"

namespace pleinair {

std::string RunScoreCommand(const ScoreCommandOptions& options) {
  const Score score = ScoreRun(options.sequence, options.out);
  const std::string json = ToJson(score);
  WriteWholeText(options.out / "score.json", json);
  return options.json ? json : ToTable(score);
}

}  // namespace pleinair
