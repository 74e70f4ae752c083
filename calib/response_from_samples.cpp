// A response from surfaces whose light is known: general and logarithmic.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "calib/internal/exposed_pictures.h"
#include "calib/response_fit.h"

namespace pleinair {
namespace {

void RequireSamples(const std::array<std::vector<ResponseSample>, 3>& samples) {
  for (std::size_t c = 0; c < 3; ++c) {
    const std::string channel = kChannelNames[c];
    std::vector<double> codes;
    for (const ResponseSample& sample : samples[c]) {
      if (!(sample.light > 0.0) || !std::isfinite(sample.light)) {
        throw std::invalid_argument(channel + " sample: light " + std::to_string(sample.light) +
                                    ": expected a positive number");
      }
      if (!(sample.code >= 0.0 && sample.code <= 255.0)) {
        throw std::invalid_argument(channel + " sample: code " + std::to_string(sample.code) +
                                    ": expected a value in [0, 255]");
      }
      codes.push_back(sample.code);
    }
    std::sort(codes.begin(), codes.end());
    const auto last = std::unique(codes.begin(), codes.end());
    if (last - codes.begin() < 3) {
      throw std::invalid_argument(channel +
                                  " samples: expected three different codes or more, found " +
                                  std::to_string(last - codes.begin()));
    }
  }
}

// Nodes (ascending code, ln light, rising) joined by power laws.
class PowerLawCurve {
 public:
  explicit PowerLawCurve(std::vector<std::pair<double, double>> nodes) : nodes_(std::move(nodes)) {}

  double Light(double code) const {
    // A camera's darkest code has no light: half a code replaces it, so that powers exist.
    const double u = std::log(std::max(code, 0.5));
    std::size_t upper = 1;
    while (upper + 1 < nodes_.size() && code > nodes_[upper].first) ++upper;
    const auto& [code_0, light_0] = nodes_[upper - 1];
    const auto& [code_1, light_1] = nodes_[upper];
    const double u_0 = std::log(std::max(code_0, 0.5));
    const double u_1 = std::log(std::max(code_1, 0.5));
    return std::exp(light_0 + (light_1 - light_0) * (u - u_0) / (u_1 - u_0));
  }

 private:
  std::vector<std::pair<double, double>> nodes_;
};

// The best a and b for a given c.
LogarithmicCurve FitLine(std::span<const ResponseSample> samples, double c) {
  double mean_x = 0.0;
  double mean_y = 0.0;
  const double count = static_cast<double>(samples.size());
  for (const ResponseSample& sample : samples) {
    mean_x += std::log(c + sample.light) / count;
    mean_y += sample.code / count;
  }
  double xx = 0.0;
  double xy = 0.0;
  for (const ResponseSample& sample : samples) {
    const double x = std::log(c + sample.light) - mean_x;
    xx += x * x;
    xy += x * (sample.code - mean_y);
  }
  LogarithmicCurve curve;
  curve.c = c;
  curve.b = xy / xx;
  curve.a = mean_y - curve.b * mean_x;
  double sum = 0.0;
  for (const ResponseSample& sample : samples) {
    const double error = curve.CodeFromLight(sample.light) - sample.code;
    sum += error * error;
  }
  curve.rms_codes = std::sqrt(sum / count);
  return curve;
}

LogarithmicCurve FitCurve(std::span<const ResponseSample> samples) {
  double darkest = samples[0].light;
  double brightest = samples[0].light;
  for (const ResponseSample& sample : samples) {
    darkest = std::min(darkest, sample.light);
    brightest = std::max(brightest, sample.light);
  }
  // From nearly 0 (a logarithm) to far above all light (a straight line). The error has one minimum
  // there, but a grid costs nothing and does not rely on that.
  LogarithmicCurve best = FitLine(samples, 0.0);
  const double low = std::log(1e-4 * darkest);
  const double high = std::log(1e3 * brightest);
  constexpr int kSteps = 200;
  const double step = (high - low) / kSteps;
  for (int i = 0; i <= kSteps; ++i) {
    const LogarithmicCurve curve = FitLine(samples, std::exp(low + i * step));
    if (curve.rms_codes < best.rms_codes) best = curve;
  }
  if (best.c > 0.0) {
    // Golden section in ln c around the grid's best.
    constexpr double kGolden = 0.6180339887498949;
    double left = std::log(best.c) - step;
    double right = std::log(best.c) + step;
    for (int i = 0; i < 60; ++i) {
      const double inner_left = right - kGolden * (right - left);
      const double inner_right = left + kGolden * (right - left);
      const bool better_left = FitLine(samples, std::exp(inner_left)).rms_codes <
                               FitLine(samples, std::exp(inner_right)).rms_codes;
      (better_left ? right : left) = better_left ? inner_right : inner_left;
    }
    const LogarithmicCurve curve = FitLine(samples, std::exp(0.5 * (left + right)));
    if (curve.rms_codes < best.rms_codes) best = curve;
  }
  return best;
}

}  // namespace

ResponseFit FitMonotoneResponse(const std::array<std::vector<ResponseSample>, 3>& samples) {
  RequireSamples(samples);
  ResponseFit fit;
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<ResponseSample> sorted = samples[c];
    std::sort(sorted.begin(), sorted.end(), [](const ResponseSample& a, const ResponseSample& b) {
      return a.code < b.code || (a.code == b.code && a.light < b.light);
    });
    std::vector<double> log_light;
    log_light.reserve(sorted.size());
    for (const ResponseSample& sample : sorted) log_light.push_back(std::log(sample.light));
    const std::vector<double> rising =
        IsotonicRegression(log_light, std::vector<double>(log_light.size(), 1.0));
    ResponseChannelFit& channel = fit.channels[c];
    std::vector<std::pair<double, double>> nodes;
    double sum = 0.0;
    for (std::size_t i = 0; i < sorted.size(); ++i) {
      sum += (rising[i] - log_light[i]) * (rising[i] - log_light[i]);
      if (i > 0 && log_light[i] < log_light[i - 1]) ++channel.falls_repaired;
      // A node for each level: the middle of the codes that share it.
      std::size_t end = i;
      while (end + 1 < sorted.size() && rising[end + 1] == rising[i]) ++end;
      const bool first_of_level = i == 0 || rising[i - 1] != rising[i];
      if (!first_of_level) continue;
      const double code = 0.5 * (sorted[i].code + sorted[end].code);
      // Samples of one code and different light: one node of their mean.
      if (!nodes.empty() && code <= nodes.back().first) {
        nodes.back().second = 0.5 * (nodes.back().second + rising[i]);
        continue;
      }
      nodes.emplace_back(code, rising[i]);
    }
    if (nodes.size() < 2) {
      throw std::invalid_argument(std::string(kChannelNames[c]) +
                                  " samples: expected codes that rise with the light");
    }
    channel.rms_relative = std::sqrt(sum / static_cast<double>(sorted.size()));
    channel.lowest_code = static_cast<int>(std::ceil(sorted.front().code));
    channel.highest_code = static_cast<int>(std::floor(sorted.back().code));
    const PowerLawCurve curve(std::move(nodes));
    std::array<double, 256> linear{};
    for (int code = 1; code < 256; ++code)
      linear[static_cast<std::size_t>(code)] = curve.Light(code);
    fit.table[c] = StrictlyRising(linear);
  }
  return fit;
}

double LogarithmicCurve::LightFromCode(double code) const {
  return std::max(std::exp((code - a) / b) - c, 0.0);
}

double LogarithmicCurve::CodeFromLight(double light) const { return a + b * std::log(c + light); }

LogarithmicResponseFit FitLogarithmicResponse(
    const std::array<std::vector<ResponseSample>, 3>& samples) {
  RequireSamples(samples);
  LogarithmicResponseFit fit;
  for (std::size_t c = 0; c < 3; ++c) {
    LogarithmicCurve& curve = fit.curves[c];
    curve = FitCurve(samples[c]);
    if (!(curve.b > 0.0) || !std::isfinite(curve.b)) {
      throw std::runtime_error(std::string("response of ") + kChannelNames[c] +
                               ": expected codes that rise with the light");
    }
    ResponseChannelFit& channel = fit.response.channels[c];
    channel.lowest_code = 255;
    double sum = 0.0;
    for (const ResponseSample& sample : samples[c]) {
      channel.lowest_code = std::min(channel.lowest_code, static_cast<int>(std::ceil(sample.code)));
      channel.highest_code =
          std::max(channel.highest_code, static_cast<int>(std::floor(sample.code)));
      const double error = curve.LightFromCode(sample.code) / sample.light - 1.0;
      sum += error * error;
    }
    channel.rms_relative = std::sqrt(sum / static_cast<double>(samples[c].size()));
    std::array<double, 256> linear{};
    for (int code = 0; code < 256; ++code) {
      linear[static_cast<std::size_t>(code)] = curve.LightFromCode(code);
    }
    fit.response.table[c] = StrictlyRising(linear);
  }
  return fit;
}

}  // namespace pleinair
