#include "pipeline/display_codes.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

namespace pleinair {

double ChosenExposure(const RgbImage& radiance) {
  constexpr double kExposedShare = 0.95;
  constexpr double kExposedLevel = 0.8;
  std::vector<float> brightest;
  brightest.reserve(radiance.pixels.size());
  for (const glm::vec3& rgb : radiance.pixels) {
    const float value = std::max({rgb.x, rgb.y, rgb.z});
    if (value > 0.0f && value < 1e30f) brightest.push_back(value);
  }
  if (brightest.empty()) return 1.0;
  const auto nth =
      brightest.begin() + static_cast<std::ptrdiff_t>(kExposedShare * double(brightest.size() - 1));
  std::nth_element(brightest.begin(), nth, brightest.end());
  return kExposedLevel / static_cast<double>(*nth);
}

double ChosenExposure(const Frame& frame) {
  return frame.codes ? 1.0 : ChosenExposure(frame.radiance);
}

DisplayCodes::DisplayCodes(const ResponseCurve& response,
                           double exposure,
                           const ResponseCorrection& correction)
    : saturated_rise_(1.0f +
                      2.0f / 3.0f * std::max(static_cast<float>(correction.saturation), 0.0f)) {
  for (int c = 0; c < 3; ++c) {
    Channel& channel = channels_[static_cast<std::size_t>(c)];
    channel.linear_of_code = response.LinearOfCode(c);
    if (!correction.IsNone()) {
      for (float& linear : channel.linear_of_code) {
        linear = static_cast<float>(correction.unit_rgb[c] *
                                    std::pow(double{linear}, 1.0 / (1.0 + correction.exponent)));
      }
    }
    std::size_t code = 0;
    for (std::size_t i = 0; i < kGuesses; ++i) {
      const float lower = static_cast<float>(i) / kGuesses;
      while (code < 254 && channel.linear_of_code[code + 1] <= lower) ++code;
      channel.guess[i] = static_cast<std::uint8_t>(code);
    }
    // From white down, nowhere flatter than above. A step of the curve is as high in both.
    std::array<float, 256>& steep = channel.steep_code;
    steep[255] = 0.0f;
    float slope = 0.0f;
    for (std::size_t i = 255; i-- > 0;) {
      const float width = channel.linear_of_code[i + 1] - channel.linear_of_code[i];
      if (width > 0.0f) slope = std::max(slope, 1.0f / width);
      steep[i] = steep[i + 1] - std::max(slope * width, 1.0f);
    }
  }
  SetExposure(exposure);
}

void DisplayCodes::SetExposure(double exposure) {
  if (!(exposure > 0.0) || !std::isfinite(exposure)) {
    throw std::invalid_argument("exposure is " + std::to_string(exposure) +
                                ": expected more than 0");
  }
  exposure_ = exposure;
  scale_ = static_cast<float>(exposure);
}

// `values` at the light of each code, linear between them.
float DisplayCodes::On(const std::array<float, 256>& values,
                       const Channel& channel,
                       float radiance) const {
  const std::array<float, 256>& linear_of_code = channel.linear_of_code;
  const float linear = scale_ * radiance;
  if (!(linear > linear_of_code.front())) return values.front();
  if (linear >= linear_of_code.back()) return values.back();
  std::size_t code = channel.guess[std::min(static_cast<std::size_t>(linear * kGuesses),
                                            static_cast<std::size_t>(kGuesses - 1))];
  while (code < 254 && linear_of_code[code + 1] <= linear) ++code;
  const float below = linear_of_code[code];
  const float above = linear_of_code[code + 1];
  const float share =
      above > below ? std::clamp((linear - below) / (above - below), 0.0f, 1.0f) : 1.0f;
  return values[code] + share * (values[code + 1] - values[code]);
}

float DisplayCodes::Code(int channel, float radiance) const {
  static const std::array<float, 256> codes = [] {
    std::array<float, 256> all{};
    std::iota(all.begin(), all.end(), 0.0f);
    return all;
  }();
  return On(codes, channels_[static_cast<std::size_t>(channel)], radiance);
}

float DisplayCodes::Difference(const glm::vec3& a, const glm::vec3& b) const {
  float largest = 0.0f;
  for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(Code(c, a[c]) - Code(c, b[c])));
  return largest;
}

float DisplayCodes::LargestRise(const glm::vec3& least, const glm::vec3& added) const {
  float largest = 0.0f;
  for (int c = 0; c < 3; ++c) {
    if (!(added[c] > 0.0f)) continue;
    const Channel& channel = channels_[static_cast<std::size_t>(c)];
    const float from = std::max(least[c], 0.0f);
    largest = std::max(largest,
                       On(channel.steep_code, channel, from + saturated_rise_ * added[c]) -
                           On(channel.steep_code, channel, from));
  }
  return largest;
}

}  // namespace pleinair
