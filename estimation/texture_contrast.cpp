#include "estimation/texture_contrast.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "scene/upper_median.h"

namespace pleinair {
namespace {

// Below, the median is chance.
constexpr std::size_t kLeastSquares = 60;
// A median over this many is accurate to 8 % of their spread.
constexpr std::size_t kEnoughSquares = 240;

constexpr int kGreenIsUnsound = kUnusable | kClipped[1];
// Largest share of a square's pixels at the noise floor: deep shadows are among its pixels, but an
// all dark square shows the camera's own grain.
constexpr double kMostNearBlack = 0.5;

// The variance of radiance over its mean's square; nullopt where a pixel of the square is outside
// the picture or unsound, or where there is no light. Every other pixel of every other row, as much
// as a standard deviation needs.
std::optional<double> RelativeVarianceAround(const Frame& frame, const glm::ivec2& pixel) {
  constexpr int kReach = kTextureWindowPx / 2;
  const RgbImage& radiance = frame.radiance;
  if (pixel.x < kReach || pixel.y < kReach || pixel.x + kReach >= radiance.width ||
      pixel.y + kReach >= radiance.height) {
    return std::nullopt;
  }
  double sum = 0.0;
  double squares = 0.0;
  double count = 0.0;
  double near_black = 0.0;
  for (int y = pixel.y - kReach; y <= pixel.y + kReach; y += 2) {
    for (int x = pixel.x - kReach; x <= pixel.x + kReach; x += 2) {
      if ((frame.unusable.At(x, y) & kGreenIsUnsound) != 0) return std::nullopt;
      near_black += (frame.unusable.At(x, y) & kNearBlack) != 0 ? 1.0 : 0.0;
      const double green = radiance.At(x, y).g;
      sum += green;
      squares += green * green;
      count += 1.0;
    }
  }
  if (near_black > kMostNearBlack * count) return std::nullopt;
  const double mean = sum / count;
  if (!(mean > 0.0) || !std::isfinite(squares)) return std::nullopt;
  return std::max(0.0, squares / count - mean * mean) / (mean * mean);
}

// 0 up to `from`, 1 from `to` on.
double Ramp(double from, double to, double value) {
  return std::clamp((value - from) / (to - from), 0.0, 1.0);
}

}  // namespace

std::optional<double> FineContrast(const Frame& frame, std::span<const DiffuseSample> samples) {
  std::vector<double> variances;
  const std::size_t stride = std::max<std::size_t>(1, samples.size() / kEnoughSquares);
  for (std::size_t i = 0; i < samples.size(); i += stride) {
    if (const auto variance = RelativeVarianceAround(frame, samples[i].pixel)) {
      variances.push_back(*variance);
    }
  }
  if (variances.size() < kLeastSquares) return std::nullopt;
  // Standard deviation of the logarithm of log-normal values.
  return std::sqrt(std::log1p(UpperMedianInPlace(variances)));
}

std::array<double, kSkyStates> LogLikelihood(const TextureContrast& contrast) {
  // In SkyState's order. Few surfaces are painted as deep as the sun's shadows are.
  static constexpr std::array<double, kSkyStates> kDeep{1.0, 1.0, 0.4, 0.1, 0.1};
  static constexpr std::array<double, kSkyStates> kNoLongerDeep{0.1, 0.1, 0.5, 1.0, 1.0};
  constexpr double kDeepFrom = 0.35;
  constexpr double kDeepTo = 0.5;
  const double deep = Ramp(kDeepFrom, kDeepTo, contrast.now);
  const double was_deep = Ramp(kDeepFrom, kDeepTo, contrast.most);
  const double lost =
      contrast.most > 0.0 ? Ramp(0.15, 0.35, 1.0 - contrast.now / contrast.most) : 0.0;
  const double no_longer = was_deep * lost * (1.0 - deep);
  std::array<double, kSkyStates> log{};
  for (std::size_t s = 0; s < log.size(); ++s) {
    log[s] = deep * std::log(kDeep[s]) + no_longer * std::log(kNoLongerDeep[s]);
  }
  return log;
}

std::optional<TextureContrast> TextureWatch::Look(const Frame& frame,
                                                  const Camera& camera,
                                                  std::span<const DiffuseSample> samples) {
  if (camera_ != camera) most_ = 0.0;
  camera_ = camera;
  const auto now = FineContrast(frame, samples);
  if (!now) return std::nullopt;
  most_ = std::max(most_, *now);
  return TextureContrast{*now, most_};
}

}  // namespace pleinair
