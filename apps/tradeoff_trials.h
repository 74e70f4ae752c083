// Measures the settings of a sweep: each of its axes' values, with many seeds.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/tradeoff_axes.h"
#include "datasets/run_scorer.h"
#include "pipeline/tradeoff.h"
#include "relight/progress.h"
#include "render/gl_context.h"
#include "session/sequence_session.h"

namespace pleinair {

struct TrialSettings {
  // Of all runs, but for what is swept, the seeds, and the filter: each frame stands by itself.
  SessionOptions session;
  std::vector<std::string> assignments;  // "name=value", what differs in it from the defaults.
  int seeds = 20;                        // For settings that are judged by the light.
  int costly_seeds = 3;                  // For settings that need new pictures or rays.
  int frames_limit = 24;                 // Spread over the sequence.
};

// With one seed; medians over frames. None where it was not measured.
struct TrialFigures {
  double error = 0.0;  // What the axis is judged by, as is the time.
  double time_ms = 0.0;
  std::optional<double> sun_error;
  std::optional<double> sky_error;
  std::optional<double> object_psnr_db;
  std::optional<double> effect_psnr_db;
  std::optional<double> transport_ms;  // View, sun's part.
  std::optional<double> draw_ms;       // Drawing the sample set.
  std::optional<double> estimate_ms;   // Reading the samples to covariance.
  std::optional<double> objects_ms;    // Light on objects, and what they change.
  std::optional<double> render_ms;     // Drawing and reading back.
};

// The options that a sweep varies: each frame by itself, without the filter over time.
SessionOptions TrialRunOptions(const TrialSettings& settings);
// "all other settings at their defaults", or what differs from these.
std::string OtherSettingsInWords(const TrialSettings& settings);

// See TradeoffTrials. None where nothing of the kind was scored.
std::optional<double> LightError(const Score& score);
std::optional<double> PictureError(const Score& score);  // Code values.

struct SweepResult {
  std::string value;
  bool is_default = false;
  std::vector<TrialFigures> trials;  // One a seed; the same seeds for all of an axis.
  std::string failure;               // Why there are none, or fewer.
  std::optional<double> prepare_s;   // None where all of it came from the cache.
};

struct SweptAxis {
  SweepAxis axis;
  std::vector<SweepResult> results;  // One a value.
};

// The light's error is the mean of its sun's and its sky's, as scores have them, over well-posed
// frames where there are some. The picture's is the root mean square over object pixels and that
// over what the object changes elsewhere, in display code values; the mean of both.
class TradeoffTrials {
 public:
  // Reads the sequence and its truth. Throws as LoadSequence and RunScorer; std::runtime_error
  // where there is no truth.
  TradeoffTrials(const TrialSettings& settings, const Progress& progress);
  ~TradeoffTrials();

  SweepCase Case() const;
  int LightFrames() const;
  int PictureFrames() const;
  const LoadedSequence& Loaded() const { return *default_; }

  // Preparations and views that axes share are made once.
  std::vector<SweptAxis> Measure(const std::vector<SweepAxis>& axes);

 private:
  struct Job;

  std::shared_ptr<const LoadedSequence> Load(const SessionOptions& options, double& prepare_s);
  void MeasureLight(const std::vector<Job*>& batch);
  void MeasurePicture(Job& job);

  TrialSettings settings_;
  Progress progress_;
  std::shared_ptr<const LoadedSequence> default_;
  // The last sequence that had other offline settings.
  PrepareSettings other_settings_;
  std::shared_ptr<const LoadedSequence> other_;
  RunScorer scorer_;
  std::vector<Frame> frames_;          // Frames that the light is measured on.
  std::vector<bool> wanted_pictures_;  // Which frames composites are measured on.
  std::shared_ptr<const HeadlessContext> context_ = std::make_shared<const HeadlessContext>();
};

}  // namespace pleinair
