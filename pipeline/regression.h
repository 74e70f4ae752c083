// Determines whether a sequence's figures got worse than a stored baseline: `pleinair regress`.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "datasets/scoring.h"
#include "pipeline/plausibility.h"

namespace pleinair {

// The input of the figures.
struct RunToJudge {
  std::vector<FrameFacts> done;  // In the run's order.
  int frames_failed = 0;
  std::optional<Score> score;  // None without truth.
};

// One figure of merit of a run.
struct FigureKind {
  std::string name;   // As in files: sun_error_median, ...
  std::string words;  // For people, with its unit.
  bool higher_is_better = false;
  // It varies by up to this with another compiler, processor or GL driver, by rounding.
  double rounding = 0.0;
  // Returns the figure; none, or not finite, where the run does not have it.
  std::optional<double> (*of)(const RunToJudge& run) = nullptr;
};

// All kinds of figures, in the order in which they are shown.
const std::vector<FigureKind>& AllFigureKinds();

// The run's figures by name; a figure that it does not have is left out.
std::map<std::string, double> FiguresOf(const RunToJudge& run);

// Values of each figure, one for each seed of the sample draw.
using SeededFigures = std::map<std::string, std::vector<double>>;

// Appends one seed's.
void AddSeed(const std::map<std::string, double>& figures, SeededFigures& all);

// One figure, compared with the baseline.
struct FigureComparison {
  enum class Outcome {
    kSame,    // Within the noise.
    kBetter,  // Beyond the best of the baseline's seeds by more than the noise.
    kWorse,   // Beyond the worst of them by more than the noise.
    kNew,     // The baseline does not have it.
    kGone,    // Only the baseline has it; counts as worse.
  };
  FigureKind kind;
  Outcome outcome = Outcome::kSame;
  // Medians over the seeds.
  std::optional<double> now;
  std::optional<double> baseline;
  // Difference between the best and the worst of the baseline's seeds, kind.rounding at least.
  double noise = 0.0;
  // The value up to which it is not worse. Without meaning where there is no baseline.
  double limit = 0.0;

  bool GotWorse() const { return outcome == Outcome::kWorse || outcome == Outcome::kGone; }
  // One line; empty where the figure has not got worse.
  std::string Reason() const;
};

// Compares all figures that either has, in the order of AllFigureKinds; unknown names are ignored.
//
// Rule  A figure got worse when it is beyond the worst of the baseline's seeds by more than the
//       seeds differ among themselves: for five normal draws 3.5 standard deviations off the mean.
std::vector<FigureComparison> CompareFigures(const SeededFigures& baseline,
                                             const SeededFigures& now);

}  // namespace pleinair
