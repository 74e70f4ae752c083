#include "pipeline/tradeoff.h"

#include <algorithm>

#include "datasets/statistics.h"

namespace pleinair {
namespace {

struct Medians {
  double error;
  double time_ms;
};

bool Beats(const Medians& a, const Medians& b) {
  return a.error <= b.error && a.time_ms <= b.time_ms &&
         (a.error < b.error || a.time_ms < b.time_ms);
}

}  // namespace

std::optional<Spread> SpreadOf(std::span<const double> values) {
  if (values.empty()) return std::nullopt;
  const auto [smallest, largest] = std::minmax_element(values.begin(), values.end());
  return Spread{Percentile({values.begin(), values.end()}, 0.5), *smallest, *largest};
}

std::vector<FrontPlace> PlacesOnFront(std::span<const TradeoffPoint> points) {
  std::vector<std::optional<Medians>> medians;
  for (const TradeoffPoint& point : points) {
    const auto error = SpreadOf(point.error);
    const auto time_ms = SpreadOf(point.time_ms);
    medians.push_back(error && time_ms ? std::optional(Medians{error->median, time_ms->median})
                                       : std::nullopt);
  }
  std::vector<FrontPlace> places(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    FrontPlace& place = places[i];
    if (!medians[i]) {
      place.on_front = false;
      continue;
    }
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (!medians[k] || !Beats(*medians[k], *medians[i])) continue;
      place.on_front = false;
      if (!place.beaten_by || medians[k]->error < medians[*place.beaten_by]->error) {
        place.beaten_by = k;
      }
    }
    if (!place.beaten_by) continue;
    const std::vector<double>& other = points[*place.beaten_by].error;
    place.seeds = static_cast<int>(std::min(other.size(), points[i].error.size()));
    for (int s = 0; s < place.seeds; ++s) {
      const auto seed = static_cast<std::size_t>(s);
      place.seeds_beaten += other[seed] < points[i].error[seed] ? 1 : 0;
    }
  }
  return places;
}

}  // namespace pleinair
