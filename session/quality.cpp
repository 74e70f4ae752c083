#include "session/quality.h"

#include <algorithm>
#include <stdexcept>

#include "session/settings.h"

namespace pleinair {

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
  const auto found = std::find(values.begin(), values.end(), text);
  if (found == values.end()) throw std::logic_error(name + ": has no value " + text);
  return static_cast<int>(found - values.begin());
}

void QualitySetting::Apply(const std::string& value, SessionOptions& options) const {
  SettingOf(name).set(value, options);
}

const std::vector<QualitySetting>& QualitySettings() {
  static const std::vector<QualitySetting> kSettings{
      {"light.samples", {"50", "100", "200", "500", "1000", "2000"}, "200", "500", "1000"},
      {"prepare.rays", {"64", "128", "256"}, "64", "256", "256"},
      {"pipeline.view.receiver_block_px", {"16", "8", "4", "2"}, "8", "4", "4"},
      {"pipeline.view.sun_block_px", {"8", "4", "2", "0", "1"}, "4", "0", "1"},
      {"pipeline.object_light.route", {"volume", "probe", "gather"}, "gather", "gather", "gather"},
      {"pipeline.object_light.gather.rays_per_receiver",
       {"16", "64", "256", "1024"},
       "64",
       "256",
       "1024"},
      {"pipeline.soft_sun.disc_samples", {"4", "8", "32", "128"}, "32", "32", "128"},
      {"compositor.object_samples_per_side", {"2", "4", "8"}, "2", "4", "4"},
      {"pipeline.effects.threshold_code_values", {"4", "1", "0"}, "4", "1", "1"}};
  return kSettings;
}

void ApplyQuality(Quality quality, SessionOptions& options) {
  for (const QualitySetting& setting : QualitySettings()) {
    setting.Apply(setting.TextAt(quality), options);
  }
}

std::string QualityInWords(Quality quality) {
  std::string words;
  for (const QualitySetting& setting : QualitySettings()) {
    if (setting.TextAt(quality) == setting.balanced) continue;
    words += (words.empty() ? "" : ", ") + setting.name + " " + setting.TextAt(quality);
  }
  return words;
}

}  // namespace pleinair
