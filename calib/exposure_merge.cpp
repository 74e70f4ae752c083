#include "calib/exposure_merge.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "calib/internal/exposed_pictures.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

// From this share of the curve's upper end on, light is white.
constexpr double kWhiteShare = 0.995;

// One channel of the response, with what the merge asks of a code.
class ChannelModel {
 public:
  ChannelModel(const std::array<float, 256>& linear_of_code, const CameraNoise& noise)
      : linear_(linear_of_code), noise_(noise) {
    // White begins where the curve is flat; as kClippedFromCode says, clipped light may be a code
    // below. For the sRGB curve that is kClippedFromCode itself.
    int white = 255;
    while (white > 1 && linear_[Index(white - 1)] >= kWhiteShare * linear_[255]) --white;
    clipped_from_ = std::min(kClippedFromCode, white - 1);
    for (int code = 0; code < 256; ++code) {
      const double step =
          0.5 * (linear_[Index(std::min(code + 1, 255))] - linear_[Index(std::max(code - 1, 0))]);
      rounding_variance_[Index(code)] = step * step / 12.0;
    }
  }

  double Linear(int code) const { return linear_[Index(code)]; }
  bool IsClipped(int code) const { return code >= clipped_from_; }
  static bool IsAtNoiseFloor(int code) { return code <= kNoiseFloorUpToCode; }

  // Variance at the measured code; `linear` may be a better estimate of the light.
  double Variance(int code, double linear) const {
    return noise_.Variance(linear) + rounding_variance_[Index(code)];
  }

 private:
  static std::size_t Index(int code) { return static_cast<std::size_t>(code); }

  std::array<float, 256> linear_;
  std::array<double, 256> rounding_variance_{};
  CameraNoise noise_;
  int clipped_from_ = kClippedFromCode;
};

struct MergedValue {
  double radiance = 0.0;
  double stddev = 0.0;
  bool clipped = false;
  bool at_noise_floor = false;
  double difference = -1.0;  // Relative; below 0 where there are not two to compare.
};

struct Measurement {
  int code;
  double exposure;
};

MergedValue WeightedMean(const ChannelModel& channel, std::span<const Measurement> measurements) {
  MergedValue merged;
  // The first weights are those of each measurement's own value.
  for (int pass = 0; pass < 3; ++pass) {
    double weight_sum = 0.0;
    double sum = 0.0;
    for (const Measurement& measured : measurements) {
      const double linear = channel.Linear(measured.code);
      const double expected =
          pass == 0 ? linear : std::clamp(merged.radiance * measured.exposure, 0.0, 1.0);
      const double weight =
          measured.exposure * measured.exposure / channel.Variance(measured.code, expected);
      weight_sum += weight;
      sum += weight * linear / measured.exposure;
    }
    merged.radiance = sum / weight_sum;
    merged.stddev = 1.0 / std::sqrt(weight_sum);
  }
  return merged;
}

// Below 0 where there are not two to compare.
double RelativeDifference(const ChannelModel& channel,
                          std::span<const Measurement> measurements,
                          double merged) {
  constexpr int kFromCode = 32;  // Darker codes differ by their noise.
  double least = std::numeric_limits<double>::infinity();
  double most = 0.0;
  int compared = 0;
  for (const Measurement& measured : measurements) {
    if (measured.code < kFromCode) continue;
    ++compared;
    const double radiance = channel.Linear(measured.code) / measured.exposure;
    least = std::min(least, radiance);
    most = std::max(most, radiance);
  }
  return compared > 1 ? (most - least) / merged : -1.0;
}

// `scratch` has room for all measurements.
MergedValue Merge(const ChannelModel& channel,
                  std::span<const Measurement> measurements,
                  std::vector<Measurement>& scratch) {
  scratch.clear();
  for (const Measurement& measured : measurements) {
    if (channel.IsClipped(measured.code) || ChannelModel::IsAtNoiseFloor(measured.code)) continue;
    scratch.push_back(measured);
  }
  if (!scratch.empty()) {
    MergedValue merged = WeightedMean(channel, scratch);
    merged.difference = RelativeDifference(channel, scratch, merged.radiance);
    return merged;
  }

  for (const Measurement& measured : measurements) {
    if (!channel.IsClipped(measured.code)) scratch.push_back(measured);
  }
  if (!scratch.empty()) {
    MergedValue merged = WeightedMean(channel, scratch);
    merged.at_noise_floor = true;
    return merged;
  }
  MergedValue merged;
  merged.clipped = true;
  for (const Measurement& measured : measurements) {
    merged.radiance = std::max(merged.radiance, channel.Linear(measured.code) / measured.exposure);
  }
  merged.stddev = merged.radiance;
  return merged;
}

}  // namespace

MergedExposures MergeExposures(std::span<const ExposedPicture> pictures,
                               const ResponseCurve& response,
                               const CameraNoise& noise) {
  noise.Validate();
  RequireSameView(pictures);
  const std::array<ChannelModel, 3> channels{ChannelModel(response.LinearOfCode(0), noise),
                                             ChannelModel(response.LinearOfCode(1), noise),
                                             ChannelModel(response.LinearOfCode(2), noise)};
  const int width = pictures[0].codes.width;
  const int height = pictures[0].codes.height;
  MergedExposures merged{RgbImage(width, height),
                         RgbImage(width, height),
                         Gray8Image(width, height),
                         Gray8Image(width, height)};
  std::vector<Measurement> measurements(pictures.size());
  std::vector<Measurement> scratch;
  scratch.reserve(pictures.size());
  std::vector<double> differences;
  for (std::size_t i = 0; i < merged.radiance.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < pictures.size(); ++k) {
        measurements[k] = {pictures[k].codes.pixels[i][c], pictures[k].exposure};
      }
      const MergedValue value = Merge(channels[static_cast<std::size_t>(c)], measurements, scratch);
      merged.radiance.pixels[i][c] = static_cast<float>(value.radiance);
      merged.stddev.pixels[i][c] = static_cast<float>(value.stddev);
      if (value.clipped) merged.clipped.pixels[i] = 1;
      if (value.at_noise_floor) merged.at_noise_floor.pixels[i] = 1;
      if (c == 1 && value.difference >= 0.0) differences.push_back(value.difference);
    }
  }
  merged.median_difference = UpperMedianInPlace(differences);
  return merged;
}

}  // namespace pleinair
