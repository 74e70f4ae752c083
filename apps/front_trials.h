// Measures combinations of settings over the complete program: what a frame costs, and what comes
// of it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "apps/tradeoff_trials.h"
#include "pipeline/front_search.h"
#include "session/quality.h"
#include "session/sequence_session.h"

namespace pleinair {

// A combination of QualitySettings' values; lists have one entry a seed.
struct FrontPoint {
  Combination combination;
  // The figures of TradeoffTrials.
  std::vector<double> picture_error;  // Code values.
  std::vector<double> light_error;    // A share.
  // Milliseconds of a frame without files: of a repeated frame, and of frames that each have
  // another direction. The default's median times the ratio to the default, which was measured
  // right before.
  std::vector<double> still_ms;
  std::vector<double> moving_ms;
  std::string failure;  // Empty: none.
};

class FrontTrials {
 public:
  // As TradeoffTrials; throws std::runtime_error as well where the truth has no picture with an
  // object.
  FrontTrials(const TrialSettings& settings, const Progress& progress);

  const Sequence& Recording() const { return default_->sequence; }
  int Frames() const;

  // The named qualities are first, in their order.
  std::vector<FrontPoint> Search(int most_trials);

 private:
  // Times of one combination with one seed, in milliseconds; the least of some frames, because
  // other load on the machine can only add to it.
  struct Times {
    double still = 0.0;
    double moving = 0.0;
  };
  struct Pair {
    Times of_default;
    Times of_combination;
  };
  struct Measured {
    FrontPoint point;
    std::vector<Pair> pairs;  // One a seed.
  };

  // Runs of the same options, for a camera that stands still and for one that moves.
  struct Runs {
    std::unique_ptr<SequenceSession> still;
    std::unique_ptr<SequenceSession> moving;
  };

  SessionOptions OptionsOf(const Combination& combination, std::uint64_t seed) const;
  std::shared_ptr<const LoadedSequence> Load(const SessionOptions& options);
  Runs RunsOf(const SessionOptions& options);
  // Runs the pictured frames; returns the last for Time.
  Frame Run(SequenceSession& run, FrontPoint& point);
  static Times Time(Runs& runs, const Frame& frame);
  Measured Measure(const Combination& combination);
  CombinationCost CostOf(const Measured& measured) const;

  TrialSettings settings_;
  Progress progress_;
  // Loaded sequences by the settings that they were prepared with.
  std::vector<std::pair<PrepareSettings, std::shared_ptr<const LoadedSequence>>> loaded_;
  std::shared_ptr<const LoadedSequence> default_;
  RunScorer scorer_;
  std::vector<bool> wanted_;
  std::shared_ptr<const HeadlessContext> context_ = std::make_shared<const HeadlessContext>();
  Runs default_runs_;  // To time the others against.
};

}  // namespace pleinair
