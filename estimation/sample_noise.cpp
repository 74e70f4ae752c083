#include "estimation/sample_noise.h"

#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <glm/vec3.hpp>

#include "estimation/rough_light.h"

namespace pleinair {
namespace {

// A signal below this many standard deviations of a pixel has some of its noise cut off by black.
constexpr double kReachOfNoise = 3.0;
// How much brighter a sample can be than its albedo and the model predict: three times the error
// that the fit expects.
constexpr double kReachOfModel = 0.15;

// Share of a plane's sunlit or shaded samples. With more of them clipped, the others are the darker
// ones.
constexpr double kMostClipped = 0.1;

// The samples of one plane in the sun or in the shade.
struct Group {
  glm::dvec3 signal{0.0};  // Sum of the predicted signals.
  glm::ivec3 clipped{0};
  int samples = 0;
};

}  // namespace

void ApplySignalNoise(const SignalNoise& noise, double exposure, std::span<DiffuseSample> samples) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  const RoughLight light = FindRoughLight(samples);
  const glm::dvec3 sun = exposure * light.sun_rgb;
  const glm::dvec3 sky = exposure * light.sky_rgb;
  const auto signal_of = [&](const DiffuseSample& sample) {
    glm::dvec3 signal = sun * sample.sun_transport_rgb;
    for (int c = 0; c < 3; ++c) signal[c] += sky[c] * MeanSkyTransport(sample, c);
    return signal;
  };
  std::map<std::pair<std::int32_t, bool>, Group> groups;
  const auto group_of = [&](const DiffuseSample& sample) -> Group& {
    return groups[{sample.plane, SunShare(sample, 1) > light.sunlit_from_share}];
  };
  for (const DiffuseSample& sample : samples) {
    Group& group = group_of(sample);
    group.signal += signal_of(sample);
    for (int c = 0; c < 3; ++c) {
      group.clipped[c] += std::isinf(sample.radiance_stddev_rgb[c]) ? 1 : 0;
    }
    ++group.samples;
  }
  for (DiffuseSample& sample : samples) {
    const glm::dvec3 signal = signal_of(sample);
    const Group& group = group_of(sample);
    for (int c = 0; c < 3; ++c) {
      double& stddev = sample.radiance_stddev_rgb[c];
      const double mean = group.signal[c] / group.samples;
      const double of_pixel = std::sqrt(noise.Variance(c, mean));
      const bool may_be_clipped = std::isinf(stddev) ||
                                  group.clipped[c] > kMostClipped * group.samples ||
                                  signal[c] * (1.0 + kReachOfModel) +
                                          kReachOfNoise * std::sqrt(noise.Variance(c, signal[c])) >=
                                      noise.ClippedFrom(c);
      const bool may_be_black = !(mean > kReachOfNoise * of_pixel);
      stddev = may_be_clipped || may_be_black
                   ? kUnknown
                   : of_pixel / mean * signal[c] /
                         (exposure * std::sqrt(static_cast<double>(sample.pixels)));
    }
  }
}

}  // namespace pleinair
