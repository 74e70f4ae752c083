#include "apps/score_command.h"

#include <fstream>
#include <stdexcept>
#include <system_error>

#include "datasets/scoring.h"

namespace pleinair {
namespace {

void WriteWhole(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::path unfinished = file;
  unfinished += ".part";
  std::error_code error;
  {
    std::ofstream stream(unfinished, std::ios::binary | std::ios::trunc);
    stream << text;
    stream.close();
    if (!stream) error = std::make_error_code(std::errc::io_error);
  }
  if (!error) std::filesystem::rename(unfinished, file, error);
  if (!error) return;
  std::error_code ignored;
  std::filesystem::remove(unfinished, ignored);
  throw std::runtime_error(file.string() + ": cannot be written: " + error.message());
}

}  // namespace

std::string RunScoreCommand(const ScoreCommandOptions& options) {
  const Score score = ScoreRun(options.sequence, options.out);
  const std::string json = ToJson(score);
  WriteWhole(options.out / "score.json", json);
  return options.json ? json : ToTable(score);
}

}  // namespace pleinair
