#include "estimation/shadow_cues.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "estimation/rough_light.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

// Below, neither two levels nor one are more than chance.
constexpr std::size_t kLeastSamples = 60;
constexpr double kLitShare = 0.3;       // Least share of the sun in the transport of a lit sample.
constexpr double kLeastOfLevel = 0.08;  // Least share of the samples on either level.
// In natural logarithms of radiance over transport.
constexpr double kLeastStep = 0.45;   // Shadows of weaker suns look like stains.
constexpr double kLargestStep = 2.6;  // No sky is as weak as a thirteenth of its sun.
constexpr double kLeastSteps = 3.0;   // In units of the levels' own spread.
constexpr double kLeastBluer = 0.04;  // Change of blue over red, in the shade against the sun.
constexpr double kFlatSpread = 0.25;
// Share of the sun's transport that remains in the shade: light from the lit surfaces around.
constexpr double kBounced = 0.02;

// One sample's light, as logarithms.
struct Level {
  double green = 0.0;
  double blue_over_red = 0.0;
  std::size_t sample = 0;
};

bool ReadLevel(const DiffuseSample& sample, Level& level) {
  std::array<double, 3> log{};
  for (int c = 0; c < 3; ++c) {
    if (!std::isfinite(sample.radiance_stddev_rgb[c])) return false;
    const double transport = sample.sun_transport_rgb[c] + MeanSkyTransport(sample, c);
    const double ratio = sample.radiance_rgb[c] / transport;
    if (!(ratio > 0.0) || !std::isfinite(ratio)) return false;
    log[static_cast<std::size_t>(c)] = std::log(ratio);
  }
  level.green = log[1];
  level.blue_over_red = log[2] - log[0];
  return true;
}

struct Statistics {
  double mean = 0.0;
  double variance = 0.0;
  double blue_over_red = 0.0;
};

Statistics StatisticsOf(std::span<const Level> levels) {
  Statistics found;
  const double count = static_cast<double>(levels.size());
  for (const Level& level : levels) {
    found.mean += level.green / count;
    found.blue_over_red += level.blue_over_red / count;
  }
  for (const Level& level : levels) {
    found.variance += std::pow(level.green - found.mean, 2) / count;
  }
  return found;
}

double RobustSpread(std::span<const Level> levels) {
  std::vector<double> values;
  for (const Level& level : levels) values.push_back(level.green);
  const double median = UpperMedian(values);
  for (double& value : values) value = std::abs(value - median);
  return 1.4826 * UpperMedian(values);
}

// Where ascending levels fall apart the most: Otsu's threshold. As the number of the darker.
std::size_t Split(std::span<const Level> levels) {
  double total = 0.0;
  for (const Level& level : levels) total += level.green;
  const double count = static_cast<double>(levels.size());
  double below = 0.0;
  double best = -1.0;
  std::size_t split = 0;
  for (std::size_t i = 1; i < levels.size(); ++i) {
    below += levels[i - 1].green;
    const double dark = static_cast<double>(i);
    const double apart = below / dark - (total - below) / (count - dark);
    const double between = dark * (count - dark) * apart * apart;
    if (between > best) {
      best = between;
      split = i;
    }
  }
  return split;
}

bool AreSunAndShade(std::span<const Level> levels, std::size_t dark_count) {
  const double share = static_cast<double>(dark_count) / static_cast<double>(levels.size());
  if (share < kLeastOfLevel || share > 1.0 - kLeastOfLevel) return false;
  const Statistics dark = StatisticsOf(levels.first(dark_count));
  const Statistics bright = StatisticsOf(levels.subspan(dark_count));
  const double step = bright.mean - dark.mean;
  const double spread = std::sqrt(std::max(dark.variance, bright.variance));
  return step > kLeastStep && step < kLargestStep && step > kLeastSteps * spread &&
         dark.blue_over_red - bright.blue_over_red > kLeastBluer;
}

}  // namespace

ShadowCues FindShadows(std::span<DiffuseSample> samples) {
  ShadowCues cues;
  std::vector<std::size_t> shaded;
  std::vector<Level> levels;
  // Samples of one plane follow each other.
  for (std::size_t first = 0; first < samples.size();) {
    std::size_t last = first;
    levels.clear();
    std::size_t lit = 0;
    for (; last < samples.size() && samples[last].plane == samples[first].plane; ++last) {
      lit += SunShare(samples[last], 1) > kLitShare ? 1 : 0;
      Level level{.sample = last};
      if (ReadLevel(samples[last], level)) levels.push_back(level);
    }
    const std::size_t count = last - first;
    first = last;
    // Shadows that the mesh casts decide, wherever they are in view.
    if (lit > 0 && lit < count) return {};
    if (lit == 0 || levels.size() < kLeastSamples) continue;
    std::sort(levels.begin(), levels.end(), [](const Level& a, const Level& b) {
      return a.green != b.green ? a.green < b.green : a.sample < b.sample;
    });
    const std::size_t dark = Split(levels);
    if (AreSunAndShade(levels, dark)) {
      for (const Level& level : std::span(levels).first(dark)) shaded.push_back(level.sample);
    } else {
      cues.flat = cues.flat || RobustSpread(levels) < kFlatSpread;
    }
  }
  for (const std::size_t sample : shaded) {
    samples[sample].sun_transport_rgb *= kBounced;
    samples[sample].is_lit = false;
  }
  cues.shaded = static_cast<int>(shaded.size());
  return cues;
}

std::array<double, kSkyStates> LogLikelihood(const ShadowCues& cues) {
  // Likelihood of a flat plane, in SkyState's order.
  static constexpr std::array<double, kSkyStates> kFlat{0.2, 0.2, 0.5, 0.9, 0.95};
  std::array<double, kSkyStates> log{};
  if (!cues.flat || cues.shaded > 0) return log;
  for (std::size_t s = 0; s < kSkyStates; ++s) log[s] = std::log(kFlat[s]);
  return log;
}

}  // namespace pleinair
