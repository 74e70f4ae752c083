// Objects in pictures of a camera that records light otherwise than its stated response says.
#include <cmath>

#include <gtest/gtest.h>

#include "calib/response_correction.h"
#include "ground_stage.h"
#include "pipeline/display_codes.h"

namespace pleinair::recorded_composite_test {
namespace {

constexpr double kSun = 2.0;
constexpr double kSky = 0.5;

class RecordedLight : public StillLight {
 public:
  explicit RecordedLight(const ResponseCorrection& response)
      : StillLight(kSun, kSky), response_(response) {}

  tl::expected<LightingEstimate, LightingFailure> Estimate(
      const LightingObservation& observation) override {
    auto estimate = StillLight::Estimate(observation);
    estimate->response = response_;
    return estimate;
  }

 private:
  ResponseCorrection response_;
};

class RecordedComposite : public testing::Test {
 protected:
  FrameResult Process(const Frame& frame, const ResponseCorrection& response) {
    FramePipelineOptions options = GroundStage::QuickOptions();
    options.camera_matching.noise = false;
    options.camera_matching.blur = false;
    const Material grey{.name = "grey", .diffuse_albedo = glm::vec3(0.5f, 0.4f, 0.3f)};
    return stage_.Process(frame,
                          std::make_unique<RecordedLight>(response),
                          BallObject({0, 0, 0.5f}, 0.5f, 12, grey),
                          options,
                          compositor_);
  }

  const GroundStage stage_;
  const HeadlessContext context_;
  Compositor compositor_;
};

// As an 8-bit picture of unknown exposure.
Frame RecordedOf(const Frame& light, const ResponseCorrection& response) {
  Frame recorded = light;
  const LensCircle circle = LensCircle::Of(light.radiance.width, light.radiance.height);
  for (int y = 0; y < light.radiance.height; ++y) {
    for (int x = 0; x < light.radiance.width; ++x) {
      const double share = circle.ShareOfCorner({x + 0.5, y + 0.5});
      recorded.radiance.At(x, y) = Recorded(light.radiance.At(x, y), response, share);
    }
  }
  const ResponseCurve srgb = ResponseCurve::Srgb();
  recorded.codes = CodesFromRadiance(recorded.radiance, srgb, 1.0);
  recorded.radiance = RadianceFromCodes(*recorded.codes, srgb, 1.0);
  recorded.units = LightUnits::kRelativePerFrame;
  return recorded;
}

// What is darker than the veil is no brighter in a virtual shadow.
TEST_F(RecordedComposite, BlackStaysBlackInAShadow) {
  const ResponseCorrection response{.veil_rgb = glm::dvec3(0.03), .exponent = -0.1};
  Frame frame = RecordedOf(stage_.MakeFrame(kSun, kSky), response);
  const auto scaled = static_cast<std::uint8_t>(PixelChange::kScaled);
  const FrameResult lit = Process(frame, response);
  int blackened = 0;
  for (std::size_t i = 0; i < frame.codes->pixels.size(); ++i) {
    if (lit.composite.change.pixels[i] != scaled) continue;
    frame.codes->pixels[i] = glm::u8vec3(0);
    frame.radiance.pixels[i] = glm::vec3(0.0f);
    ++blackened;
  }
  EXPECT_GT(blackened, 200);
  const FrameResult black = Process(frame, response);
  for (std::size_t i = 0; i < frame.codes->pixels.size(); ++i) {
    if (lit.composite.change.pixels[i] != scaled) continue;
    EXPECT_EQ(black.composite.radiance.pixels[i], glm::vec3(0.0f)) << i;
  }
}

// The object and its shadow are those of the picture without the camera's faults, recorded with
// them; a code or two are lost to the rounding of what is real.
TEST_F(RecordedComposite, IsTheLightsOwnAsTheCameraRecordsIt) {
  const ResponseCorrection response{.unit_rgb = {1.1, 1.0, 0.9},
                                    .veil_rgb = {0.01, 0.02, 0.03},
                                    .vignetting = 0.3,
                                    .saturation = 0.2,
                                    .exponent = -0.2};
  const Frame light = stage_.MakeFrame(kSun, kSky);
  const FrameResult in_light = Process(light, {});

  const Frame recorded = RecordedOf(light, response);
  const LensCircle circle = LensCircle::Of(light.radiance.width, light.radiance.height);
  const auto record = [&](const RgbImage& radiance, int x, int y) {
    return Recorded(radiance.At(x, y), response, circle.ShareOfCorner({x + 0.5, y + 0.5}));
  };
  const ResponseCurve srgb = ResponseCurve::Srgb();
  const FrameResult found = Process(recorded, response);

  int changed = 0;
  for (int y = 0; y < light.radiance.height; ++y) {
    for (int x = 0; x < light.radiance.width; ++x) {
      const glm::vec3& is = found.composite.radiance.At(x, y);
      if (found.composite.change.At(x, y) == 0) {
        EXPECT_EQ(is, recorded.radiance.At(x, y)) << x << ' ' << y;
        continue;
      }
      ++changed;
      const glm::u8vec3 code = CodeFromRadiance(is, srgb, 1.0);
      const glm::u8vec3 expected =
          CodeFromRadiance(record(in_light.composite.radiance, x, y), srgb, 1.0);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(code[c], expected[c], 2) << x << ' ' << y;
    }
  }
  EXPECT_GT(changed, 500);
}

// Nothing is lost on the way to light and back, where no code is black or clipped.
TEST(ResponseCorrection, LightIsTheInverseOfWhatIsRecorded) {
  const ResponseCorrection response{.unit_rgb = {1.2, 1.0, 0.8},
                                    .veil_rgb = {0.001, 0.002, 0.003},
                                    .vignetting = 0.4,
                                    .saturation = 0.1,
                                    .exponent = 0.15};
  EXPECT_FALSE(response.IsNone());
  EXPECT_TRUE(ResponseCorrection().IsNone());
  Rgb8Image codes(16, 12);
  for (std::size_t i = 0; i < codes.pixels.size(); ++i) {
    codes.pixels[i] = glm::u8vec3(255 - i, 60 + i, 128);
  }
  const ResponseCurve srgb = ResponseCurve::Srgb();
  RgbImage light(16, 12, glm::vec3(9.0f));  // Of another picture.
  LightOf(codes, srgb, response, light);
  const LensCircle circle = LensCircle::Of(16, 12);
  EXPECT_DOUBLE_EQ(circle.ShareOfCorner({16.0, 0.0}), 1.0);
  EXPECT_DOUBLE_EQ(circle.ShareOfCorner({8.0, 6.0}), 0.0);
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 16; ++x) {
      const double share = circle.ShareOfCorner({x + 0.5, y + 0.5});
      const glm::vec3 recorded = Recorded(light.At(x, y), response, share);
      EXPECT_EQ(CodeFromRadiance(recorded, srgb, 1.0), codes.At(x, y)) << x << ' ' << y;
    }
  }
  // What is darker than the veil is black, not negative.
  LightOf(Rgb8Image(2, 2, glm::u8vec3(0)), srgb, response, light);
  ASSERT_EQ(light.pixels.size(), 4u);
  EXPECT_EQ(light.At(1, 1), glm::vec3(0.0f));
}

// Codes of grey light are those of the picture that is recorded of it.
TEST(DisplayCodes, FollowACorrectedResponse) {
  const ResponseCorrection response{.unit_rgb = {1.1, 1.0, 0.9}, .exponent = -0.1};
  const DisplayCodes codes(ResponseCurve::Srgb(), 1.0, response);
  const DisplayCodes of_picture(ResponseCurve::Srgb(), 1.0);
  for (float light = 0.01f; light < 0.8f; light += 0.037f) {
    const glm::vec3 recorded = Recorded(glm::vec3(light), response, 0.0);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(codes.Code(c, light), of_picture.Code(c, recorded[c]), 0.1f) << light;
    }
  }
}

}  // namespace
}  // namespace pleinair::recorded_composite_test
