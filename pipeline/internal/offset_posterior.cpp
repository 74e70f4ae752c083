#include "pipeline/internal/offset_posterior.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "sunmodel/angles.h"

namespace pleinair {
namespace {

// Scatter of the tiles, from the sun's angular radius to a useless mesh; evenly in its logarithm.
constexpr std::array<double, 8> kScattersDeg = {0.3, 0.5, 0.8, 1.2, 1.8, 2.7, 4.0, 6.0};
// Share of the tiles that show what the mesh lacks.
constexpr std::array<double, 5> kOutlierShares = {0.05, 0.15, 0.3, 0.5, 0.7};
constexpr std::size_t kModels = kScattersDeg.size() * kOutlierShares.size();

// Terms of every model and candidate: [model * grid.Size() + candidate].
using LogTerms = std::vector<double>;

// Tiles' likelihood blurred by their scatter: row d holds the weights of what a tile sees.
std::vector<double> BlurMatrix(const OffsetGrid& grid, double scatter_rad) {
  const std::size_t n = grid.Size();
  std::vector<double> blur(n * n);
  for (std::size_t d = 0; d < n; ++d) {
    double sum = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      const double z = (grid.OffsetRad(k) - grid.OffsetRad(d)) / scatter_rad;
      sum += blur[d * n + k] = std::exp(-0.5 * z * z);
    }
    for (std::size_t k = 0; k < n; ++k) blur[d * n + k] /= sum;
  }
  return blur;
}

LogTerms TermsOf(const OffsetUnit& unit, std::span<const std::vector<double>> blurs) {
  const std::size_t n = unit.log_likelihood.size();
  const double top = *std::max_element(unit.log_likelihood.begin(), unit.log_likelihood.end());
  std::vector<double> likelihood;
  double mean = 0.0;
  for (const double value : unit.log_likelihood) {
    likelihood.push_back(std::exp(value - top));
    mean += likelihood.back() / double(n);
  }
  LogTerms terms;
  terms.reserve(kModels * n);
  std::vector<double> seen(n);
  for (const std::vector<double>& blur : blurs) {
    for (std::size_t d = 0; d < n; ++d) {
      seen[d] = 0.0;
      for (std::size_t k = 0; k < n; ++k) seen[d] += blur[d * n + k] * likelihood[k];
    }
    for (const double share : kOutlierShares) {
      for (std::size_t d = 0; d < n; ++d) {
        terms.push_back(std::log((1.0 - share) * seen[d] + share * mean));
      }
    }
  }
  return terms;
}

// Over the candidates, models integrated out; adds up to 1.
std::vector<double> Density(const LogTerms& terms, std::size_t candidates) {
  const double top = *std::max_element(terms.begin(), terms.end());
  std::vector<double> density(candidates, 0.0);
  double sum = 0.0;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const double value = std::exp(terms[i] - top);
    density[i % candidates] += value;
    sum += value;
  }
  for (double& value : density) value /= sum;
  return density;
}

struct Moments {
  double mean_rad = 0.0;
  double stddev_rad = 0.0;
};

Moments MomentsOf(const std::vector<double>& density, const OffsetGrid& grid) {
  Moments moments;
  for (std::size_t k = 0; k < density.size(); ++k) {
    moments.mean_rad += density[k] * grid.OffsetRad(k);
  }
  double variance = 0.0;
  for (std::size_t k = 0; k < density.size(); ++k) {
    const double distance = grid.OffsetRad(k) - moments.mean_rad;
    variance += density[k] * distance * distance;
  }
  moments.stddev_rad = std::sqrt(variance);
  const auto peak = std::max_element(density.begin(), density.end());
  if (moments.stddev_rad >= grid.step_rad || peak == density.begin() || peak + 1 == density.end()) {
    return moments;
  }
  // Narrower than the grid: the normal distribution through the logarithms at the peak and its
  // neighbours.
  const auto log_of = [](double value) { return std::log(std::max(value, 1e-300)); };
  const double before = log_of(peak[-1]) - log_of(peak[0]);
  const double after = log_of(peak[1]) - log_of(peak[0]);
  const double curvature = before + after;
  if (!(curvature < 0.0)) return moments;
  moments.mean_rad = grid.OffsetRad(static_cast<std::size_t>(peak - density.begin())) +
                     0.5 * grid.step_rad * (before - after) / curvature;
  moments.stddev_rad = grid.step_rad / std::sqrt(-curvature);
  return moments;
}

LogTerms Sum(const LogTerms& a, const LogTerms& b, double sign) {
  LogTerms sum = a;
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += sign * b[i];
  return sum;
}

// Jackknife over groups of unequal weight (Busing et al., Statistics and Computing 9, 1999, would
// weigh them; here: the plain one, which errs to the large side).
double LeaveOneOutStddev(const std::map<std::size_t, LogTerms>& groups,
                         const LogTerms& all,
                         const OffsetGrid& grid) {
  if (groups.size() < 2) return 0.0;
  std::vector<double> means;
  double middle = 0.0;
  for (const auto& [group, terms] : groups) {
    means.push_back(MomentsOf(Density(Sum(all, terms, -1.0), grid.Size()), grid).mean_rad);
    middle += means.back() / double(groups.size());
  }
  double squares = 0.0;
  for (const double mean : means) squares += (mean - middle) * (mean - middle);
  return std::sqrt(squares * double(groups.size() - 1) / double(groups.size()));
}

}  // namespace

OffsetPosterior CombineUnits(std::span<const OffsetUnit> units,
                             std::size_t frames,
                             const OffsetGrid& grid) {
  std::vector<std::vector<double>> blurs;
  blurs.reserve(kScattersDeg.size());
  for (const double scatter_deg : kScattersDeg) {
    blurs.push_back(BlurMatrix(grid, RadFromDeg(scatter_deg)));
  }
  const LogTerms nothing(kModels * grid.Size(), 0.0);
  const auto add =
      [&](std::map<std::size_t, LogTerms>& groups, std::size_t group, const LogTerms& terms) {
        LogTerms& sum = groups.try_emplace(group, nothing).first->second;
        sum = Sum(sum, terms, 1.0);
      };
  std::map<std::size_t, LogTerms> by_frame;
  std::map<std::size_t, LogTerms> by_block;
  std::vector<std::map<std::size_t, LogTerms>> by_block_of_frame(frames);
  for (const OffsetUnit& unit : units) {
    const LogTerms terms = TermsOf(unit, blurs);
    add(by_frame, unit.frame, terms);
    add(by_block, unit.block, terms);
    add(by_block_of_frame[unit.frame], unit.block, terms);
  }
  const auto estimate = [&](const LogTerms& terms) {
    const Moments moments = MomentsOf(Density(terms, grid.Size()), grid);
    return OffsetEstimate{moments.mean_rad, moments.stddev_rad, 0.0};
  };
  OffsetPosterior posterior;
  LogTerms all = nothing;
  for (const auto& [frame, terms] : by_frame) all = Sum(all, terms, 1.0);
  const std::vector<double> density = Density(all, grid.Size());
  posterior.peak =
      static_cast<std::size_t>(std::max_element(density.begin(), density.end()) - density.begin());
  posterior.all = estimate(all);
  posterior.all.spread_stddev_rad =
      std::max(LeaveOneOutStddev(by_frame, all, grid), LeaveOneOutStddev(by_block, all, grid));
  for (std::size_t f = 0; f < frames; ++f) {
    const auto found = by_frame.find(f);
    const LogTerms& terms = found == by_frame.end() ? nothing : found->second;
    posterior.frames.push_back(estimate(terms));
    posterior.frames.back().spread_stddev_rad =
        LeaveOneOutStddev(by_block_of_frame[f], terms, grid);
  }
  return posterior;
}

}  // namespace pleinair
