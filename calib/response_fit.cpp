#include "calib/response_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <stdexcept>

#include <Eigen/Dense>

#include "calib/internal/exposed_pictures.h"

namespace pleinair {
namespace {

// Fewer pixels do not determine a median.
constexpr int kFewestPixels = 20;
// More do not make it surer: what is left is the scene's and the camera's own.
constexpr double kMostPixels = 400.0;

using JointHistogram =
    std::vector<std::int32_t>;  // 256 x 256: code in the brighter, in the darker.

// g at `brighter_code` is that at `darker_code`, plus log_ratio (of what reached the sensor).
struct CodePair {
  double brighter_code = 0.0;
  double darker_code = 0.0;
  double log_ratio = 0.0;
  double weight = 0.0;
};

struct CodeRange {
  int low = 0;
  int high = 0;
  bool Holds(double code) const { return code >= low && code <= high; }
};

// The median within grouped counts: a fraction of a code.
double GroupedMedian(const std::array<std::int32_t, 256>& counts, std::int64_t total) {
  const double half = 0.5 * static_cast<double>(total);
  double below = 0.0;
  for (int code = 0; code < 256; ++code) {
    const double here = counts[static_cast<std::size_t>(code)];
    if (below + here >= half) return code - 0.5 + (here > 0.0 ? (half - below) / here : 0.5);
    below += here;
  }
  return 255.0;
}

JointHistogram CountPairs(const Rgb8Image& brighter, const Rgb8Image& darker, int channel) {
  JointHistogram counts(256 * 256, 0);
  for (std::size_t i = 0; i < brighter.pixels.size(); ++i) {
    ++counts[brighter.pixels[i][channel] * 256u + darker.pixels[i][channel]];
  }
  return counts;
}

// Where the code rounds by half, light wavers by 0.5 / code or so; towards white by clipping.
double CodeWeight(double code, const CodeRange& range) {
  return std::min(code - range.low + 1.0, 0.25 * (range.high + 1.0 - code) + 1.0);
}

// The median code in the darker picture for each code in the brighter one, and not vice versa. The
// condition on a noisy code pulls the median towards codes of which the scene has more pixels, and
// the brighter picture has less noise.
void AddMedians(const JointHistogram& counts,
                const CodeRange& range,
                double log_ratio,
                std::vector<CodePair>& pairs) {
  for (int given = range.low; given <= range.high; ++given) {
    std::array<std::int32_t, 256> darker{};
    for (int code = 0; code < 256; ++code) {
      darker[static_cast<std::size_t>(code)] = counts[static_cast<std::size_t>(given * 256 + code)];
    }
    const std::int64_t total = std::accumulate(darker.begin(), darker.end(), std::int64_t{0});
    if (total < kFewestPixels) continue;
    const double median = GroupedMedian(darker, total);
    if (!range.Holds(median)) continue;
    CodePair pair;
    pair.brighter_code = given;
    pair.darker_code = median;
    pair.log_ratio = log_ratio;
    pair.weight = std::sqrt(std::min(static_cast<double>(total), kMostPixels) / kMostPixels) *
                  CodeWeight(pair.brighter_code, range) * CodeWeight(pair.darker_code, range) /
                  (CodeWeight(pair.brighter_code, range) + CodeWeight(pair.darker_code, range));
    pairs.push_back(pair);
  }
}

// Codes that occur, without those where a clipped end may have been rounded to.
CodeRange UnclippedCodes(std::span<const ExposedPicture> pictures, int channel) {
  int lowest = 255;
  int highest = 0;
  for (const ExposedPicture& picture : pictures) {
    for (const glm::u8vec3& code : picture.codes.pixels) {
      lowest = std::min<int>(lowest, code[channel]);
      highest = std::max<int>(highest, code[channel]);
    }
  }
  return {lowest + kNoiseFloorUpToCode + 1, highest - (255 - kClippedFromCode) - 1};
}

double Interpolated(const Eigen::VectorXd& g, double code) {
  const int below = std::min(static_cast<int>(code), 254);
  const double share = code - below;
  return (1.0 - share) * g[below] + share * g[below + 1];
}

// Normal equations of one channel's ln g at the 256 codes.
class LogCurveFit {
 public:
  explicit LogCurveFit(int darkest_code) : matrix_(256, 256), right_(256) {
    matrix_.setZero();
    right_.setZero();
    for (int code = 0; code < 256; ++code) {
      log_code_[static_cast<std::size_t>(code)] =
          std::log(std::max(code - darkest_code, 0) + 1.0) + 1e-2 * code;
    }
  }

  // weight^2 (g(brighter) - g(darker) - log_ratio)^2
  void Add(const CodePair& pair) {
    std::array<int, 4> at{};
    std::array<double, 4> factor{};
    const auto put = [&](std::size_t first, double code, double sign) {
      const int below = std::min(static_cast<int>(code), 254);
      const double share = code - below;
      at[first] = below;
      at[first + 1] = below + 1;
      factor[first] = sign * (1.0 - share);
      factor[first + 1] = sign * share;
    };
    put(0, pair.brighter_code, 1.0);
    put(2, pair.darker_code, -1.0);
    AddEquation(at, factor, pair.log_ratio, pair.weight * pair.weight);
  }

  // Slopes of ln g over ln code are to change little from code to code.
  void AddSmoothness(double weight) {
    for (std::size_t code = 1; code < 255; ++code) {
      const double before = log_code_[code] - log_code_[code - 1];
      const double after = log_code_[code + 1] - log_code_[code];
      const int middle = static_cast<int>(code);
      const std::array<int, 3> at{middle - 1, middle, middle + 1};
      const std::array<double, 3> factor{1.0 / before, -1.0 / before - 1.0 / after, 1.0 / after};
      AddEquation(at, factor, 0.0, weight);
    }
  }

  // With g(255) = 0: the scale cannot be determined.
  Eigen::VectorXd Solve() {
    matrix_(255, 255) += 1.0;
    return matrix_.ldlt().solve(right_);
  }

 private:
  template <std::size_t kCount>
  void AddEquation(const std::array<int, kCount>& at,
                   const std::array<double, kCount>& factor,
                   double value,
                   double weight) {
    for (std::size_t i = 0; i < kCount; ++i) {
      right_[at[i]] += weight * factor[i] * value;
      for (std::size_t j = 0; j < kCount; ++j) {
        matrix_(at[i], at[j]) += weight * factor[i] * factor[j];
      }
    }
  }

  Eigen::MatrixXd matrix_;
  Eigen::VectorXd right_;
  std::array<double, 256> log_code_{};
};

// ln g to a rising table. Below `low` light falls off linearly to 0 at code 0; `high` and what lies
// above it is white where the camera never gave a higher code.
std::array<float, 256> TableFromLog(const Eigen::VectorXd& g,
                                    int darkest_code,
                                    int brightest_code) {
  std::array<double, 256> linear{};
  for (int code = 0; code < 256; ++code) {
    const int kept = std::clamp(code, darkest_code, brightest_code);
    linear[static_cast<std::size_t>(code)] = code <= darkest_code ? 0.0 : std::exp(g[kept]);
  }
  return StrictlyRising(linear);
}

}  // namespace

ResponseFit FitResponseFromBrackets(std::span<const ExposedPicture> pictures,
                                    const BracketFitOptions& options) {
  if (!(options.smoothness > 0.0) || !std::isfinite(options.smoothness)) {
    throw std::invalid_argument("smoothness " + std::to_string(options.smoothness) +
                                ": expected a positive number");
  }
  RequireSameView(pictures);
  std::vector<std::size_t> by_exposure(pictures.size());
  std::iota(by_exposure.begin(), by_exposure.end(), std::size_t{0});
  std::stable_sort(by_exposure.begin(), by_exposure.end(), [&](std::size_t a, std::size_t b) {
    return pictures[a].exposure > pictures[b].exposure;
  });
  if (pictures.size() < 2 ||
      !(pictures[by_exposure.front()].exposure > pictures[by_exposure.back()].exposure)) {
    throw std::invalid_argument("pictures: expected two different exposures or more");
  }

  ResponseFit fit;
  for (int c = 0; c < 3; ++c) {
    const CodeRange range = UnclippedCodes(pictures, c);
    std::vector<CodePair> pairs;
    for (std::size_t k = 0; k + 1 < by_exposure.size(); ++k) {
      const ExposedPicture& brighter = pictures[by_exposure[k]];
      const ExposedPicture& darker = pictures[by_exposure[k + 1]];
      if (!(brighter.exposure > darker.exposure)) continue;
      const double log_ratio = std::log(brighter.exposure / darker.exposure);
      const JointHistogram counts = CountPairs(brighter.codes, darker.codes, c);
      AddMedians(counts, range, log_ratio, pairs);
    }
    ResponseChannelFit& channel = fit.channels[static_cast<std::size_t>(c)];
    channel.lowest_code = 255;
    for (const CodePair& pair : pairs) {
      channel.lowest_code =
          std::min(channel.lowest_code, static_cast<int>(std::floor(pair.darker_code)));
      channel.highest_code =
          std::max(channel.highest_code, static_cast<int>(std::ceil(pair.brighter_code)));
    }
    // Without a range of codes there is no curve.
    constexpr int kFewestCodes = 32;
    if (channel.highest_code - channel.lowest_code < kFewestCodes) {
      throw std::runtime_error(std::string("response of ") +
                               kChannelNames[static_cast<std::size_t>(c)] +
                               ": expected pixels that two neighbouring exposures both show "
                               "unclipped over 32 codes or more");
    }

    const int darkest_code = range.low - kNoiseFloorUpToCode - 1;
    const int brightest_code = range.high + (255 - kClippedFromCode) + 1;
    LogCurveFit equations(darkest_code);
    for (const CodePair& pair : pairs) equations.Add(pair);
    equations.AddSmoothness(options.smoothness);
    const Eigen::VectorXd g = equations.Solve();

    std::vector<double> values(g.data(), g.data() + 256);
    const std::vector<double> rising =
        IsotonicRegression(values, std::vector<double>(values.size(), 1.0));
    for (std::size_t code = 1; code < 256; ++code) {
      channel.falls_repaired += values[code] < values[code - 1] ? 1 : 0;
    }
    const Eigen::VectorXd repaired = Eigen::Map<const Eigen::VectorXd>(rising.data(), 256);
    double sum = 0.0;
    double weight = 0.0;
    for (const CodePair& pair : pairs) {
      const double error = Interpolated(repaired, pair.brighter_code) -
                           Interpolated(repaired, pair.darker_code) - pair.log_ratio;
      sum += pair.weight * pair.weight * error * error;
      weight += pair.weight * pair.weight;
    }
    channel.rms_relative = std::sqrt(sum / weight);
    fit.table[static_cast<std::size_t>(c)] = TableFromLog(repaired, darkest_code, brightest_code);
  }
  return fit;
}

}  // namespace pleinair
