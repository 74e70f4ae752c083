// How much of a frame's time accuracy is worth: `run --quality`, and the settings behind it.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/tradeoff_axes.h"

namespace pleinair {

enum class Quality { kFast, kBalanced, kBest };
inline constexpr Quality kAllQualities[] = {Quality::kFast, Quality::kBalanced, Quality::kBest};
const char* NameOf(Quality quality);  // "fast"

// A setting that trades time for accuracy. What `tradeoff --sweep front` combines.
struct QualitySetting {
  std::string option;              // Of `run`, without its dashes.
  std::vector<SweepValue> values;  // From the quickest on.
  // Among the values, by quality: fast, balanced, best.
  std::string fast;
  std::string balanced;  // What `run` takes where nothing is said.
  std::string best;

  const std::string& TextAt(Quality quality) const;
  // Its place among the values.
  int IndexAt(Quality quality) const;
};

const std::vector<QualitySetting>& QualitySettings();

// Sets what the quality asks for. Options for which `is_given` is true (a name as in
// QualitySetting) stay as they are.
void ApplyQuality(Quality quality,
                  const std::function<bool(const std::string&)>& is_given,
                  SessionOptions& options);

// "samples 200, object-rays 64": what differs from balanced; empty where nothing does.
std::string QualityInWords(Quality quality);

}  // namespace pleinair
