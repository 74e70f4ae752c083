#include "estimation/light_change.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <tuple>
#include <utility>

#include "estimation/internal/square.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

using estimation_internal::Square;

constexpr std::size_t kLeastPlaces = 30;  // With fewer the scatter itself is chance.
constexpr std::size_t kEnoughPlaces = 200;
// Larger relative deviations between the two frames come from surfaces that are not the same.
constexpr double kMostScatter = 0.25;
// Pixels of one picture are read to about this, whatever their noise.
constexpr double kLeastScatter = 0.003;
// Neighbouring places err together: these many count as one. With it two deviations hold in 95 % of
// the test's pairs.
constexpr double kPlacesInOne = 4.0;
// The prior's deviation over what is seen to change, and without a change. Assumed: no light
// changes by more than some three times what the places in the sun, or the others, show of it.
constexpr double kPriorOverSeen = 3.0;
constexpr double kPriorOfUnchanged = 0.003;
constexpr double kLeastPrior = 1e-4;  // Share of all light.
// Standard deviation, relative: under guessed albedos, whose light is 5 and 15 % off, a quarter of
// a large change is the most.
constexpr double kErrorOfChange = 0.1;
// Least mean of the weights: of an undisturbed pair they are 0.85.
constexpr double kLeastUsed = 0.4;

// From the last light to the region that Tukey's weights hold.
constexpr int kRoundsOfAbsolute = 6;
constexpr int kRoundsOfTukey = 3;
constexpr double kTukeyWidth = 4.685;
constexpr double kNormalOverMad = 1.4826;

// Two unknowns: sun and sky.
struct Light {
  double sun = 0.0;
  double sky = 0.0;
};

// One place in one channel: row * (light after) = target, relative to the larger of the target and
// what the last light gives there.
struct Row {
  double sun = 0.0;
  double sky = 0.0;
  double target = 0.0;
  double Residual(const Light& light) const { return sun * light.sun + sky * light.sky - target; }
};

struct Pair {
  const DiffuseSample* before;
  const DiffuseSample* after;
};

struct Solution {
  Light light;
  Light stddev;
  double covariance = 0.0;
};

auto PlaceOf(const DiffuseSample& sample) {
  return std::tie(sample.place_world_m.x, sample.place_world_m.y, sample.place_world_m.z);
}

bool CanCompare(const DiffuseSample& sample) {
  return !sample.is_rejected && sample.weight > 0.0 &&
         std::isfinite(MeanOf(sample.radiance_stddev_rgb)) &&
         std::min({sample.radiance_rgb.r, sample.radiance_rgb.g, sample.radiance_rgb.b}) > 0.0;
}

// In the order of their places.
std::vector<const DiffuseSample*> ByPlace(std::span<const DiffuseSample> samples) {
  std::vector<const DiffuseSample*> sorted;
  sorted.reserve(samples.size());
  for (const DiffuseSample& sample : samples) sorted.push_back(&sample);
  std::stable_sort(
      sorted.begin(), sorted.end(), [](const DiffuseSample* a, const DiffuseSample* b) {
        return PlaceOf(*a) < PlaceOf(*b);
      });
  return sorted;
}

bool AreOfSamePlaces(std::span<const DiffuseSample> before, std::span<const DiffuseSample> after) {
  return std::equal(
      before.begin(),
      before.end(),
      after.begin(),
      after.end(),
      [](const DiffuseSample& a, const DiffuseSample& b) { return PlaceOf(a) == PlaceOf(b); });
}

// Samples at the same places that can be compared.
std::vector<Pair> PairsOf(std::span<const DiffuseSample> before,
                          std::span<const DiffuseSample> after) {
  std::vector<Pair> pairs;
  pairs.reserve(std::min(before.size(), after.size()));
  const auto add = [&pairs](const DiffuseSample& a, const DiffuseSample& b) {
    if (CanCompare(a) && CanCompare(b)) pairs.push_back({&a, &b});
  };
  if (AreOfSamePlaces(before, after)) {  // As of a camera that stands still.
    for (std::size_t i = 0; i < before.size(); ++i) add(before[i], after[i]);
    return pairs;
  }
  const std::vector<const DiffuseSample*> old_ones = ByPlace(before);
  const std::vector<const DiffuseSample*> new_ones = ByPlace(after);
  for (std::size_t i = 0, j = 0; i < old_ones.size() && j < new_ones.size();) {
    if (PlaceOf(*old_ones[i]) < PlaceOf(*new_ones[j])) {
      ++i;
    } else if (PlaceOf(*new_ones[j]) < PlaceOf(*old_ones[i])) {
      ++j;
    } else {
      add(*old_ones[i++], *new_ones[j++]);
    }
  }
  return pairs;
}

// Keeps every second, third, ... of more than are needed.
void Thin(std::vector<Pair>& pairs) {
  const std::size_t step = pairs.size() / kEnoughPlaces;
  if (step < 2) return;
  for (std::size_t i = 0; i * step < pairs.size(); ++i) pairs[i] = pairs[i * step];
  pairs.resize((pairs.size() + step - 1) / step);
}

// The change in one channel.
class ChannelChange {
 public:
  ChannelChange(std::span<const Pair> pairs, const Lighting& last, int channel) {
    before_ = {last.sun.irradiance_rgb[channel], last.SkyIrradianceRgb()[channel]};
    // The sky is one unknown, with the last light's mix of shapes; equal parts without light.
    std::array<double, kMaxSkyShapes> mix{};
    for (std::size_t k = 0; k < last.sky.size(); ++k) {
      mix[k] = before_.sky > 0.0 ? last.sky[k].irradiance_rgb[channel] / before_.sky
                                 : 1.0 / static_cast<double>(last.sky.size());
    }
    const auto sky_transport = [&](const DiffuseSample& sample) {
      double sum = 0.0;
      for (std::size_t k = 0; k < last.sky.size(); ++k) {
        sum += mix[k] * sample.sky_transport_rgb[k][channel];
      }
      return sum;
    };
    rows_.reserve(pairs.size());
    for (const auto& [before, after] : pairs) {
      const double expected_before =
          before->sun_transport_rgb[channel] * before_.sun + sky_transport(*before) * before_.sky;
      Row row{after->sun_transport_rgb[channel], sky_transport(*after), 0.0};
      row.target = after->radiance_rgb[channel] * expected_before / before->radiance_rgb[channel];
      const double scale = std::max(row.target, row.target + row.Residual(before_));
      row = scale > 0.0 && std::isfinite(scale)
                ? Row{row.sun / scale, row.sky / scale, row.target / scale}
                : Row{};  // Says nothing, and keeps the place of its pair.
      rows_.push_back(row);
    }
    SetPrior(pairs);
  }

  const Light& Before() const { return before_; }

  // Finds the weight of each pair, and returns the deviation of a residual.
  double Reweight(std::vector<double>& weights) const {
    weights.assign(rows_.size(), 1.0);
    Light light = before_;
    double scale = 1.0;
    std::vector<double> residuals(rows_.size());
    for (int round = 0; round < kRoundsOfAbsolute + kRoundsOfTukey; ++round) {
      std::transform(rows_.begin(), rows_.end(), residuals.begin(), [&light](const Row& row) {
        return std::abs(row.Residual(light));
      });
      scale = std::max(kLeastScatter, kNormalOverMad * UpperMedianInPlace(residuals));
      for (std::size_t i = 0; i < rows_.size(); ++i) {
        const double far = std::abs(rows_[i].Residual(light)) / scale;
        weights[i] = round < kRoundsOfAbsolute
                         ? 1.0 / std::max(1.0, far)
                         : Square(std::max(0.0, 1.0 - Square(far / kTukeyWidth)));
      }
      light = Solve(weights, scale).light;
    }
    return scale;
  }

  Solution Solve(std::span<const double> weights, double scale) const {
    const double of_one = 1.0 / (kPlacesInOne * Square(scale));
    double a = 1.0 / Square(prior_stddev_.sun);
    double b = 0.0;
    double c = 1.0 / Square(prior_stddev_.sky);
    double u = before_.sun * a;
    double v = before_.sky * c;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Row& row = rows_[i];
      const double weight = of_one * weights[i];
      a += weight * row.sun * row.sun;
      b += weight * row.sun * row.sky;
      c += weight * row.sky * row.sky;
      u += weight * row.sun * row.target;
      v += weight * row.sky * row.target;
    }
    const double determinant = a * c - b * b;
    if (!(determinant > 0.0)) return {before_, prior_stddev_};
    return {{std::max(0.0, (c * u - b * v) / determinant),
             std::max(0.0, (a * v - b * u) / determinant)},
            {std::sqrt(c / determinant), std::sqrt(a / determinant)},
            -b / determinant};
  }

 private:
  Light before_;
  Light prior_stddev_;
  std::vector<Row> rows_;

  // As wide as the median change of the places in the sun, or of those in the shade, whichever is
  // more.
  void SetPrior(std::span<const Pair> pairs) {
    double seen = 0.0;
    std::vector<double> changes;
    for (const bool lit : {false, true}) {
      changes.clear();
      for (std::size_t i = 0; i < rows_.size(); ++i) {
        if (pairs[i].after->is_lit == lit) changes.push_back(rows_[i].Residual(before_));
      }
      seen = std::max(seen, std::abs(UpperMedianInPlace(changes)));
    }
    const double level = before_.sun + before_.sky;
    const double share = kPriorOfUnchanged + kPriorOverSeen * seen;
    // A sun behind clouds may come out.
    prior_stddev_.sun =
        kPriorOfUnchanged * before_.sun + kPriorOverSeen * seen * level + kLeastPrior * level;
    prior_stddev_.sky = share * before_.sky + kLeastPrior * level;
  }
};

}  // namespace

std::optional<LightChange> LightChangeWatch::Compare(std::span<const DiffuseSample> samples,
                                                     const Lighting& lighting) {
  const std::vector<DiffuseSample> last_samples =
      std::exchange(last_samples_, std::vector<DiffuseSample>(samples.begin(), samples.end()));
  const Lighting last = std::exchange(last_lighting_, lighting);
  std::vector<Pair> pairs;
  if (last.sky.size() == lighting.sky.size()) pairs = PairsOf(last_samples, samples);
  Thin(pairs);
  const glm::dvec3 level = last.sun.irradiance_rgb + last.SkyIrradianceRgb();
  const double least = std::min({level.r, level.g, level.b});
  if (pairs.size() < kLeastPlaces || !(least > 0.0) || !std::isfinite(MeanOf(level))) {
    return std::nullopt;
  }

  // Green has the least noise of most cameras, and surfaces that are not the same differ in it.
  std::vector<double> weights;
  const double scatter = ChannelChange(pairs, last, 1).Reweight(weights);
  const double used = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (scatter > kMostScatter || used < kLeastUsed * static_cast<double>(pairs.size())) {
    return std::nullopt;
  }
  LightChange change;
  for (int c = 0; c < 3; ++c) {
    const ChannelChange channel(pairs, last, c);
    const Solution solution = channel.Solve(weights, scatter);
    change.sun_before_rgb[c] = channel.Before().sun;
    change.sky_before_rgb[c] = channel.Before().sky;
    change.sun_after_rgb[c] = solution.light.sun;
    change.sky_after_rgb[c] = solution.light.sky;
    // The last light's errors stay in the division of each place's error between sun and sky.
    const Light& before = channel.Before();
    change.sun_stddev_rgb[c] =
        std::hypot(solution.stddev.sun, kErrorOfChange * (solution.light.sun - before.sun));
    change.sky_stddev_rgb[c] =
        std::hypot(solution.stddev.sky, kErrorOfChange * (solution.light.sky - before.sky));
    change.covariance_rgb[c] = solution.covariance;
  }
  return change;
}

}  // namespace pleinair
