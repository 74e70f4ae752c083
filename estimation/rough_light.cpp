#include "estimation/rough_light.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "scene/upper_median.h"

namespace pleinair {
namespace {

// Least difference between the deciles of the sun's share of the samples' transport. With less, sun
// and sky are assumed to change together.
constexpr double kLeastSpreadOfShares = 0.1;
constexpr int kRounds = 3;

// Light of one channel.
struct ChannelLight {
  double sun = 0.0;
  double sky = 0.0;
  double sunlit_from_share = 1.0;
};

// The light from medians over the samples with little sun and over those with much.
class MedianLight {
 public:
  ChannelLight Find(std::span<const DiffuseSample> samples, int channel) {
    witnesses_.clear();
    values_.clear();
    for (const DiffuseSample& sample : samples) {
      const Witness witness{sample.radiance_rgb[channel],
                            sample.sun_transport_rgb[channel],
                            MeanSkyTransport(sample, channel)};
      if (!(witness.sun + witness.sky > 0.0) || !std::isfinite(witness.radiance)) continue;
      witnesses_.push_back(witness);
      values_.push_back(witness.SunShare());
    }
    if (witnesses_.empty()) return {};
    const double low = Quantile(0.1);
    const double high = Quantile(0.9);
    ChannelLight light;
    if (!(high - low > kLeastSpreadOfShares)) {
      light.sun = light.sky = Median(-1.0, 2.0, [](const Witness& witness) {
        return witness.radiance / (witness.sun + witness.sky);
      });
      return light;
    }
    const double split = 0.5 * (low + high);
    light.sunlit_from_share = split;
    for (int round = 0; round < kRounds; ++round) {
      light.sky = Median(-1.0, split, [&](const Witness& witness) {
        return witness.sky > 0.0 ? (witness.radiance - light.sun * witness.sun) / witness.sky : 0.0;
      });
      light.sun = Median(split, 2.0, [&](const Witness& witness) {
        return (witness.radiance - light.sky * witness.sky) / witness.sun;
      });
    }
    return light;
  }

 private:
  struct Witness {
    double radiance;
    double sun;
    double sky;
    double SunShare() const { return sun / (sun + sky); }
  };
  std::vector<Witness> witnesses_;
  std::vector<double> values_;

  double Quantile(double part) {
    const auto place = values_.begin() + std::lround(part * double(values_.size() - 1));
    std::nth_element(values_.begin(), place, values_.end());
    return *place;
  }

  // Over those whose share of the sun is in (above, up_to]; not below 0.
  template <typename Value>
  double Median(double above, double up_to, const Value& value) {
    values_.clear();
    for (const Witness& witness : witnesses_) {
      const double share = witness.SunShare();
      if (share > above && share <= up_to) values_.push_back(value(witness));
    }
    return values_.empty() ? 0.0 : std::max(0.0, UpperMedianInPlace(values_));
  }
};

}  // namespace

double MeanSkyTransport(const DiffuseSample& sample, int channel) {
  double sum = 0.0;
  int shapes = 0;
  for (const glm::dvec3& transport : sample.sky_transport_rgb) {
    sum += transport[channel];
    shapes += transport[channel] > 0.0 ? 1 : 0;
  }
  return shapes > 0 ? sum / shapes : 0.0;
}

double SunShare(const DiffuseSample& sample, int channel) {
  const double sun = sample.sun_transport_rgb[channel];
  const double sum = sun + MeanSkyTransport(sample, channel);
  return sum > 0.0 ? sun / sum : 0.0;
}

RoughLight FindRoughLight(std::span<const DiffuseSample> samples) {
  MedianLight medians;
  RoughLight rough;
  for (int c = 0; c < 3; ++c) {
    const ChannelLight light = medians.Find(samples, c);
    rough.sun_rgb[c] = light.sun;
    rough.sky_rgb[c] = light.sky;
    if (c == 1) rough.sunlit_from_share = light.sunlit_from_share;
  }
  return rough;
}

}  // namespace pleinair
