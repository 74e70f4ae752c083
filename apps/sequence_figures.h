// The figures by which `pleinair regress` judges a sequence: run and scored in memory.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/run_scorer.h"
#include "pipeline/regression.h"

namespace pleinair {

// How a sequence's figures are measured; what is unset is as `run` has it.
struct FigureSettings {
  int frames_limit = 0;                  // So many, spread over the sequence; 0: all.
  bool pictures = true;                  // False: the light alone, in a fraction of the time.
  std::vector<std::string> assignments;  // "name=value", as session/settings.h has them.

  bool operator==(const FigureSettings&) const = default;
};

// Which of `count` frames are taken where at most `limit` are (0: all): first, last and others
// evenly between.
std::vector<bool> SpreadOver(int count, int limit);
// The same of those of `count` frames of which the truth has a picture; the others are not taken.
std::vector<bool> SpreadOverPictured(const RunScorer& scorer, int count, int limit);

// Runs the sequence with the seeds 1 .. `seeds` of the sample draw, one after the other; preparing
// and loading is done once. Where there is a truth/ or a judged.json, runs are scored and judged by
// it. Throws  as LoadSequence, RunScorer and ReadJudgedSunshine.
std::vector<RunToJudge> RunForFigures(const std::filesystem::path& sequence,
                                      const FigureSettings& settings,
                                      int seeds,
                                      const std::filesystem::path& cache);

// The figures of those runs.
SeededFigures MeasureFigures(const std::filesystem::path& sequence,
                             const FigureSettings& settings,
                             int seeds,
                             const std::filesystem::path& cache);

}  // namespace pleinair
