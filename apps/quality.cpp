#include "apps/quality.h"

#include <algorithm>
#include <stdexcept>

namespace pleinair {
namespace {

using RunOptions = SessionOptions;

template <typename Set>
std::vector<SweepValue> CountsOf(std::initializer_list<int> counts, const Set& set) {
  std::vector<SweepValue> values;
  for (const int count : counts) {
    values.push_back(
        {std::to_string(count), [set, count](RunOptions& options) { set(options, count); }});
  }
  return values;
}

std::vector<QualitySetting> MakeQualitySettings() {
  return {{"samples",
           CountsOf({50, 100, 200, 500, 1000, 2000}, [](RunOptions& o, int n) { o.samples = n; }),
           "200",
           "500",
           "1000"},
          {"rays",
           CountsOf({64, 128, 256}, [](RunOptions& o, int n) { o.prepare.rays = n; }),
           "64",
           "256",
           "256"},
          {"receiver-block",
           CountsOf({16, 8, 4, 2}, [](RunOptions& o, int px) { o.receiver_block_px = px; }),
           "8",
           "4",
           "4"},
          {"sun-block",
           CountsOf({8, 4, 2, 1}, [](RunOptions& o, int px) { o.sun_block_px = px; }),
           "4",
           "1",
           "1"},
          {"object-light",
           {{"volume", [](RunOptions& o) { o.object_light = ObjectLight::kVolume; }},
            {"probe", [](RunOptions& o) { o.object_light = ObjectLight::kOnePlace; }},
            {"gather", [](RunOptions& o) { o.object_light = ObjectLight::kGather; }}},
           "gather",
           "gather",
           "gather"},
          {"object-rays",
           CountsOf({16, 64, 256, 1024}, [](RunOptions& o, int n) { o.object_rays = n; }),
           "64",
           "256",
           "1024"},
          {"penumbra-samples",
           CountsOf({4, 8, 32, 128}, [](RunOptions& o, int n) { o.penumbra_samples = n; }),
           "32",
           "32",
           "128"},
          {"object-samples",
           CountsOf({2, 4, 8}, [](RunOptions& o, int n) { o.object_samples_per_side = n; }),
           "2",
           "4",
           "8"},
          {"threshold",
           {{"4", [](RunOptions& o) { o.effects.threshold_code_values = 4.0; }},
            {"1", [](RunOptions& o) { o.effects.threshold_code_values = 1.0; }},
            {"0", [](RunOptions& o) { o.effects.threshold_code_values = 0.0; }}},
           "4",
           "1",
           "1"}};
}

}  // namespace

const char* NameOf(Quality quality) {
  switch (quality) {
    case Quality::kFast:
      return "fast";
    case Quality::kBalanced:
      return "balanced";
    case Quality::kBest:
      return "best";
  }
  return "";
}

const std::string& QualitySetting::TextAt(Quality quality) const {
  return quality == Quality::kFast ? fast : quality == Quality::kBest ? best : balanced;
}

int QualitySetting::IndexAt(Quality quality) const {
  const std::string& text = TextAt(quality);
  const auto found = std::find_if(
      values.begin(), values.end(), [&](const SweepValue& value) { return value.text == text; });
  if (found == values.end()) throw std::logic_error(option + ": has no value " + text);
  return static_cast<int>(found - values.begin());
}

const std::vector<QualitySetting>& QualitySettings() {
  static const std::vector<QualitySetting> kSettings = MakeQualitySettings();
  return kSettings;
}

void ApplyQuality(Quality quality,
                  const std::function<bool(const std::string&)>& is_given,
                  SessionOptions& options) {
  for (const QualitySetting& setting : QualitySettings()) {
    if (is_given(setting.option)) continue;
    setting.values[static_cast<std::size_t>(setting.IndexAt(quality))].apply(options);
  }
}

std::string QualityInWords(Quality quality) {
  std::string words;
  for (const QualitySetting& setting : QualitySettings()) {
    if (setting.TextAt(quality) == setting.balanced) continue;
    words += (words.empty() ? "" : ", ") + setting.option + " " + setting.TextAt(quality);
  }
  return words;
}

}  // namespace pleinair
