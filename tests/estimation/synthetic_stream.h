// Streams with known light: estimates of it, and pictures of a small camera that estimates are made
// from.
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "calib/camera_noise.h"
#include "calib/response.h"
#include "estimation/lighting_source.h"
#include "tests/estimation/synthetic_view.h"

namespace pleinair::testing {

inline UtcTime StreamTime(int frame, double frames_per_second) {
  return UtcTime{std::chrono::hours(12)} +
         std::chrono::nanoseconds(std::llround(1e9 * frame / frames_per_second));
}

// True light of one frame.
struct TrueLight {
  glm::dvec3 sun{820.0, 780.0, 700.0};
  glm::dvec3 sky{95.0, 110.0, 130.0};
};

// Estimates as a fit would give them: an error that all frames share, another one for each.
struct EstimateStream {
  double frames_per_second = 30.0;
  double stated_deviation = 0.03;  // Relative; the shared error is drawn from it.
  double noise = 0.005;            // Relative, of each frame, light and channel.
  std::uint64_t seed = 1;

  std::vector<Lighting> Make(int frames, const std::function<TrueLight(int)>& truth) const {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> gauss;
    std::array<double, 9> shared{};
    for (double& error : shared) error = stated_deviation * gauss(random);
    std::vector<Lighting> stream;
    for (int i = 0; i < frames; ++i) {
      const TrueLight light = truth(i);
      Lighting& lighting = stream.emplace_back();
      lighting.time = StreamTime(i, frames_per_second);
      lighting.sun.direction_enu = SyntheticSunDirection();
      lighting.sky = {{"uniform", 0.6 * light.sky}, {"overcast", 0.4 * light.sky}};
      lighting.sun.irradiance_rgb = light.sun;
      lighting.covariance.assign(81, 0.0);
      for (std::size_t u = 0; u < 9; ++u) {
        const auto c = static_cast<int>(u % 3);
        double& value =
            u < 3 ? lighting.sun.irradiance_rgb[c] : lighting.sky[u / 3 - 1].irradiance_rgb[c];
        const double deviation =
            stated_deviation * (u < 3 ? std::max(value, 0.1 * light.sky[c]) : value);
        lighting.covariance[u * 10] = deviation * deviation;
        value = std::max(0.0,
                         value + deviation * shared[u] / stated_deviation +
                             deviation * noise / stated_deviation * gauss(random));
      }
    }
    return stream;
  }
};

// The 8-bit camera of the recorded sequences: shot noise of a full well of 16000 electrons, 7
// electrons of read noise, the sRGB curve.
inline Frame SeenByCamera(const Frame& scene,
                          double exposure,
                          std::mt19937_64& random,
                          bool exposure_is_known = true) {
  const CameraNoise camera{16000.0, 7.0};
  static const ResponseCurve kResponse = ResponseCurve::Srgb();
  static const auto kNoise = std::make_shared<SignalNoise>(kResponse, CameraNoise{16000.0, 7.0});
  std::normal_distribution<double> gauss;
  Frame frame = scene;
  if (exposure_is_known) {
    frame.exposure = exposure;
  } else {
    frame.units = LightUnits::kRelativePerFrame;
  }
  frame.noise = kNoise;
  frame.codes = Rgb8Image(scene.radiance.width, scene.radiance.height);
  for (std::size_t i = 0; i < scene.radiance.pixels.size(); ++i) {
    glm::vec3 signal;
    for (int c = 0; c < 3; ++c) {
      const double mean = exposure * scene.radiance.pixels[i][c];
      signal[c] = static_cast<float>(mean + std::sqrt(camera.Variance(mean)) * gauss(random));
    }
    frame.codes->pixels[i] = kResponse.CodeFromLinear(signal);
    const glm::u8vec3& code = frame.codes->pixels[i];
    frame.clipped.pixels[i] = std::max({code.x, code.y, code.z}) >= kClippedFromCode ? 1 : 0;
    const bool near_black = std::min({code.x, code.y, code.z}) <= kNoiseFloorUpToCode;
    int unusable = near_black ? kNearBlack : 0;
    for (int c = 0; c < 3; ++c) unusable |= code[c] >= kClippedFromCode ? kClipped[c] : 0;
    frame.unusable.pixels[i] = static_cast<std::uint8_t>(unusable);
  }
  frame.radiance = RadianceFromCodes(*frame.codes, kResponse, frame.exposure.value_or(1.0));
  return frame;
}

// Standard deviation over mean.
inline double Flicker(const std::vector<double>& values) {
  double mean = 0.0;
  for (const double value : values) mean += value / static_cast<double>(values.size());
  double variance = 0.0;
  for (const double value : values) {
    variance += (value - mean) * (value - mean) / static_cast<double>(values.size() - 1);
  }
  return std::sqrt(variance) / mean;
}

inline double Mean(const glm::dvec3& rgb) { return (rgb.x + rgb.y + rgb.z) / 3.0; }

}  // namespace pleinair::testing
