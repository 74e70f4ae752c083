#include "apps/front_trials.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <limits>
#include <stdexcept>
#include <utility>

#include <spdlog/spdlog.h>
#include <glm/ext/matrix_transform.hpp>
#include <glm/mat4x4.hpp>

#include "apps/lighting_log.h"
#include "apps/sequence_figures.h"
#include "datasets/statistics.h"
#include "scene/elapsed.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

// The first frame of a kind sets up what the others keep.
constexpr int kStillFrames = 8;
constexpr int kMovingFrames = 4;
constexpr double kTurnOfAFrameDeg = 0.5;

Camera TurnedAboutItself(const Camera& camera, double angle_rad) {
  const glm::dvec3 centre(glm::inverse(camera.camera_from_world)[3]);
  glm::dmat4 turn = glm::translate(glm::dmat4(1.0), centre);
  turn = glm::rotate(turn, angle_rad, glm::dvec3(0.0, 0.0, 1.0));
  turn = glm::translate(turn, -centre);
  return {camera.intrinsics, camera.camera_from_world * turn};
}

Combination CombinationOf(Quality quality) {
  Combination combination;
  for (const QualitySetting& setting : QualitySettings()) {
    combination.push_back(setting.IndexAt(quality));
  }
  return combination;
}

double TimedMs(SequenceSession& run, Frame frame) {
  const auto start = std::chrono::steady_clock::now();
  const SessionStep step = run.Process(std::move(frame));
  if (!step.result) throw std::runtime_error(step.result.error().reason);
  return MsSince(start);
}

}  // namespace

FrontTrials::FrontTrials(const TrialSettings& settings, const Progress& progress)
    : settings_(settings),
      progress_(progress),
      default_(Load(OptionsOf(CombinationOf(Quality::kBalanced), 1))),
      scorer_(default_->sequence) {
  wanted_ = SpreadOverPictured(
      scorer_, static_cast<int>(default_->sequence.frames.size()), settings_.frames_limit);
  if (Frames() == 0 || default_->site.objects.empty()) {
    throw std::runtime_error(default_->sequence.folder.string() +
                             ": its truth has no picture with an object: expected some, to "
                             "measure errors");
  }
  default_runs_ = RunsOf(OptionsOf(CombinationOf(Quality::kBalanced), 1));
}

int FrontTrials::Frames() const {
  return static_cast<int>(std::count(wanted_.begin(), wanted_.end(), true));
}

std::vector<FrontPoint> FrontTrials::Search(int most_trials) {
  FrontSearch search;
  for (const QualitySetting& setting : QualitySettings()) {
    search.value_counts.push_back(static_cast<int>(setting.values.size()));
  }
  search.most_trials = most_trials;
  // The first one is what others vary.
  for (const Quality quality : {Quality::kBalanced, Quality::kFast, Quality::kBest}) {
    search.start.push_back(CombinationOf(quality));
  }
  std::vector<Measured> all;
  SearchFront(search, [&](std::span<const Combination> combinations) {
    std::vector<std::optional<CombinationCost>> costs;
    for (const Combination& combination : combinations) {
      progress_("combinations", static_cast<double>(all.size()) / most_trials);
      all.push_back(Measure(combination));
      costs.emplace_back();
      if (all.back().pairs.empty()) continue;
      costs.back() = CostOf(all.back());
      spdlog::info(
          "combination {} of at most {}: {:.2f} (still) and {:.2f} (moving) times the "
          "default's time, picture off by {:.2f} code values",
          all.size(),
          most_trials,
          costs.back()->time_ms[0],
          costs.back()->time_ms[1],
          costs.back()->error);
    }
    return costs;
  });
  progress_("combinations", 1.0);

  std::vector<double> still;
  std::vector<double> moving;
  for (const Measured& measured : all) {
    for (const Pair& pair : measured.pairs) {
      still.push_back(pair.of_default.still);
      moving.push_back(pair.of_default.moving);
    }
  }
  std::vector<FrontPoint> points;
  for (Measured& measured : all) {
    for (const Pair& pair : measured.pairs) {
      measured.point.still_ms.push_back(Percentile(still, 0.5) * pair.of_combination.still /
                                        pair.of_default.still);
      measured.point.moving_ms.push_back(Percentile(moving, 0.5) * pair.of_combination.moving /
                                         pair.of_default.moving);
    }
    points.push_back(std::move(measured.point));
  }
  if (points.size() > 1) std::swap(points[0], points[1]);  // Balanced is second by name.
  return points;
}

SessionOptions FrontTrials::OptionsOf(const Combination& combination, std::uint64_t seed) const {
  SessionOptions options = TrialRunOptions(settings_);
  for (std::size_t s = 0; s < combination.size(); ++s) {
    const QualitySetting& setting = QualitySettings()[s];
    setting.Apply(setting.values[static_cast<std::size_t>(combination[s])], options);
  }
  SetSeed(seed, options);
  return options;
}

std::shared_ptr<const LoadedSequence> FrontTrials::Load(const SessionOptions& options) {
  for (const auto& [settings, loaded] : loaded_) {
    if (settings == options.prepare) return loaded;
  }
  loaded_.emplace_back(options.prepare, LoadSequence(options, progress_));
  return loaded_.back().second;
}

FrontTrials::Runs FrontTrials::RunsOf(const SessionOptions& options) {
  const std::shared_ptr<const LoadedSequence> loaded = Load(options);
  SessionOptions of_moving = options;
  of_moving.camera_moves = true;
  return {std::make_unique<SequenceSession>(loaded, options, context_),
          std::make_unique<SequenceSession>(loaded, of_moving, context_)};
}

Frame FrontTrials::Run(SequenceSession& run, FrontPoint& point) {
  std::optional<Frame> last;
  while (std::optional<SessionStep> step =
             run.Next([&](int i) { return bool{wanted_[static_cast<std::size_t>(i)]}; })) {
    if (!step->result) throw std::runtime_error(step->result.error().reason);
    const Composite& made = step->result->composite;
    scorer_.Add(RecordOf(step->frame->index, step->result), [&made] {
      return ScoredComposite{RoundToHalf(made.radiance), made.change};
    });
    last = std::move(step->frame);
  }
  if (!last) throw std::runtime_error("no frame could be read");
  const Score score = scorer_.Finish();
  point.picture_error.push_back(PictureError(score).value());
  if (const auto error = LightError(score)) point.light_error.push_back(*error);
  return std::move(*last);
}

FrontTrials::Times FrontTrials::Time(Runs& runs, const Frame& frame) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  Times least{kNone, kNone};
  for (int i = 0; i < kStillFrames; ++i) {
    const double ms = TimedMs(*runs.still, frame);
    if (i > 0) least.still = std::min(least.still, ms);
  }
  for (int i = 1; i <= kMovingFrames; ++i) {
    Frame turned = frame;
    turned.camera = TurnedAboutItself(frame.camera, RadFromDeg(i * kTurnOfAFrameDeg));
    const double ms = TimedMs(*runs.moving, std::move(turned));
    if (i > 1) least.moving = std::min(least.moving, ms);
  }
  return least;
}

FrontTrials::Measured FrontTrials::Measure(const Combination& combination) {
  Measured measured;
  measured.point.combination = combination;
  try {
    for (int s = 1; s <= settings_.costly_seeds; ++s) {
      const auto seed = static_cast<std::uint64_t>(s);
      Runs runs = RunsOf(OptionsOf(combination, seed));
      const Frame frame = Run(*runs.still, measured.point);
      const Times of_default = Time(default_runs_, frame);
      measured.pairs.push_back({of_default, Time(runs, frame)});
    }
  } catch (const std::exception& error) {
    measured.point.failure = error.what();
    measured.pairs.clear();
  }
  return measured;
}

// Relative to the default's times under the same conditions: ratios are comparable.
CombinationCost FrontTrials::CostOf(const Measured& measured) const {
  std::vector<double> still;
  std::vector<double> moving;
  for (const Pair& pair : measured.pairs) {
    still.push_back(pair.of_combination.still / pair.of_default.still);
    moving.push_back(pair.of_combination.moving / pair.of_default.moving);
  }
  return {Percentile(measured.point.picture_error, 0.5),
          {Percentile(std::move(still), 0.5), Percentile(std::move(moving), 0.5)}};
}

}  // namespace pleinair
