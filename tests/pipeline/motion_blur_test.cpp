// Objects and shadows blurred by motion, against means of many sharp frames.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "ground_stage.h"
#include "pipeline/display_codes.h"
#include "scene/exposure_motion.h"

namespace pleinair::motion_blur_test {
namespace {

constexpr double kExposureS = 0.02;
constexpr double kFrameS = 0.04;

const Material kLight{.name = "light", .diffuse_albedo = {0.8f, 0.7f, 0.6f}};
const Material kDark{.name = "dark", .diffuse_albedo = {0.05f, 0.1f, 0.2f}};

// How everything moves: the frame's poses are those of time 0.
struct Moves {
  SteadyMotion camera;
  std::vector<SteadyMotion> objects;
};

SteadyMotion Going(const glm::dvec3& velocity_m_s) { return {.velocity_m_s = velocity_m_s}; }

struct Shot {
  Composite composite;
  double bound = 0.0;
  std::string_view why;
  bool has_run = false;
};

class MotionBlur : public testing::Test {
 protected:
  static void SetUpTestSuite() { stage_ = std::make_unique<GroundStage>(); }
  static void TearDownTestSuite() { stage_.reset(); }
  void TearDown() override { distortion_ = {}; }

  // Twice as fine as the stage's own.
  static Frame FrameAt(const Moves& moves, double seconds) {
    Frame frame = stage_->MakeFrame();
    frame.camera.intrinsics = {192, 144, 200.0, 200.0, 95.5, 71.5, distortion_};
    frame.radiance = RgbImage(192, 144, frame.radiance.pixels.front());
    frame.unusable = frame.clipped = Gray8Image(192, 144, 0);
    frame.camera.camera_from_world =
        frame.camera.camera_from_world * glm::inverse(moves.camera.After(seconds));
    frame.time = UtcTime{} + std::chrono::nanoseconds(std::llround(1e9 * (1000.0 + seconds)));
    return frame;
  }

  static std::vector<glm::dmat4> PosesAt(const Moves& moves, double seconds) {
    std::vector<glm::dmat4> poses;
    for (const SteadyMotion& one : moves.objects) poses.push_back(one.After(seconds));
    return poses;
  }

  static FramePipelineOptions Options() {
    FramePipelineOptions options = GroundStage::QuickOptions();
    options.effects = EffectSettings::Everything();
    options.effects[Effect::kCameraBlur] = EffectSwitch::kOff;
    return options;
  }

  // A pipeline of its own for the frames of a test.
  class Camera {
   public:
    Camera(std::vector<VirtualObject> objects, const FramePipelineOptions& options)
        : pipeline_({stage_->Scene(), stage_->Phantom(), std::nullopt, std::move(objects)},
                    std::make_unique<StillLight>(),
                    compositor_,
                    options) {}

    Shot Take(const Frame& frame, const std::vector<glm::dmat4>& poses) {
      auto result = pipeline_.Process(frame, poses);
      if (!result) throw std::runtime_error(result.error().reason);
      Shot shot;
      shot.composite = std::move(result->composite);
      for (const PlannedEffect& effect : result->plan.effects) {
        if (effect.effect != Effect::kMotionBlur) continue;
        shot.bound = effect.bound_code_values;
        shot.why = effect.why;
      }
      shot.has_run = result->plan.runs.Has(Effect::kMotionBlur);
      return shot;
    }

   private:
    HeadlessContext context_;
    Compositor compositor_;
    FramePipeline pipeline_;
  };

  // The frame at time 0 after two before it.
  static Shot Blurred(const std::vector<VirtualObject>& objects,
                      const Moves& moves,
                      double readout_s = 0.0,
                      const FramePipelineOptions& given = Options()) {
    FramePipelineOptions options = given;
    options.motion_blur = {kExposureS, readout_s};
    Camera camera(objects, options);
    for (const double time : {-2.0 * kFrameS, -kFrameS}) {
      camera.Take(FrameAt(moves, time), PosesAt(moves, time));
    }
    return camera.Take(FrameAt(moves, 0.0), PosesAt(moves, 0.0));
  }

  // Each row a mean over its own exposure.
  static RgbImage Truth(const std::vector<VirtualObject>& objects,
                        const Moves& moves,
                        double readout_s = 0.0,
                        const FramePipelineOptions& options = Options()) {
    Camera camera(objects, options);
    constexpr int kInExposure = 32;
    constexpr double kStepS = kExposureS / kInExposure;
    const int around = static_cast<int>(std::ceil(0.5 * readout_s / kStepS));
    const Frame frame = FrameAt(moves, 0.0);
    RgbImage mean(frame.radiance.width, frame.radiance.height, glm::vec3(0.0f));
    std::vector<int> count(static_cast<std::size_t>(mean.height));
    for (int i = -around; i < kInExposure + around; ++i) {
      const double time = (i + 0.5) * kStepS - 0.5 * kExposureS;
      const Composite sharp = camera.Take(FrameAt(moves, time), PosesAt(moves, time)).composite;
      for (int y = 0; y < mean.height; ++y) {
        const double middle = readout_s * ((y + 0.5) / mean.height - 0.5);
        if (!(std::abs(time - middle) < 0.5 * kExposureS)) continue;
        ++count[static_cast<std::size_t>(y)];
        for (int x = 0; x < mean.width; ++x) mean.At(x, y) += sharp.radiance.At(x, y);
      }
    }
    for (int y = 0; y < mean.height; ++y) {
      const auto of_row = static_cast<float>(count[static_cast<std::size_t>(y)]);
      for (int x = 0; x < mean.width; ++x) mean.At(x, y) /= of_row;
    }
    return mean;
  }

  struct Errors {
    double rms = 0.0;  // In code values, over the pixels that motion changes by one or more.
    double rms_without = 0.0;
    int pixels = 0;
    int larger = 0;  // By more than 16 codes.
  };
  static Errors Compare(const RgbImage& blurred, const RgbImage& sharp, const RgbImage& truth) {
    const DisplayCodes codes(ResponseCurve::Srgb(), 1.0 / 150.0);
    Errors errors;
    for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
      const double without = double{codes.Difference(sharp.pixels[i], truth.pixels[i])};
      const double with = double{codes.Difference(blurred.pixels[i], truth.pixels[i])};
      if (with < 1.0 && without < 1.0) continue;
      errors.rms += with * with;
      errors.rms_without += without * without;
      ++errors.pixels;
      errors.larger += with > 16.0 ? 1 : 0;
    }
    errors.rms = std::sqrt(errors.rms / std::max(errors.pixels, 1));
    errors.rms_without = std::sqrt(errors.rms_without / std::max(errors.pixels, 1));
    return errors;
  }

  static Errors ErrorsOf(const std::vector<VirtualObject>& objects,
                         const Moves& moves,
                         double readout_s = 0.0,
                         const FramePipelineOptions& options = Options()) {
    const RgbImage truth = Truth(objects, moves, readout_s, options);
    const Shot blurred = Blurred(objects, moves, readout_s, options);
    FramePipelineOptions without = options;
    without.effects[Effect::kMotionBlur] = EffectSwitch::kOff;
    const Shot sharp = Blurred(objects, moves, readout_s, without);
    EXPECT_TRUE(blurred.has_run) << blurred.why;
    const Errors errors = Compare(blurred.composite.radiance, sharp.composite.radiance, truth);
    RecordProperty("rms_codes", std::to_string(errors.rms));
    RecordProperty("rms_codes_without", std::to_string(errors.rms_without));
    return errors;
  }

  static std::unique_ptr<GroundStage> stage_;
  static std::array<double, 5> distortion_;
};

std::unique_ptr<GroundStage> MotionBlur::stage_;
std::array<double, 5> MotionBlur::distortion_{};

// Edges along rows of pixels would be all in the same place of them.
VirtualObject Turned(VirtualObject object) {
  object.mesh = TransformMesh(
      glm::rotate(glm::dmat4(1.0), 0.4, glm::normalize(glm::dvec3(0.2, 0.0, 1.0))), object.mesh);
  return object;
}
VirtualObject Pillar() {
  return Turned(BoxObject({-0.3f, -0.3f, 0.05f}, {0.3f, 0.3f, 1.0f}, kLight));
}
VirtualObject Plank() {
  return Turned(BoxObject({-0.6f, -0.1f, 0.4f}, {0.6f, 0.1f, 0.6f}, kLight));
}
VirtualObject Ball() { return BallObject({0.0f, 0.0f, 0.8f}, 0.5f, 16, kDark); }

// What is left are edges between pixels' rows, and light that changes on what turns.
void ExpectGood(const auto& errors) {
  EXPECT_GT(errors.rms_without, 9.0);
  EXPECT_LT(errors.rms, 0.3 * errors.rms_without);
  EXPECT_LT(errors.rms, 4.0);
}

// 10 pixels in an exposure.
TEST_F(MotionBlur, AMovingObject) {
  ExpectGood(ErrorsOf({Pillar()}, {{}, {Going({15.0, 0.0, 0.0})}}));
}

TEST_F(MotionBlur, AMovingBall) { ExpectGood(ErrorsOf({Ball()}, {{}, {Going({8.0, 6.0, 2.0})}})); }

TEST_F(MotionBlur, AMovingCamera) {
  ExpectGood(ErrorsOf({Pillar()}, {Going({12.0, 3.0, 3.0}), {{}}}));
}

TEST_F(MotionBlur, ATurningCamera) {
  const SteadyMotion turn{.centre_m = {0.0, -5.2, 3.0}, .turn_rad_s = {0.3, 0.0, 2.0}};
  ExpectGood(ErrorsOf({Ball()}, {turn, {{}}}));
}

// About the sun's direction, so that the light on each face stays what it is.
TEST_F(MotionBlur, ATurningObject) {
  const SteadyMotion turn{.centre_m = {0.0, 0.0, 0.5}, .turn_rad_s = {16.0, 0.0, 16.0}};
  ExpectGood(ErrorsOf({Plank()}, {{}, {turn}}));
}

// Objects stay as bright as they are at the frame's instant: of 0.4 rad that is most of the error.
TEST_F(MotionBlur, AnObjectThatTurnsInTheLight) {
  const SteadyMotion turn{.centre_m = {0.0, 0.0, 0.5}, .turn_rad_s = {0.0, 6.0, 20.0}};
  const Errors errors = ErrorsOf({Plank()}, {{}, {turn}});
  EXPECT_LT(errors.rms, 0.5 * errors.rms_without);
}

// A wall before half of the object, which comes out from behind it.
TEST_F(MotionBlur, AnObjectBehindAWall) {
  stage_ =
      std::make_unique<GroundStage>(GroundStage::Block{{0.0f, -1.2f, 0.0f}, {1.5f, -1.1f, 1.2f}});
  const Errors errors = ErrorsOf({Ball()}, {{}, {Going({10.0, 0.0, 0.0})}});
  stage_ = std::make_unique<GroundStage>();
  ExpectGood(errors);
}

// One in front of the other.
TEST_F(MotionBlur, ObjectsThatMoveOtherwise) {
  VirtualObject before = Pillar();
  before.mesh = TransformMesh(glm::translate(glm::dmat4(1.0), {0.2, -1.0, 0.0}), before.mesh);
  const Errors errors = ErrorsOf({Ball(), before}, {{}, {{}, Going({10.0, 0.0, 0.0})}});
  EXPECT_LT(errors.rms, 0.5 * errors.rms_without);
}

TEST_F(MotionBlur, CameraAndObjectInMotion) {
  ExpectGood(ErrorsOf({Ball()}, {Going({3.0, 0.0, -2.0}), {Going({-5.0, 6.0, 0.0})}}));
}

TEST_F(MotionBlur, RollingShutter) {
  ExpectGood(ErrorsOf({Pillar()}, {{}, {Going({10.0, 0.0, 0.0})}}, 0.03));
}

TEST_F(MotionBlur, ThroughALensWithDistortion) {
  distortion_ = {-0.3, 0.08, 0.001, 0.0, 0.0};
  ExpectGood(ErrorsOf({Pillar()}, {Going({4.0, 0.0, 1.0}), {Going({-8.0, 0.0, 0.0})}}, 0.02));
}

TEST_F(MotionBlur, ShadowsByVolumes) {
  FramePipelineOptions options = Options();
  options.effects[Effect::kPenumbra] = EffectSwitch::kOff;
  ExpectGood(ErrorsOf({Pillar()}, {{}, {Going({12.0, 0.0, 0.0})}}, 0.0, options));
}

void ExpectSame(const Shot& a, const Shot& b) {
  EXPECT_EQ(a.composite.radiance.pixels, b.composite.radiance.pixels);
  EXPECT_EQ(a.composite.change.pixels, b.composite.change.pixels);
}

class MotionBlurHardCases : public MotionBlur {
 protected:
  static Shot LastOf(const std::vector<VirtualObject>& objects,
                     const std::vector<std::pair<double, glm::dmat4>>& takes,
                     EffectSwitch asked = EffectSwitch::kOn,
                     double exposure_s = kExposureS) {
    FramePipelineOptions options = Options();
    options.effects[Effect::kMotionBlur] = asked;
    options.motion_blur = {exposure_s, 0.0};
    Camera camera(objects, options);
    Shot last;
    for (const auto& [seconds, pose] : takes) {
      Frame frame = FrameAt({}, 0.0);
      frame.time += std::chrono::nanoseconds(std::llround(1e9 * seconds));
      last = camera.Take(frame, {pose});
    }
    return last;
  }
  static glm::dmat4 At(double x_m) {
    return glm::translate(glm::dmat4(1.0), glm::dvec3(x_m, 0.0, 0.0));
  }
  static void ExpectSharp(const std::vector<std::pair<double, glm::dmat4>>& takes,
                          std::string_view why) {
    const Shot shot = LastOf({Pillar()}, takes);
    EXPECT_EQ(shot.bound, 0.0);
    EXPECT_EQ(shot.why, why);
    ExpectSame(shot, LastOf({Pillar()}, takes, EffectSwitch::kOff));
  }
};

TEST_F(MotionBlurHardCases, WhatStandsStillIsAsWithoutTheEffect) {
  ExpectSharp({{0.0, At(0.1)}, {0.04, At(0.1)}}, "nothing moves");
  const Shot planned = LastOf({Pillar()}, {{0.0, At(0.1)}, {0.04, At(0.1)}}, EffectSwitch::kPlan);
  EXPECT_FALSE(planned.has_run);
}

// The sun's image is thousands of times as bright as what is beside it.
TEST_F(MotionBlurHardCases, BesideAGlintNothingIsBlack) {
  VirtualObject ball = Ball();
  for (Material& material : ball.mesh.materials) {
    material.specular_reflectance = glm::vec3(0.8f);
    material.roughness = 0.1f;
  }
  const Shot shot = Blurred({ball}, {{}, {Going({8.0, 6.0, 2.0})}});
  EXPECT_TRUE(shot.has_run);
  float brightest = 0.0f;
  int covered = 0;
  for (std::size_t i = 0; i < shot.composite.change.pixels.size(); ++i) {
    if (shot.composite.change.pixels[i] != static_cast<std::uint8_t>(PixelChange::kCovered))
      continue;
    const glm::vec3& rgb = shot.composite.radiance.pixels[i];
    EXPECT_GT(std::min({rgb.r, rgb.g, rgb.b}), 0.5f) << i;
    brightest = std::max(brightest, rgb.g);
    ++covered;
  }
  EXPECT_GT(covered, 500);
  EXPECT_GT(brightest, 2e3f);
}

TEST_F(MotionBlurHardCases, NeedsAPoseShortlyBefore) {
  ExpectSharp({{0.0, At(0.0)}}, "no pose of a frame before");
  ExpectSharp({{0.0, At(0.0)}, {0.0, At(0.1)}}, "no pose of a frame before");
  ExpectSharp({{0.0, At(0.0)}, {-0.04, At(0.1)}}, "frames too far apart, or not in order");
  ExpectSharp({{0.0, At(0.0)}, {1.0, At(0.1)}}, "frames too far apart, or not in order");
}

TEST_F(MotionBlurHardCases, NeedsAnExposure) {
  const std::vector<std::pair<double, glm::dmat4>> takes{{0.0, At(0.0)}, {0.04, At(0.05)}};
  const Shot unknown = LastOf({Pillar()}, takes, EffectSwitch::kOn, 0.0);
  EXPECT_EQ(unknown.why, "no exposure time");
  ExpectSame(unknown, LastOf({Pillar()}, takes, EffectSwitch::kOff));
  EXPECT_GT(LastOf({Pillar()}, takes).bound, 1.0);
}

// Milliseconds, say, where seconds are meant: the motion is known from frame to frame only.
TEST_F(MotionBlurHardCases, IsBlurredOverNoMoreThanAFrameLasts) {
  const std::vector<std::pair<double, glm::dmat4>> takes{{0.0, At(0.0)}, {0.04, At(0.05)}};
  const Shot longest = LastOf({Pillar()}, takes, EffectSwitch::kOn, 0.04);
  EXPECT_TRUE(longest.has_run);
  ExpectSame(longest, LastOf({Pillar()}, takes, EffectSwitch::kOn, 20.0));
}

// A metre is 33 pixels; 0.1 m a frame is a motion, from the second frame on.
TEST_F(MotionBlurHardCases, DoesNotBlurOverACut) {
  ExpectSharp({{0.0, At(0.0)}, {0.04, At(0.0)}, {0.08, At(1.0)}}, "nothing moves");
  ExpectSharp({{0.0, At(0.0)}, {0.04, At(0.1)}, {0.08, At(-1.4)}}, "nothing moves");
  ExpectSharp({{0.0, At(0.0)}, {0.04, At(0.0)}, {0.08, At(1.0)}, {0.12, At(1.0)}}, "nothing moves");
  EXPECT_TRUE(LastOf({Pillar()}, {{0.0, At(0.0)}, {0.04, At(0.5)}, {0.08, At(1.0)}}).bound > 1.0);
}

TEST_F(MotionBlurHardCases, ACameraThatJumpsIsACut) {
  const auto shot = [](double jump_m, EffectSwitch asked) {
    FramePipelineOptions options = Options();
    options.effects[Effect::kMotionBlur] = asked;
    options.motion_blur = {kExposureS, 0.0};
    Camera camera({Pillar()}, options);
    Shot last;
    for (int i = 0; i < 3; ++i) {
      Frame frame = FrameAt({}, kFrameS * i);
      frame.camera.camera_from_world =
          frame.camera.camera_from_world * At(i < 2 ? 0.02 * i : jump_m);
      last = camera.Take(frame, {glm::dmat4(1.0)});
    }
    return last;
  };
  const Shot jumped = shot(2.0, EffectSwitch::kOn);
  EXPECT_EQ(jumped.bound, 0.0);
  ExpectSame(jumped, shot(2.0, EffectSwitch::kOff));
  EXPECT_GT(shot(0.04, EffectSwitch::kOn).bound, 1.0);
}

TEST_F(MotionBlurHardCases, WhatMirrorsOrVanishesIsACut) {
  for (const double scale : {-1.0, 0.0}) {
    const glm::dmat4 other = glm::scale(glm::dmat4(1.0), glm::dvec3(scale, 1.0, 1.0));
    EXPECT_FALSE(MotionOf(other, 0.04, glm::dvec3(0.0)).has_value()) << scale;
  }
}

// The object that is moved in a frame that stands is not blurred by that, and the others are.
TEST_F(MotionBlurHardCases, AFrameTakenAgainKeepsItsMotion) {
  ExpectSame(LastOf({Pillar()}, {{0.0, At(0.0)}, {0.04, At(0.1)}, {0.04, At(0.1)}}),
             LastOf({Pillar()}, {{0.0, At(0.0)}, {0.04, At(0.1)}}));
  EXPECT_EQ(LastOf({Pillar()}, {{0.0, At(0.0)}, {0.04, At(0.1)}, {0.04, At(0.12)}}).bound, 0.0);
}

TEST_F(MotionBlurHardCases, PixelsBeyondItsReachStayTheCamerasOwn) {
  const Moves moves{{}, {Going({15.0, 0.0, 0.0})}};
  const Shot blurred = Blurred({Pillar()}, moves);
  FramePipelineOptions without = Options();
  without.effects[Effect::kMotionBlur] = EffectSwitch::kOff;
  const Shot sharp = Blurred({Pillar()}, moves, 0.0, without);
  const Frame frame = FrameAt(moves, 0.0);
  constexpr int kReach = 9;  // Half of 10 px, of the nearest ground 14, and 2.
  for (int y = 0; y < frame.radiance.height; ++y) {
    for (int x = 0; x < frame.radiance.width; ++x) {
      if (blurred.composite.change.At(x, y) == 0) {
        ASSERT_EQ(blurred.composite.radiance.At(x, y), frame.radiance.At(x, y));
        continue;
      }
      bool is_near = false;
      for (int dx = -kReach; dx <= kReach; ++dx) {
        for (int dy = -2; dy <= 2; ++dy) {
          is_near |= sharp.composite.change.Contains(x + dx, y + dy) &&
                     sharp.composite.change.At(x + dx, y + dy) != 0;
        }
      }
      EXPECT_TRUE(is_near) << x << ", " << y;
    }
  }
}

TEST_F(MotionBlurHardCases, LeavingItOutChangesNoMoreThanItsBound) {
  const Shot blurred = LastOf({Pillar()}, {{0.0, At(0.0)}, {0.04, At(1e-4)}});
  const Shot sharp = LastOf({Pillar()}, {{0.0, At(0.0)}, {0.04, At(1e-4)}}, EffectSwitch::kOff);
  EXPECT_LT(blurred.bound, 60.0);
  const Frame frame = FrameAt({}, 0.0);
  const DisplayCodes codes(ResponseCurve::Srgb(), ChosenExposure(frame.radiance));
  double largest = 0.0;
  for (std::size_t i = 0; i < frame.radiance.pixels.size(); ++i) {
    largest = std::max(largest,
                       double{codes.Difference(blurred.composite.radiance.pixels[i],
                                               sharp.composite.radiance.pixels[i])});
  }
  EXPECT_LE(largest, blurred.bound);
}

}  // namespace
}  // namespace pleinair::motion_blur_test
