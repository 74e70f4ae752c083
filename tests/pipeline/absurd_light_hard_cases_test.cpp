// Pictures composited in light that their estimate got wrong: nothing real is brighter than the
// object and the picture can make it, and shadows have no colour that daylight has not.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "estimation/outdoor_estimator.h"
#include "ground_stage.h"
#include "pipeline/daylight_colours.h"
#include "pipeline/plausibility.h"
#include "pipeline/sun_state.h"
#include "scene/half_float.h"

namespace pleinair::absurd_light_test {
namespace {

const Material kWhite{.name = "white", .diffuse_albedo = glm::vec3(0.8f)};
const Material kMirror{.name = "mirror",
                       .diffuse_albedo = glm::vec3(0.0f),
                       .specular_reflectance = glm::vec3(0.85f),
                       .roughness = 0.1f};

float Brightest(const glm::vec3& rgb) { return std::max({rgb.r, rgb.g, rgb.b}); }

class AbsurdLight : public testing::Test {
 protected:
  FrameResult Process(const Frame& frame,
                      const glm::dvec3& sun,
                      const glm::dvec3& sky,
                      const VirtualObject& object) {
    return stage_.Process(frame,
                          std::make_unique<StillLight>(sun, sky),
                          object,
                          GroundStage::QuickOptions(),
                          compositor_);
  }

  const GroundStage stage_;
  const HeadlessContext context_;
  Compositor compositor_;
};

// Every other stripe of the ground is as dark as in a shadow that the mesh lacks, or nearly black.
TEST_F(AbsurdLight, NothingRealGlows) {
  Frame striped = stage_.MakeFrame();
  for (int y = 0; y < striped.radiance.height; ++y) {
    for (int x = 0; x < striped.radiance.width; ++x) {
      if (x / 4 % 3 == 1) striped.radiance.At(x, y) *= 0.25f;
      if (x / 4 % 3 == 2) striped.radiance.At(x, y) *= 0.01f;
    }
  }
  const struct {
    glm::dvec3 sun;
    glm::dvec3 sky;
    const char* what;
  } cases[] = {{{400, 400, 400}, {1e-6, 40, 100}, "a sky without red"},
               {{400, 400, 400}, {1e-6, 1e-6, 100}, "a sky of blue alone"},
               {{400, 400, 400}, {0, 0, 0}, "no sky"},
               {{4000, 4000, 4000}, {1e-3, 1e-3, 1e-3}, "a sun far too strong"},
               {{0, 0, 0}, {1e-3, 1e-3, 1e-3}, "far too little light"},
               {{0, 0, 0}, {1e6, 1e6, 1e6}, "far too much light"},
               {{1e-6, 400, 400}, {100, 100, 100}, "a sun without red"}};
  const VirtualObject objects[] = {BoxObject({-0.6f, -0.6f, 0.0f}, {0.6f, 0.6f, 0.9f}, kWhite),
                                   BallObject({0.0f, 0.0f, 0.6f}, 0.6f, 12, kMirror)};
  for (const bool is_striped : {false, true}) {
    for (const VirtualObject& object : objects) {
      for (const auto& [sun, sky, what] : cases) {
        Frame frame = is_striped ? striped : stage_.MakeFrame();
        const FrameResult clean = Process(frame, sun, sky, object);
        EXPECT_EQ(CountGlowingPixels(frame.radiance, clean.composite), 0) << what;
        // As 8-bit codes, with camera noise.
        frame.exposure = 0.6 / double{frame.radiance.pixels[0].r};
        frame.codes = CodesFromRadiance(frame.radiance, ResponseCurve::Srgb(), *frame.exposure);
        const FrameResult noisy = Process(frame, sun, sky, object);
        EXPECT_EQ(CountGlowingPixels(frame.radiance, noisy.composite), 0) << what << ", noisy";
        for (const glm::vec3& rgb : noisy.composite.radiance.pixels) {
          ASSERT_LE(Brightest(rgb), kLargestHalf);
        }
      }
    }
  }
}

// Grey ground, grey light but for a channel: the shadow is no more coloured than daylight makes it.
TEST_F(AbsurdLight, ShadowsKeepTheirHue) {
  const VirtualObject box = BoxObject({-0.6f, -0.6f, 0.0f}, {0.6f, 0.6f, 0.9f}, kWhite);
  const Frame frame = stage_.MakeFrame();
  for (int weak = 0; weak < 3; ++weak) {
    glm::dvec3 sky(100.0);
    sky[weak] = 1e-6;
    const FrameResult result = Process(frame, glm::dvec3(400.0), sky, box);
    ASSERT_TRUE(result.drawn_lighting);
    const double least[] = {100.0 / kMostRiseOfSkyOverSun,
                            100.0 * kLeastRiseOfSkyOverSun,
                            100.0 * kLeastRiseOfSkyOverSun};
    EXPECT_NEAR(result.drawn_lighting->SkyIrradianceRgb()[weak], least[weak], 1e-6);
    EXPECT_EQ(result.estimate.lighting.SkyIrradianceRgb(), sky)
        << "the estimate is reported as it is";
    int shaded = 0;
    for (std::size_t i = 0; i < frame.radiance.pixels.size(); ++i) {
      if (result.composite.change.pixels[i] != static_cast<std::uint8_t>(PixelChange::kScaled)) {
        continue;
      }
      const glm::vec3 share = result.composite.radiance.pixels[i] / frame.radiance.pixels[i];
      const float largest = Brightest(share);
      shaded += largest < 0.5f ? 1 : 0;
      ASSERT_GT(std::min({share.r, share.g, share.b}), 0.4f * largest) << i;
    }
    EXPECT_GT(shaded, 50);
  }
  EXPECT_FALSE(Process(frame, glm::dvec3(400.0), glm::dvec3(100.0), box).drawn_lighting);
}

// Open ground, and light of which only the sum on the ground is known. The object has no hard
// shadow unless the sun is likely.
TEST_F(AbsurdLight, ASunThatNothingShowsCastsNoHardShadow) {
  class OnlyTheSumIsKnown final : public StillLight {
   public:
    explicit OnlyTheSumIsKnown(double clear) : clear_(clear) {}
    tl::expected<LightingEstimate, LightingFailure> Estimate(
        const LightingObservation& observation) override {
      LightingEstimate estimate = StillLight::Estimate(observation).value();
      constexpr double kSunStddev = 350.0;
      const double by_sun[] = {1.0, -observation.sun.direction_enu.z};
      std::vector<double>& covariance = estimate.lighting.covariance;
      for (std::size_t u = 0; u < 6; ++u) {
        for (std::size_t v = 0; v < 6; ++v) {
          covariance.push_back(
              u % 3 == v % 3 ? kSunStddev * kSunStddev * by_sun[u / 3] * by_sun[v / 3] : 0.0);
        }
      }
      estimate.weather_shares = {1.0 - clear_, 0.0, clear_};
      return estimate;
    }

   private:
    double clear_;
  };
  const VirtualObject box = BoxObject({-0.6f, -0.6f, 0.0f}, {0.6f, 0.6f, 0.9f}, kWhite);
  const Frame frame = stage_.MakeFrame();
  const auto dark_pixels = [&](double clear) {
    const FrameResult result = stage_.Process(frame,
                                              std::make_unique<OnlyTheSumIsKnown>(clear),
                                              box,
                                              GroundStage::QuickOptions(),
                                              compositor_);
    EXPECT_EQ(result.is_drawn_without_sun, clear < 0.6);
    EXPECT_EQ(result.estimate.lighting.sun.irradiance_rgb, glm::dvec3(StillLight::kSun));
    int dark = 0;
    for (std::size_t i = 0; i < frame.radiance.pixels.size(); ++i) {
      const bool is_ground =
          result.composite.change.pixels[i] == static_cast<std::uint8_t>(PixelChange::kScaled);
      dark +=
          is_ground && result.composite.radiance.pixels[i].g < 0.4f * frame.radiance.pixels[i].g;
    }
    return dark;
  };
  // Sky alone is dark only in the corner at the box's foot. In the shade, a quarter is left.
  EXPECT_LT(dark_pixels(0.5), 10);
  EXPECT_GT(dark_pixels(0.7), 100);
}

// Half of the ground lies in a real shadow whose caster the mesh lacks, from as dark as the model
// has shade to half as bright again, on ground that is patchy by a tenth: the object's shadow takes
// no sun from where there is none, and all of it beside.
TEST_F(AbsurdLight, ARealShadowThatTheMeshLacksGetsNoSecondOne) {
  const VirtualObject box = BoxObject({-0.6f, -0.6f, 0.0f}, {0.6f, 0.6f, 0.9f}, kWhite);
  constexpr double kSun = 800.0;
  constexpr double kSky = 100.0;
  const float shade = static_cast<float>(kSky / (kSky + kSun * std::sqrt(0.5)));
  const auto share_left = [&](const Frame& frame, const FrameResult& result, std::size_t pixel) {
    return result.composite.radiance.pixels[pixel].g / frame.radiance.pixels[pixel].g;
  };
  const Frame open = stage_.MakeFrame(kSun, kSky);
  const FrameResult in_the_open = Process(open, glm::dvec3(kSun), glm::dvec3(kSky), box);
  for (const float brightness : {1.0f, 1.2f, 1.5f}) {
    Frame frame = open;
    const std::size_t count = frame.radiance.pixels.size();
    for (std::size_t i = 0; i < count; ++i) {
      frame.radiance.pixels[i] *= 1.0f + 0.1f * std::sin(1.7f * static_cast<float>(i * i % 997));
      if (i < count / 2) frame.radiance.pixels[i] *= brightness * shade;
    }
    const FrameResult result = Process(frame, glm::dvec3(kSun), glm::dvec3(kSky), box);
    int in_real_shadow = 0;
    int in_sun = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const bool is_scaled =
          result.composite.change.pixels[i] != static_cast<std::uint8_t>(PixelChange::kCovered);
      if (!is_scaled || share_left(open, in_the_open, i) > 2.0f * shade) continue;
      if (i < count / 2) {
        // What is left is the box's own light, in the place of the sky's.
        ASSERT_GT(share_left(frame, result, i), 0.6f) << brightness << ", pixel " << i;
        ++in_real_shadow;
      } else {
        ASSERT_LT(share_left(frame, result, i), 2.2f * shade) << brightness << ", pixel " << i;
        ++in_sun;
      }
    }
    EXPECT_GT(in_real_shadow, 20) << brightness;
    EXPECT_GT(in_sun, 20) << brightness;
  }
}

// Linear frames may be brighter than what is written: in the picture, under the object's edge and
// in its shadow.
TEST_F(AbsurdLight, PixelsBeyondHalfFloatsAreClampedAndCounted) {
  const VirtualObject box = BoxObject({-0.6f, -0.6f, 0.0f}, {0.6f, 0.6f, 0.9f}, kWhite);
  Frame frame = stage_.MakeFrame();
  EXPECT_EQ(Process(frame, glm::dvec3(400.0), glm::dvec3(100.0), box).clamped_pixels, 0);
  frame.radiance.At(3, 3) = {1.0f, 1e6f, 65504.0f};
  frame.radiance.At(5, 3) = glm::vec3(3e38f);
  frame.radiance.At(7, 3) = glm::vec3(65504.0f);
  const FrameResult result = Process(frame, glm::dvec3(400.0), glm::dvec3(100.0), box);
  EXPECT_EQ(result.clamped_pixels, 2);
  EXPECT_EQ(result.composite.radiance.At(3, 3), glm::vec3(1.0f, 65504.0f, 65504.0f));
  EXPECT_EQ(result.composite.radiance.At(5, 3), glm::vec3(65504.0f));
  for (glm::vec3& rgb : frame.radiance.pixels) rgb *= 1e6f;
  const FrameResult bright = Process(frame, glm::dvec3(4e8), glm::dvec3(1e8), box);
  EXPECT_GT(bright.clamped_pixels, 96 * 72 - 20);  // Not under the box's edge.
}

// Bright clouds over pale stone, whose red is clipped in most pixels: the few that are left are its
// dark grains. The colour of clouds holds it.
TEST(AbsurdLightHardCases, AClippedChannelOfAnOvercastPictureWithoutAPlaceDoesNotVanish) {
  const std::vector<std::string> shapes{"uniform"};
  for (const bool is_some_red_left : {false, true}) {
    std::vector<DiffuseSample> samples(500);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      samples[i].sky_transport_rgb[0] = glm::dvec3(0.5 / std::numbers::pi);
      samples[i].radiance_rgb = 5.0 * samples[i].sky_transport_rgb[0];
      if (is_some_red_left && i % 20 == 0) {
        samples[i].radiance_rgb.r *= 0.7;
      } else {
        samples[i].radiance_stddev_rgb.r = std::numeric_limits<double>::infinity();
      }
    }
    OutdoorConditions conditions;
    conditions.time = UtcTime{std::chrono::hours(12)};
    conditions.sun.direction_enu = kNoSunDirectionEnu;
    conditions.clear_sky = ScaledClearSky(std::nullopt, nullptr).At(kNoSunDirectionEnu);
    conditions.sky_shape_names = shapes;
    conditions.units = LightUnits::kRelativePerFrame;
    conditions.weather = Weather::kOvercast;
    const auto estimate = OutdoorEstimator(LightingFitOptions{}).Estimate(samples, conditions);
    ASSERT_TRUE(estimate.has_value());
    const glm::dvec3 sky = estimate->lighting.SkyIrradianceRgb();
    EXPECT_NEAR(sky.g, 5.0, 0.25);
    EXPECT_GT(sky.r, 0.6 * sky.g);
    EXPECT_LT(sky.r, 1.4 * sky.g);
    EXPECT_GT(std::sqrt(estimate->lighting.covariance[3 * 6 + 3]), 0.1 * sky.r);
    EXPECT_EQ(estimate->lighting.sun.irradiance_rgb, glm::dvec3(0.0));
  }
}

}  // namespace
}  // namespace pleinair::absurd_light_test
