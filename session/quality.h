// How much of a frame's time accuracy is worth: `run --quality`, and the settings behind it.
#pragma once

#include <string>
#include <vector>

#include "session/session_options.h"

namespace pleinair {

enum class Quality { kFast, kBalanced, kBest };
inline constexpr Quality kAllQualities[] = {Quality::kFast, Quality::kBalanced, Quality::kBest};
const char* NameOf(Quality quality);  // "fast"

// A setting that trades time for accuracy. What `tradeoff --sweep front` combines.
struct QualitySetting {
  std::string name;                 // As session/settings.h has it.
  std::vector<std::string> values;  // From the quickest on.
  // Among the values, by quality: fast, balanced, best.
  std::string fast;
  std::string balanced;  // The default of `run`.
  std::string best;

  const std::string& TextAt(Quality quality) const;
  // Its place among the values.
  int IndexAt(Quality quality) const;
  void Apply(const std::string& value, SessionOptions& options) const;
};

const std::vector<QualitySetting>& QualitySettings();

void ApplyQuality(Quality quality, SessionOptions& options);

// "light.samples 200, prepare.rays 64": what differs from balanced; empty where nothing does.
std::string QualityInWords(Quality quality);

}  // namespace pleinair
