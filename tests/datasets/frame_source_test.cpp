#include "datasets/frame_source.h"

#include <cmath>
#include <limits>

#include "scene/image_io.h"
#include "scene/srgb.h"
#include "tests/datasets/sequence_fixture.h"

namespace pleinair::frame_source_test {
namespace {

class FrameSourceTest : public SequenceFolder {
 protected:
  void SetUp() override {
    SequenceFolder::SetUp();
    document_ = Everything();
    document_["frames"][0].erase("fisheye");
    linear_ = RgbImage(8, 6, glm::vec3(20.0f, 40.0f, 60.0f));
    linear_.At(1, 0) = glm::vec3(std::numeric_limits<float>::quiet_NaN(), 1.0f, 1.0f);
    linear_.At(2, 0) = glm::vec3(1.0f, std::numeric_limits<float>::infinity(), 1.0f);
    linear_.At(3, 0) = glm::vec3(1.0f, 1.0f, -0.5f);
    linear_.At(4, 0) = glm::vec3(1e4f, 1e4f, 1e4f);
    WriteExr(folder_ / "frames/0.exr", linear_, ExrPrecision::kFloat);
    codes_ = Rgb8Image(8, 6, glm::u8vec3(100, 120, 140));
    codes_.At(1, 0) = glm::u8vec3(100, 254, 100);
    codes_.At(2, 0) = glm::u8vec3(100, 253, 100);
    codes_.At(3, 0) = glm::u8vec3(100, 100, 2);
    codes_.At(4, 0) = glm::u8vec3(100, 100, 3);
    WritePng(folder_ / "frames/0.png", codes_);
    WritePng(folder_ / "frames/1.png", codes_);
  }

  Sequence Read() {
    WriteDocument(document_);
    return ReadSequence(folder_);
  }

  nlohmann::json document_;
  RgbImage linear_;
  Rgb8Image codes_;
};

TEST_F(FrameSourceTest, PlaysLinearFramesWithTheirDefectsMarked) {
  const auto source = MakeRecordedFrameSource(Read(), FrameKind::kLinear);
  EXPECT_EQ(source->Count(), 2);
  const auto next = source->Next();
  ASSERT_TRUE(next && next->has_value());
  const Frame& frame = **next;
  EXPECT_EQ(frame.index, 0);
  EXPECT_EQ(frame.camera.intrinsics.width_px, 8);
  EXPECT_EQ(frame.exposure, 0.0125);
  EXPECT_EQ(frame.sun_direction_enu, glm::dvec3(0.0, -0.6, 0.8));
  EXPECT_EQ(frame.weather, Weather::kClear);
  EXPECT_EQ(frame.sample_polygons.size(), 1u);
  EXPECT_FALSE(frame.codes);
  EXPECT_EQ(frame.radiance.At(0, 0), glm::vec3(20.0f, 40.0f, 60.0f));
  EXPECT_TRUE(std::isnan(frame.radiance.At(1, 0).x));
  for (int x = 0; x < 8; ++x) {
    EXPECT_EQ(frame.unusable.At(x, 0), x >= 1 && x <= 3 ? 1 : 0) << x;
    EXPECT_EQ(frame.clipped.At(x, 0), 0);
  }
}

// Without an environment map the mask is over the first frame, and says nothing of another view.
TEST_F(FrameSourceTest, AppliesAMaskOverTheFirstFrameToFramesOfThatCamera) {
  Rgb8Image mask(8, 6, glm::u8vec3(255));
  mask.At(6, 2) = glm::u8vec3(0);
  WritePng(folder_ / "mask.png", mask);
  WritePng(folder_ / "frames/1.png", codes_);
  document_.erase("environment");
  for (auto& frame : document_["frames"]) frame.erase("camera_from_world");
  const auto source = MakeRecordedFrameSource(Read(), FrameKind::kLdr);
  for (int i = 0; i < 2; ++i) {
    const auto next = source->Next();
    ASSERT_TRUE(next && next->has_value());
    EXPECT_EQ((*next)->unusable.At(6, 2), 1) << i;
    EXPECT_EQ((*next)->unusable.At(5, 2), 0) << i;
  }
  Sequence moved = Read();
  moved.frames[1].camera_from_world = glm::dmat4(1.0);
  const auto moving = MakeRecordedFrameSource(moved, FrameKind::kLdr);
  moving->Next();
  EXPECT_EQ((*moving->Next())->unusable.At(6, 2), 0);
}

TEST_F(FrameSourceTest, PlaysEightBitFramesAsRadiance) {
  const auto source = MakeRecordedFrameSource(Read(), FrameKind::kLdr);
  const auto next = source->Next();
  ASSERT_TRUE(next && next->has_value());
  const Frame& frame = **next;
  ASSERT_TRUE(frame.codes);
  EXPECT_EQ(frame.codes->pixels, codes_.pixels);
  EXPECT_NEAR(frame.radiance.At(0, 0).y, LinearFromSrgb(120.0 / 255.0) / 0.0125, 1e-4);
  const int clipped[8] = {0, 1, 0, 0, 0, 0, 0, 0};
  const int unusable[8] = {0, kClipped[1], 0, kNearBlack, 0, 0, 0, 0};
  EXPECT_EQ(frame.units, LightUnits::kAbsolute);
  ASSERT_NE(frame.noise, nullptr);
  EXPECT_GT(frame.noise->Variance(0, 0.5), 0.0);
  for (int x = 0; x < 8; ++x) {
    EXPECT_EQ(frame.clipped.At(x, 0), clipped[x]) << x;
    EXPECT_EQ(frame.unusable.At(x, 0), unusable[x]) << x;
  }
}

// Units with the exposure, with only a camera's metadata, and with neither.
TEST_F(FrameSourceTest, SaysWhatEightBitLightIsMeasuredIn) {
  Sequence sequence = Read();
  FrameEntry& entry = sequence.frames.front();
  const auto units_of = [&] {
    const auto source = MakeRecordedFrameSource(sequence, FrameKind::kLdr);
    return source->Next()->value().units;
  };
  EXPECT_EQ(units_of(), LightUnits::kAbsolute);
  entry.exposure.reset();
  entry.exposure_s.reset();
  EXPECT_EQ(units_of(), LightUnits::kRelativePerFrame);
  entry.exposure_s = 0.01;
  entry.iso = 100.0;
  entry.f_number = 8.0;
  EXPECT_EQ(units_of(), LightUnits::kRelative);
  EXPECT_EQ(MakeRecordedFrameSource(sequence, FrameKind::kLdr)->Next()->value().exposure_s, 0.01);
  const auto linear = MakeRecordedFrameSource(sequence, FrameKind::kLinear);
  const Frame frame = linear->Next()->value();
  EXPECT_EQ(frame.units, LightUnits::kAbsolute);
  EXPECT_EQ(frame.noise, nullptr);
}

TEST_F(FrameSourceTest, PlaysTheOneKindThereIsAndEnds) {
  const auto source = MakeRecordedFrameSource(Read(), FrameKind::kLinear);
  source->Next();
  const auto second = source->Next();
  ASSERT_TRUE(second && second->has_value());
  EXPECT_TRUE((*second)->codes);
  EXPECT_EQ((*second)->index, 1);
  // Nothing says what exposure 1 is: light in [0, 1].
  EXPECT_FALSE((*second)->exposure);
  EXPECT_NEAR((*second)->radiance.At(0, 0).x, LinearFromSrgb(100.0 / 255.0), 1e-6);
  EXPECT_FALSE(source->Next());
  EXPECT_FALSE(source->Next());
}

TEST_F(FrameSourceTest, FollowsAResponseFile) {
  std::vector<double> list;
  for (int code = 0; code < 256; ++code) list.push_back(code / 255.0);
  const nlohmann::json response = {
      {"format", "pleinair-response"}, {"version", 1}, {"linear_of_code_rgb", {list, list, list}}};
  Write(folder_ / "response.json", response.dump());
  document_["radiometry"]["frames_ldr"] = "response.json";
  const auto source = MakeRecordedFrameSource(Read(), FrameKind::kLdr);
  const auto next = source->Next();
  ASSERT_TRUE(next && next->has_value());
  EXPECT_NEAR((*next)->radiance.At(0, 0).x, 100.0 / 255.0 / 0.0125, 1e-4);
  Write(folder_ / "response.json", "{}");
  EXPECT_THROW(MakeRecordedFrameSource(ReadSequence(folder_), FrameKind::kLdr), std::runtime_error);
}

TEST_F(FrameSourceTest, PlaysTheRecordedOnes) {
  const std::filesystem::path shared = std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences";
  if (!std::filesystem::is_directory(shared)) GTEST_SKIP() << "no recordings in " << shared;
  for (const char* name : {"courtyard-clouds", "berlin-photos"}) {
    const auto source = MakeRecordedFrameSource(ReadSequence(shared / name), FrameKind::kLinear);
    const auto next = source->Next();
    ASSERT_TRUE(next && next->has_value()) << (*next).error().reason;
    EXPECT_GT((*next)->radiance.At(240, 300).x, 0.0f);
  }
}

}  // namespace
}  // namespace pleinair::frame_source_test
