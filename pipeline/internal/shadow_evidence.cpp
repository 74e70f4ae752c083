#include "pipeline/internal/shadow_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "scene/upper_median.h"

namespace pleinair {
namespace {

// A pixel counts by its distance from its state's level in log radiance, up to this. Lit and shaded
// are about 1.2 apart (3.5 : 1); a pixel farther than half of that shows something else.
constexpr double kLargestMisfit = 0.6;
// A plane is used when each of its states has this many pixels.
constexpr std::size_t kLeastEvidencePixels = 12;
// Quarters of sun with which a pixel counts as plainly lit or shaded.
constexpr int kLit = 4;
constexpr int kShaded = 0;
// Under an overcast sky a corner's pixels differ by the sky that they see; sun through thin cloud
// makes this ratio and more.
constexpr double kLeastContrast = 0.34;  // log 1.4
// Levels stand apart by so many spreads. A plane whose brightness runs evenly from dark to bright,
// as under an overcast sky, split in the middle: medians half its range apart, spread 0.19 of
// it: 2.7.
constexpr double kLeastSeparation = 3.0;
// Texture and noise of even the smoothest plane.
constexpr double kLeastSpread = 0.08;
// Share of pixels that show what the mesh lacks, and the span of log radiance that they fall in.
constexpr double kOutlierShare = 0.1;
constexpr double kOutlierSpan = 3.0;
// Neighbouring pixels share errors (texture, blur, mesh edges): a tile counts for no more than this
// many independent ones.
constexpr double kMostIndependentPixels = 16.0;
// Tiles that prefer no candidate by this much say nothing.
constexpr double kLeastLogLikelihoodRange = 0.5;

std::vector<std::vector<std::size_t>> PixelsByPlane(const ShadowPicture& picture) {
  std::map<std::uint32_t, std::vector<std::size_t>> planes;
  for (std::size_t i = 0; i < picture.Size(); ++i) planes[picture.plane[i]].push_back(i);
  std::vector<std::vector<std::size_t>> result;
  result.reserve(planes.size());
  for (auto& [plane, pixels] : planes) result.push_back(std::move(pixels));
  return result;
}

struct Levels {
  double lit = 0.0;
  double shaded = 0.0;
};

// None where a state has too few pixels, or shade is as bright as sun.
std::optional<Levels> LevelsUnder(const ShadowPicture& picture,
                                  const std::vector<std::size_t>& plane,
                                  std::size_t candidate) {
  std::vector<double> lit;
  std::vector<double> shaded;
  for (const std::size_t i : plane) {
    const int quarters = picture.shares[i * picture.candidates + candidate];
    if (quarters == kLit) lit.push_back(picture.log_radiance[i]);
    if (quarters == kShaded) shaded.push_back(picture.log_radiance[i]);
  }
  if (lit.size() < kLeastEvidencePixels || shaded.size() < kLeastEvidencePixels)
    return std::nullopt;
  const Levels levels{UpperMedianInPlace(lit), UpperMedianInPlace(shaded)};
  if (levels.lit - levels.shaded < kLeastContrast) return std::nullopt;
  return levels;
}

double NormalDensity(double distance, double sigma) {
  const double z = distance / sigma;
  return std::exp(-0.5 * z * z) / (sigma * std::sqrt(2.0 * std::numbers::pi));
}

// Spread of the plainly lit and plainly shaded pixels around their levels.
double SpreadAround(const Levels& levels,
                    const ShadowPicture& picture,
                    const std::vector<std::size_t>& plane,
                    std::size_t candidate) {
  std::vector<double> distances;
  for (const std::size_t i : plane) {
    const int quarters = picture.shares[i * picture.candidates + candidate];
    if (quarters == kLit) distances.push_back(std::abs(picture.log_radiance[i] - levels.lit));
    if (quarters == kShaded) distances.push_back(std::abs(picture.log_radiance[i] - levels.shaded));
  }
  constexpr double kSigmaOfMedianDistance = 1.4826;
  return std::max(kLeastSpread, kSigmaOfMedianDistance * UpperMedianInPlace(distances));
}

// Whether the pixel whose shares start at `first` has sun under some candidates only.
bool Changes(std::span<const std::vector<std::uint8_t>> raised_shares,
             std::size_t first,
             std::size_t candidates) {
  const std::uint8_t reference = raised_shares.front()[first];
  for (const std::vector<std::uint8_t>& shares : raised_shares) {
    for (std::size_t k = 0; k < candidates; ++k) {
      if (shares[first + k] != reference) return true;
    }
  }
  return false;
}

std::vector<double> LogMeanOverElevations(const std::vector<double>& log_likelihood,
                                          std::size_t candidates) {
  const double top = *std::max_element(log_likelihood.begin(), log_likelihood.end());
  std::vector<double> result(candidates, 0.0);
  for (std::size_t i = 0; i < log_likelihood.size(); ++i) {
    result[i % candidates] += std::exp(log_likelihood[i] - top);
  }
  for (double& value : result) {
    value = std::log(value * double(candidates) / double(log_likelihood.size()) + 1e-30);
  }
  return result;
}

}  // namespace

std::vector<double> MisfitByCandidate(const ShadowPicture& picture) {
  const std::size_t candidates = picture.candidates;
  std::vector<double> misfit(candidates, 0.0);
  for (const std::vector<std::size_t>& plane : PixelsByPlane(picture)) {
    std::vector<double> values;
    values.reserve(plane.size());
    for (const std::size_t i : plane) values.push_back(picture.log_radiance[i]);
    const double middle = UpperMedianInPlace(values);
    for (std::size_t k = 0; k < candidates; ++k) {
      const Levels levels = LevelsUnder(picture, plane, k).value_or(Levels{middle, middle});
      for (const std::size_t i : plane) {
        const double share = 0.25 * picture.shares[i * candidates + k];
        const double y = picture.log_radiance[i];
        misfit[k] += share * std::min(std::abs(y - levels.lit), kLargestMisfit) +
                     (1.0 - share) * std::min(std::abs(y - levels.shaded), kLargestMisfit);
      }
    }
  }
  return misfit;
}

double BluenessOfShade(const ShadowPicture& picture, std::size_t candidate) {
  double sum = 0.0;
  double weights = 0.0;
  for (const std::vector<std::size_t>& plane : PixelsByPlane(picture)) {
    std::vector<double> lit;
    std::vector<double> shaded;
    for (const std::size_t i : plane) {
      const int quarters = picture.shares[i * picture.candidates + candidate];
      if (!std::isfinite(picture.log_blue_over_red[i])) continue;
      if (quarters == kLit) lit.push_back(picture.log_blue_over_red[i]);
      if (quarters == kShaded) shaded.push_back(picture.log_blue_over_red[i]);
    }
    const std::size_t fewer = std::min(lit.size(), shaded.size());
    if (fewer < kLeastEvidencePixels) continue;
    sum += static_cast<double>(fewer) * (UpperMedianInPlace(shaded) - UpperMedianInPlace(lit));
    weights += static_cast<double>(fewer);
  }
  return weights > 0.0 ? sum / weights : 0.0;
}

double AgreementOfStates(const ShadowPicture& picture, std::size_t candidate) {
  std::array<double, 2> all{};
  std::array<double, 2> agree{};
  for (const std::vector<std::size_t>& plane : PixelsByPlane(picture)) {
    const std::optional<Levels> levels = LevelsUnder(picture, plane, candidate);
    if (!levels) continue;
    for (const std::size_t i : plane) {
      const int quarters = picture.shares[i * picture.candidates + candidate];
      if (quarters != kLit && quarters != kShaded) continue;
      const bool lit = quarters == kLit;
      const bool looks_lit = picture.log_radiance[i] > 0.5 * (levels->lit + levels->shaded);
      all[lit] += 1.0;
      agree[lit] += looks_lit == lit ? 1.0 : 0.0;
    }
  }
  if (all[0] == 0.0 || all[1] == 0.0) return 0.0;
  return std::min(agree[0] / all[0], agree[1] / all[1]);
}

PictureEvidence EvidenceNear(const ShadowPicture& picture,
                             std::size_t candidate,
                             std::span<const std::vector<std::uint8_t>> raised_shares) {
  const std::size_t candidates = picture.candidates;
  const std::size_t raised = raised_shares.size();
  struct Sum {
    std::vector<double> log_likelihood;
    double changing = 0.0;
  };
  std::map<std::uint32_t, Sum> tiles;
  std::vector<double> contrasts;
  PictureEvidence result;
  for (const std::vector<std::size_t>& plane : PixelsByPlane(picture)) {
    const std::optional<Levels> levels = LevelsUnder(picture, plane, candidate);
    if (!levels) continue;
    const double spread = SpreadAround(*levels, picture, plane, candidate);
    if (levels->lit - levels->shaded < kLeastSeparation * spread) continue;
    result.sunlit = true;
    for (const std::size_t i : plane) {
      if (!Changes(raised_shares, i * candidates, candidates)) continue;
      contrasts.push_back(levels->lit - levels->shaded);
      const double y = picture.log_radiance[i];
      const double if_lit = NormalDensity(y - levels->lit, spread);
      const double if_shaded = NormalDensity(y - levels->shaded, spread);
      Sum& tile = tiles[picture.tile[i]];
      tile.log_likelihood.resize(raised * candidates, 0.0);
      tile.changing += 1.0;
      // Shares of sun come in quarters: five logarithms serve all.
      std::array<double, 5> of_share{};
      for (std::size_t q = 0; q < of_share.size(); ++q) {
        const double share = 0.25 * double(q);
        const double seen = share * if_lit + (1.0 - share) * if_shaded;
        of_share[q] = std::log((1.0 - kOutlierShare) * seen + kOutlierShare / kOutlierSpan);
      }
      for (std::size_t e = 0; e < raised; ++e) {
        const std::uint8_t* quarters = &raised_shares[e][i * candidates];
        double* sum = &tile.log_likelihood[e * candidates];
        for (std::size_t k = 0; k < candidates; ++k) {
          sum[k] += of_share[quarters[k]];
        }
      }
    }
  }
  if (!contrasts.empty()) result.contrast = std::exp(UpperMedianInPlace(contrasts));
  for (auto& [tile, sum] : tiles) {
    const double weight = std::min(1.0, kMostIndependentPixels / sum.changing);
    for (double& value : sum.log_likelihood) value *= weight;
    std::vector<double> of_azimuth = LogMeanOverElevations(sum.log_likelihood, candidates);
    const auto [low, high] = std::minmax_element(of_azimuth.begin(), of_azimuth.end());
    if (*high - *low < kLeastLogLikelihoodRange) continue;
    result.tiles.push_back({tile, std::move(of_azimuth)});
  }
  return result;
}

}  // namespace pleinair
