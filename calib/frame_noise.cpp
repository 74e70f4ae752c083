#include "calib/frame_noise.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace pleinair {
namespace {

constexpr int kBlockPx = 16;
constexpr int kBins = 16;  // Bins of the signal's square root: shot noise has one width there.
constexpr std::size_t kLeastBlocks = 6;
constexpr int kMostBlocks = 500;
// The differences of a block of noise are worth 68 independent ones (256 over the sum of the
// filter's squared autocorrelation, 3.78). Their mean square scatters by 17 %, and a quarter of all
// blocks lies below this share of the variance.
constexpr double kQuarterBelow = 0.884;

struct Block {
  double signal = 0.0;
  double variance = 0.0;
};

struct Point {
  double signal = 0.0;
  double variance = 0.0;
  double weight = 0.0;
};

// One channel's codes as light.
struct CodeLight {
  explicit CodeLight(const std::array<float, 256>& linear) {
    for (std::size_t code = 0; code < 256; ++code) {
      signal[code] = double{linear[code]};
      if (code == 0 || code == 255) continue;
      const double step = 0.5 * (double{linear[code + 1]} - double{linear[code - 1]});
      rounding[code] = step * step / 12.0;
    }
  }
  std::array<double, 256> signal{};
  std::array<double, 256> rounding{};  // Variance of rounding to the code; not of the end codes.
};

// None where a code says nothing of the light: clipped, or near black.
std::optional<Block> BlockAt(
    const Rgb8Image& codes, const CodeLight& light, int channel, int x0, int y0) {
  constexpr int kWindowPx = kBlockPx + 2;
  std::array<std::array<double, kWindowPx>, kWindowPx> window;
  double rounding = 0.0;
  for (std::size_t y = 0; y < window.size(); ++y) {
    const glm::u8vec3* row = &codes.At(x0 - 1, y0 - 1 + static_cast<int>(y));
    for (std::size_t x = 0; x < window.size(); ++x) {
      const std::size_t code = row[x][channel];
      if (code >= kClippedFromCode || code <= kNoiseFloorUpToCode) return std::nullopt;
      window[y][x] = light.signal[code];
      const bool is_inside = x > 0 && y > 0 && x <= kBlockPx && y <= kBlockPx;
      if (is_inside) rounding += light.rounding[code];
    }
  }
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t y = 1; y <= kBlockPx; ++y) {
    const auto& above = window[y - 1];
    const auto& row = window[y];
    const auto& below = window[y + 1];
    for (std::size_t x = 1; x <= kBlockPx; ++x) {
      const double beyond_slope = above[x - 1] - 2.0 * above[x] + above[x + 1] -
                                  2.0 * (row[x - 1] - 2.0 * row[x] + row[x + 1]) + below[x - 1] -
                                  2.0 * below[x] + below[x + 1];
      squares += beyond_slope * beyond_slope / 36.0;
      sum += row[x];
    }
  }
  constexpr double kPixels = double{kBlockPx} * kBlockPx;
  return Block{sum / kPixels, (squares - rounding) / kPixels};
}

// One point for each brightness that enough blocks have.
std::vector<Point> PointsOf(const std::vector<Block>& blocks) {
  std::array<std::vector<double>, kBins> variances;
  std::array<double, kBins> signals{};
  for (const Block& block : blocks) {
    const auto bin = static_cast<std::size_t>(
        std::clamp(static_cast<int>(kBins * std::sqrt(block.signal)), 0, kBins - 1));
    variances.at(bin).push_back(block.variance);
    signals.at(bin) += block.signal;
  }
  std::vector<Point> points;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    std::vector<double>& of_bin = variances.at(bin);
    if (of_bin.size() < kLeastBlocks) continue;
    const auto quarter = of_bin.begin() + static_cast<std::ptrdiff_t>(of_bin.size() / 4);
    std::nth_element(of_bin.begin(), quarter, of_bin.end());
    const double count = static_cast<double>(of_bin.size());
    points.push_back({signals.at(bin) / count, std::max(*quarter / kQuarterBelow, 0.0), count});
  }
  return points;
}

// Neither part below zero; each point counts by its relative error.
void Fit(const std::vector<Point>& points, double& of_signal, double& floor) {
  double largest = 0.0;
  for (const Point& point : points) largest = std::max(largest, point.variance);
  if (!(largest > 0.0)) return;
  double w = 0.0, ws = 0.0, wss = 0.0, wv = 0.0, wsv = 0.0;
  for (const Point& point : points) {
    const double error = point.variance + 0.1 * largest;
    const double weight = point.weight / (error * error);
    w += weight;
    ws += weight * point.signal;
    wss += weight * point.signal * point.signal;
    wv += weight * point.variance;
    wsv += weight * point.signal * point.variance;
  }
  const double determinant = w * wss - ws * ws;
  constexpr double kOneBrightness = 1e-3;
  if (determinant > kOneBrightness * w * wss) {
    of_signal = (w * wsv - ws * wv) / determinant;
    floor = (wss * wv - ws * wsv) / determinant;
    if (of_signal >= 0.0 && floor >= 0.0) return;
    if (of_signal < 0.0) {
      of_signal = 0.0;
      floor = wv / w;
      return;
    }
  }
  floor = 0.0;
  of_signal = wsv / wss;
}

}  // namespace

double FrameNoise::Variance(int channel, double signal) const {
  const auto c = static_cast<std::size_t>(channel);
  // Negated so that NaN is caught, too.
  const double inside = !(signal > 0.0) ? 0.0 : std::min(signal, 1.0);
  return of_signal.at(c) * inside + floor.at(c);
}

FrameNoise MeasureFrameNoise(const Rgb8Image& codes, const ResponseCurve& response) {
  FrameNoise noise;
  const int columns = std::max((codes.width - 2) / kBlockPx, 0);
  const int rows = std::max((codes.height - 2) / kBlockPx, 0);
  const int stride = std::max((columns * rows + kMostBlocks - 1) / kMostBlocks, 1);
  for (int channel = 0; channel < 3; ++channel) {
    const CodeLight light(response.LinearOfCode(channel));
    std::vector<Block> blocks;
    for (int i = 0; i < columns * rows; i += stride) {
      const auto block =
          BlockAt(codes, light, channel, 1 + i % columns * kBlockPx, 1 + i / columns * kBlockPx);
      if (block) blocks.push_back(*block);
    }
    const auto c = static_cast<std::size_t>(channel);
    Fit(PointsOf(blocks), noise.of_signal.at(c), noise.floor.at(c));
  }
  return noise;
}

}  // namespace pleinair
