// Exposure brackets of a made-up scene by a made-up camera.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "calib/exposure_merge.h"

namespace pleinair {

// Code values, not yet rounded, of light in [0, 1] (clipped before).
using CodeOfLight = std::function<double(double linear)>;

inline CodeOfLight GammaCamera(double gamma) {
  return [gamma](double linear) { return 255.0 * std::pow(linear, 1.0 / gamma); };
}

struct SyntheticBracket {
  RgbImage radiance;
  std::vector<ExposedPicture> pictures;
};

// A scene of 4.5 decades, smooth along its rows, seen at `exposures` with shot and read noise.
inline SyntheticBracket MakeBracket(const CodeOfLight& code_of_light,
                                    const std::vector<double>& exposures,
                                    const CameraNoise& noise = {}) {
  constexpr int kWidth = 320;
  constexpr int kHeight = 200;
  SyntheticBracket bracket{RgbImage(kWidth, kHeight), {}};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double decades = 4.5 * (x + static_cast<double>(y) / kHeight) / kWidth - 3.0;
      const auto light = static_cast<float>(std::pow(10.0, decades));
      bracket.radiance.At(x, y) = glm::vec3(light, 0.8f * light, 1.1f * light);
    }
  }
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (const double exposure : exposures) {
    ExposedPicture picture{Rgb8Image(kWidth, kHeight), exposure};
    for (std::size_t i = 0; i < bracket.radiance.pixels.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        const double linear = bracket.radiance.pixels[i][c] * exposure;
        const double noisy = linear + std::sqrt(noise.Variance(linear)) * normal(random);
        const double code = code_of_light(std::clamp(noisy, 0.0, 1.0));
        picture.codes.pixels[i][c] =
            static_cast<std::uint8_t>(std::clamp(std::lround(code), 0L, 255L));
      }
    }
    bracket.pictures.push_back(std::move(picture));
  }
  return bracket;
}

}  // namespace pleinair
