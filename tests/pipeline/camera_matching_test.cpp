// Virtual objects as noisy as the camera's picture around them, and as soft.
#include "pipeline/camera_matching.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "ground_stage.h"

namespace pleinair::camera_matching_test {
namespace {

constexpr CameraNoise kNoisyCamera{1500.0, 8.0};

// Codes of even light of two brightnesses, above and below, as a noisy camera gives them.
Frame NoisyFrame(int index, double above, double below) {
  std::mt19937_64 random(11 + static_cast<unsigned>(index));
  std::normal_distribution<double> normal;
  Frame frame;
  frame.index = index;
  frame.exposure = 0.01;
  RgbImage light(256, 256);
  for (std::size_t i = 0; i < light.pixels.size(); ++i) {
    const double signal = i < light.pixels.size() / 2 ? above : below;
    for (int c = 0; c < 3; ++c) {
      light.pixels[i][c] =
          static_cast<float>(signal + std::sqrt(kNoisyCamera.Variance(signal)) * normal(random));
    }
  }
  frame.codes = CodesFromRadiance(light, ResponseCurve::Srgb(), 1.0);
  frame.radiance = RadianceFromCodes(*frame.codes, ResponseCurve::Srgb(), *frame.exposure);
  return frame;
}

struct Rows {
  int first = 0;
  int end = 0;
};

// Standard deviation of the green codes in some columns.
double CodeDeviation(const Rgb8Image& codes, const Rows& rows, int first_x, int end_x) {
  double sum = 0.0;
  double squares = 0.0;
  int count = 0;
  for (int y = rows.first; y < rows.end; ++y) {
    for (int x = first_x; x < end_x; ++x) {
      const double code = codes.At(x, y).g;
      sum += code;
      squares += code * code;
      ++count;
    }
  }
  return std::sqrt(squares / count - sum * sum / count / count);
}

// An object of the upper half's light in columns 64 to 128, and a shadow that takes the upper
// half's light down to the lower half's in columns 128 to 192.
Composite CleanComposite(const Frame& frame, double above, double below) {
  Composite composite;
  composite.radiance = frame.radiance;
  composite.change = Gray8Image(256, 256, 0);
  for (int y = 0; y < 128; ++y) {
    for (int x = 64; x < 128; ++x) {
      composite.radiance.At(x, y) = glm::vec3(static_cast<float>(above / *frame.exposure));
      composite.change.At(x, y) = static_cast<std::uint8_t>(PixelChange::kCovered);
    }
    for (int x = 128; x < 192; ++x) {
      composite.radiance.At(x, y) *= static_cast<float>(below / above);
      composite.change.At(x, y) = static_cast<std::uint8_t>(PixelChange::kScaled);
    }
  }
  return composite;
}

// 8192 pixels: 0.8 % of a deviation; its measure in the frame 10 %.
TEST(CameraMatching, ObjectsAndShadowsAreAsNoisyAsWhatIsAround) {
  const double above = 0.5;
  const double below = 0.2;
  const Frame frame = NoisyFrame(3, above, below);
  for (const bool known : {false, true}) {
    CameraMatchingOptions options;
    if (known) options.camera_noise = kNoisyCamera;
    Composite composite = CleanComposite(frame, above, below);
    CameraMatching(options).AddNoise(frame, ResponseCurve::Srgb(), composite);
    const Rgb8Image codes =
        CodesFromRadiance(composite.radiance, ResponseCurve::Srgb(), *frame.exposure);
    const double around_above = CodeDeviation(*frame.codes, {0, 128}, 192, 256);
    const double around_below = CodeDeviation(*frame.codes, {128, 256}, 0, 256);
    EXPECT_GT(around_above, 1.5) << "there is noise to match";
    EXPECT_NEAR(CodeDeviation(codes, {0, 128}, 64, 128) / around_above, 1.0, 0.15);
    EXPECT_NEAR(CodeDeviation(codes, {0, 128}, 128, 192) / around_below, 1.0, 0.15);
    for (std::size_t i = 0; i < frame.radiance.pixels.size(); ++i) {
      if (composite.change.pixels[i] != 0) continue;
      ASSERT_EQ(composite.radiance.pixels[i], frame.radiance.pixels[i]);
    }
  }
}

TEST(CameraMatching, NoiseIsTheSameForTheSameFrameAndAnotherInTheNext) {
  Frame frame = NoisyFrame(3, 0.5, 0.2);
  const auto with_noise = [&] {
    Composite composite = CleanComposite(frame, 0.5, 0.2);
    CameraMatching({}).AddNoise(frame, ResponseCurve::Srgb(), composite);
    return composite.radiance.pixels;
  };
  const std::vector<glm::vec3> once = with_noise();
  EXPECT_EQ(with_noise(), once);
  frame.index = 4;
  EXPECT_NE(with_noise(), once);
}

TEST(CameraMatching, LinearFramesAreLeftClean) {
  Frame frame = NoisyFrame(3, 0.5, 0.2);
  frame.codes.reset();
  const Composite clean = CleanComposite(frame, 0.5, 0.2);
  Composite composite = clean;
  CameraMatching matching({});
  matching.AddNoise(frame, ResponseCurve::Srgb(), composite);
  EXPECT_EQ(composite.radiance.pixels, clean.radiance.pixels);
}

// Two walls that meet in upright and level edges, seen by a lens of that softness.
struct SoftEdges {
  explicit SoftEdges(double sigma_px) {
    constexpr int kSide = 96;
    frame.radiance = RgbImage(kSide, kSide);
    view.region = Image<std::int32_t>(kSide, kSide, 0);
    view.normal_world = RgbImage(kSide, kSide, {0.0f, 0.0f, 1.0f});
    view.position_world_m = RgbImage(kSide, kSide);
    view.sun_visibility = GrayImage(kSide, kSide, 1.0f);
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        double step = 0.0;
        constexpr int kPoints = 16;
        for (int i = 0; i < kPoints; ++i) {
          const double across = x + 0.1 * y - 50.0 + (i + 0.5) / kPoints - 0.5;
          step += 0.5 * std::erfc(across / sigma_px / std::numbers::sqrt2) / kPoints;
        }
        frame.radiance.At(x, y) = glm::vec3(static_cast<float>(1.0 + 3.0 * step));
        view.region.At(x, y) = x + 0.1 * y < 50.0 ? 0 : 1;
      }
    }
  }
  Frame frame;
  SurfaceView view;
};

// A linear frame came through a lens too. 10 %: as EdgeBlurMeter's own test has it.
TEST(CameraMatching, BlurIsMeasuredInLinearFramesAndKept) {
  CameraMatching matching({});
  SoftEdges soft(0.5);
  for (int i = 0; i < 20; ++i) {
    soft.frame.index = i;
    EXPECT_NEAR(matching.BlurPx(soft.frame, soft.view), 0.5, 0.05);
  }
  SoftEdges softer(1.5);
  for (int i = 20; i < 60; ++i) {
    softer.frame.index = i;
    EXPECT_NEAR(matching.BlurPx(softer.frame, softer.view), 0.5, 0.05) << "the lens's is known";
  }
}

TEST(CameraMatching, EachCanBeSwitchedOff) {
  const Frame frame = NoisyFrame(3, 0.5, 0.2);
  const Composite clean = CleanComposite(frame, 0.5, 0.2);
  Composite composite = clean;
  CameraMatching matching({.noise = false, .blur = false, .camera_noise = {}});
  const SoftEdges soft(0.5);
  EXPECT_EQ(matching.BlurPx(soft.frame, soft.view), 0.0);
  matching.AddNoise(frame, ResponseCurve::Srgb(), composite);
  EXPECT_EQ(composite.radiance.pixels, clean.radiance.pixels);
  EXPECT_EQ(matching.BlurPx(frame, {}), 0.0);
  EXPECT_THROW(CameraMatching({.camera_noise = CameraNoise{-1.0, 5.0}}), std::invalid_argument);
}

// Light, exposure and codes that make no sense give no NaN.
TEST(CameraMatching, BrokenPixelsStayFinite) {
  const Frame frame = NoisyFrame(3, 0.5, 0.2);
  Composite composite = CleanComposite(frame, 0.5, 0.2);
  composite.radiance.At(70, 3) = {65504.0f, 0.0f, 1e-30f};
  CameraMatching({}).AddNoise(frame, ResponseCurve::Srgb(), composite);
  for (const glm::vec3& rgb : composite.radiance.pixels) {
    for (int c = 0; c < 3; ++c) ASSERT_TRUE(std::isfinite(rgb[c]) && rgb[c] >= 0.0f);
  }
}

// The camera clips from white on: what is brighter has no noise that could push it further.
TEST(CameraMatching, LightFromWhiteOnGetsNoNoise) {
  const Frame frame = NoisyFrame(3, 0.5, 0.2);
  Composite clean = CleanComposite(frame, 0.5, 0.2);
  const auto white = static_cast<float>(1.0 / *frame.exposure);
  const auto light_at = [&](int x) {
    return x < 96 ? white * std::ldexp(1.0f, x - 64) : 0.99f * white;
  };
  for (int x = 64; x < 128; ++x) {
    for (int y = 0; y < 128; ++y) clean.radiance.At(x, y) = glm::vec3(light_at(x));
  }
  Composite composite = clean;
  CameraMatching({}).AddNoise(frame, ResponseCurve::Srgb(), composite);
  int noisy = 0;
  for (int x = 64; x < 128; ++x) {
    for (int y = 0; y < 128; ++y) {
      const glm::vec3& with = composite.radiance.At(x, y);
      if (x < 96) {
        ASSERT_EQ(with, clean.radiance.At(x, y)) << x << ", " << y;
      } else {
        noisy += with != clean.radiance.At(x, y) ? 1 : 0;
      }
    }
  }
  EXPECT_EQ(noisy, 32 * 128);
}

// The complete pipeline, with 8-bit frames of a noisy camera: the object's noise, and nothing
// else's.
TEST(CameraMatching, ThePipelineMatchesFramesOfCodes) {
  const GroundStage stage;
  const HeadlessContext context;
  Compositor compositor;
  const Material material{.name = "grey", .diffuse_albedo = glm::vec3(0.4f)};
  const auto process = [&](const Frame& frame, bool matched) {
    FramePipelineOptions options = GroundStage::QuickOptions();
    options.camera_matching.noise = matched;
    options.camera_matching.camera_noise = kNoisyCamera;
    FramePipeline pipeline({stage.Scene(),
                            stage.Phantom(),
                            std::nullopt,
                            {BoxObject({-0.6f, -0.6f, 0.0f}, {0.6f, 0.6f, 0.9f}, material)}},
                           std::make_unique<StillLight>(),
                           compositor,
                           options);
    return pipeline.Process(frame).value().composite;
  };
  Frame frame = stage.MakeFrame();
  const Composite linear = process(frame, true);
  EXPECT_EQ(process(frame, false).radiance.pixels, linear.radiance.pixels);
  frame.exposure = 0.5 / double{frame.radiance.pixels[0].r};
  frame.codes = CodesFromRadiance(frame.radiance, ResponseCurve::Srgb(), *frame.exposure);
  const Composite matched = process(frame, true);
  const Composite clean = process(frame, false);
  EXPECT_EQ(matched.change.pixels, clean.change.pixels);
  std::size_t noisy = 0;
  std::size_t changed = 0;
  for (std::size_t i = 0; i < clean.change.pixels.size(); ++i) {
    const bool is_changed = clean.change.pixels[i] != 0;
    changed += is_changed ? 1 : 0;
    noisy += matched.radiance.pixels[i] != clean.radiance.pixels[i] ? 1 : 0;
    if (!is_changed) {
      ASSERT_EQ(matched.radiance.pixels[i], frame.radiance.pixels[i]);
    }
  }
  EXPECT_GT(noisy, changed / 4);
}

}  // namespace
}  // namespace pleinair::camera_matching_test
