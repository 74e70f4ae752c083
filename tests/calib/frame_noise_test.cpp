#include "calib/frame_noise.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "calib/camera_noise.h"

namespace pleinair::frame_noise_test {
namespace {

// Light from dark at the left to bright at the right, and a little texture where `texture` says.
Rgb8Image Picture(const CameraNoise& camera, bool noisy, double texture = 0.0) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  RgbImage light(320, 240);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const double rough = y < 120 ? texture * std::sin(2.1 * x) * std::cos(1.7 * y) : 0.0;
      const double signal = (0.05 + 0.8 * x / 320.0) * (1.0 + rough);
      for (int c = 0; c < 3; ++c) {
        const double noise = noisy ? std::sqrt(camera.Variance(signal)) * normal(random) : 0.0;
        light.At(x, y)[c] = static_cast<float>(signal + noise);
      }
    }
  }
  return CodesFromRadiance(light, ResponseCurve::Srgb(), 1.0);
}

// 300 blocks in some eight brightnesses: 5 % of the deviation for the choice of the quietest
// quarter, 5 % for its scatter.
TEST(FrameNoise, IsTheCameras) {
  const ResponseCurve response = ResponseCurve::Srgb();
  for (const CameraNoise& camera : {CameraNoise{2000.0, 5.0}, CameraNoise{8000.0, 60.0}}) {
    const FrameNoise noise = MeasureFrameNoise(Picture(camera, true), response);
    for (int c = 0; c < 3; ++c) {
      for (const double signal : {0.15, 0.4, 0.7}) {
        EXPECT_NEAR(std::sqrt(noise.Variance(c, signal) / camera.Variance(signal)), 1.0, 0.1)
            << "signal " << signal << " channel " << c;
      }
    }
  }
}

TEST(FrameNoise, IsNotTakenInByTexture) {
  const CameraNoise camera{2000.0, 5.0};
  const FrameNoise noise = MeasureFrameNoise(Picture(camera, true, 0.2), ResponseCurve::Srgb());
  for (const double signal : {0.15, 0.4, 0.7}) {
    EXPECT_NEAR(std::sqrt(noise.Variance(1, signal) / camera.Variance(signal)), 1.0, 0.15);
  }
}

// Rounding alone leaves steps of one code, a third of one as a deviation: less than that is
// nothing.
TEST(FrameNoise, ACleanPictureHasNone) {
  const FrameNoise noise = MeasureFrameNoise(Picture({}, false), ResponseCurve::Srgb());
  for (const double signal : {0.15, 0.4, 0.7}) {
    EXPECT_LT(std::sqrt(noise.Variance(1, signal)), 0.3 * 0.0066) << signal;
  }
}

TEST(FrameNoise, NothingToMeasureIsNone) {
  for (const glm::u8vec3& code : {glm::u8vec3(0), glm::u8vec3(255)}) {
    const FrameNoise noise = MeasureFrameNoise(Rgb8Image(320, 240, code), ResponseCurve::Srgb());
    EXPECT_EQ(noise.Variance(0, 0.5), 0.0);
  }
  EXPECT_EQ(MeasureFrameNoise(Rgb8Image(1, 1), ResponseCurve::Srgb()).Variance(1, 1.0), 0.0);
  EXPECT_EQ(MeasureFrameNoise(Rgb8Image(), ResponseCurve::Srgb()).Variance(1, NAN), 0.0);
}

}  // namespace
}  // namespace pleinair::frame_noise_test
