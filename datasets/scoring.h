// Compares a run with its sequence's truth: `pleinair score`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/composite_score.h"
#include "datasets/lighting_score.h"
#include "datasets/sunlit_share.h"

namespace pleinair {

// The score of one frame.
struct FrameScore {
  int frame = 0;
  std::string time_utc;
  std::optional<SunlitShare> sunlit;  // By the true sun direction; none without truth.
  std::optional<LightScore> light;
  std::optional<LightScore> raw;
  std::optional<CompositeScore> composite;
  bool made_from_linear = true;      // Else from 8-bit frames. Only with a composite.
  std::vector<std::string> without;  // What was not scored, and why.

  bool IsWellPosed() const { return sunlit && sunlit->IsWellPosed(); }
};

// Statistics of the composites over frames.
struct CompositeSummary {
  std::optional<Distribution> object_psnr_db;
  std::optional<Distribution> object_psnr_without_specular_db;
  std::optional<Distribution> effect_psnr_db;
  std::optional<Distribution> similarity;
  std::optional<Distribution> identical_outside_mask;
  std::optional<Distribution> changed_of_unchanged;
};

// Statistics of the light over frames.
struct LightSummaries {
  LightSummary all;
  LightSummary well_posed;
  LightSummary others;
};

// The score of a run.
struct Score {
  std::string sequence;
  double largest_true_sun = 0.0;   // Mean over RGB.
  std::vector<FrameScore> frames;  // Every frame of the sequence.
  LightSummaries light;            // Filtered over time.
  LightSummaries raw;              // Not filtered.
  CompositeSummary composite;
};

// Reads the sequence, its truth/, and lighting.jsonl, composite/ and mask/ of `out`. Where a frame
// lacks something (no truth, failed, no composite), its `without` says so.
// Throws std::runtime_error naming file and place where the sequence, its truth or lighting.jsonl
// cannot be read.
Score ScoreRun(const std::filesystem::path& sequence_folder, const std::filesystem::path& out);

// One JSON object; angles in degrees, shares and errors as ratios, null for missing values.
std::string ToJson(const Score& score);
// A table to print: one line per frame, then the summaries.
std::string ToTable(const Score& score);

}  // namespace pleinair
