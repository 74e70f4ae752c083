#include "calib/camera_noise.h"

#include <cmath>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "scene/srgb.h"
#include "tests/calib/linear_from_code.h"

namespace pleinair::camera_noise_test {
namespace {

// Half the well: 8000 electrons of light have a deviation of 89.4, with 7 of reading 89.7.
TEST(SignalNoise, AddsUpShotReadAndRounding) {
  const SignalNoise noise(ResponseCurve::Srgb());
  const double sensor = (8000.0 + 49.0) / (16000.0 * 16000.0);
  // sRGB's slope at 0.5 (code 188) is 0.0066 a code.
  const double step = LinearFromSrgb(188.5 / 255.0) - LinearFromSrgb(187.5 / 255.0);
  EXPECT_NEAR(noise.Variance(1, 0.5), sensor + step * step / 12.0, 1e-3 * sensor);
}

// Against the camera itself: electrons drawn, read and rounded.
TEST(SignalNoise, IsWhatASimulatedCameraShows) {
  const ResponseCurve response = ResponseCurve::Srgb();
  const CameraNoise options{4000.0, 10.0};
  const SignalNoise noise(response, options);
  std::mt19937_64 random(1);
  for (const double signal : {0.02, 0.1, 0.4, 0.8}) {
    std::poisson_distribution<int> shot(signal * options.full_well_electrons);
    std::normal_distribution<double> read(0.0, options.read_noise_electrons);
    constexpr int kDraws = 40000;
    double sum = 0.0;
    double squares = 0.0;
    for (int i = 0; i < kDraws; ++i) {
      const auto value =
          static_cast<float>((shot(random) + read(random)) / options.full_well_electrons);
      const double seen =
          double{LinearFromCode(response, response.CodeFromLinear(glm::vec3(value))).y};
      sum += seen;
      squares += seen * seen;
    }
    const double mean = sum / kDraws;
    const double variance = squares / kDraws - mean * mean;
    // The variance of 40000 draws is known to sqrt(2 / 40000) = 0.7 %, at three deviations 2 %; a
    // code is as wide as the noise at most, where rounding is within 1 % of independent.
    EXPECT_NEAR(noise.Variance(1, signal), variance, 0.03 * variance) << signal;
  }
}

TEST(SignalNoise, IsDefinedForAnySignal) {
  const SignalNoise noise(ResponseCurve::Srgb());
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(noise.Variance(c, -1.0), noise.Variance(c, 0.0));
    EXPECT_EQ(noise.Variance(c, std::nan("")), noise.Variance(c, 0.0));
    EXPECT_EQ(noise.Variance(c, 7.0), noise.Variance(c, 1.0));
    EXPECT_GT(noise.Variance(c, 0.0), 0.0);
    EXPECT_NEAR(noise.ClippedFrom(c), LinearFromSrgb(254.0 / 255.0), 1e-6);
  }
}

// Codes that stand for the same light round nothing off; the variance stays that of the sensor.
TEST(SignalNoise, KnowsCurvesWithFlatEnds) {
  ResponseTable table{};
  for (auto& channel : table) {
    for (std::size_t code = 0; code < 256; ++code) {
      channel[code] = code < 16 ? 0.0f : std::min(1.0f, static_cast<float>(code - 16) / 219.0f);
    }
  }
  const SignalNoise noise(ResponseCurve::FromTable(table), {10000.0, 0.1});
  EXPECT_NEAR(noise.Variance(0, 1.0), 1e-4, 1e-9);
  EXPECT_NEAR(noise.Variance(0, 0.5), 0.5e-4 + 1.0 / (219.0 * 219.0 * 12.0), 1e-8);
}

TEST(SignalNoise, RefusesImpossibleCameras) {
  const ResponseCurve response = ResponseCurve::Srgb();
  EXPECT_THROW(SignalNoise(response, {0.0, 7.0}), std::invalid_argument);
  EXPECT_THROW(SignalNoise(response, {std::nan(""), 7.0}), std::invalid_argument);
  EXPECT_THROW(SignalNoise(response, {16000.0, -1.0}), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::camera_noise_test
