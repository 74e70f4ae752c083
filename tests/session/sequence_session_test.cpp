#include "session/sequence_session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <variant>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scene/temporary_folder.h"
#include "tests/session/bundled_courtyard.h"

namespace pleinair::sequence_session_test {
namespace {

using testing::Contains;
using testing::HasSubstr;

SessionOptions CoarseOptions() {
  SessionOptions options = CoarseCourtyard();
  options.pipeline.object_light.route = ObjectLight::kSingleProbe;
  return options;
}

// Prepared once for all tests of the file.
class SequenceSessionTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { loaded_ = LoadSequence(CoarseOptions()); }
  static void TearDownTestSuite() { loaded_.reset(); }

  static SequenceSession MakeSession(const SessionOptions& options = CoarseOptions()) {
    return SequenceSession(loaded_, options);
  }

  static std::shared_ptr<const LoadedSequence> loaded_;
};
std::shared_ptr<const LoadedSequence> SequenceSessionTest::loaded_;

// How far apart two composites are at most, of radiances that are both finite.
float LargestDifference(const RgbImage& a, const RgbImage& b) {
  EXPECT_EQ(a.pixels.size(), b.pixels.size());
  float largest = 0.0f;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c)
      largest = std::max(largest, std::abs(a.pixels[i][c] - b.pixels[i][c]));
  }
  return largest;
}

TEST_F(SequenceSessionTest, ACapturedPictureIsCompositedAsTheSequencesOwn) {
  SequenceSession recorded = MakeSession();
  const auto step = recorded.Next();
  ASSERT_TRUE(step && step->result);
  CapturedPicture captured;
  captured.picture = step->frame->radiance;
  captured.time = step->frame->time;
  SequenceSession own = MakeSession();
  const SessionStep of_own = own.Process(captured);
  ASSERT_TRUE(of_own.result) << of_own.result.error().reason;
  EXPECT_EQ(LargestDifference(step->result->composite.radiance, of_own.result->composite.radiance),
            0.0f);
}

TEST_F(SequenceSessionTest, FramesOfAnotherSourceAtASiteAreCompositedAsTheSequencesOwn) {
  SequenceSession recorded = MakeSession();
  const auto step = recorded.Next();
  ASSERT_TRUE(step && step->result) << step->result.error().reason;

  const SessionOptions options = CoarseOptions();
  const auto site = LoadSite(options, loaded_->sequence.frames.front().time);
  EXPECT_FALSE(site->sequence.HasPictures());
  SequenceSession at_site(
      site, options, MakeRecordedFrameSource(loaded_->sequence, FrameKind::kLinear));
  const auto same = at_site.Next();
  ASSERT_TRUE(same && same->result) << same->result.error().reason;
  EXPECT_EQ(LargestDifference(same->result->composite.radiance, step->result->composite.radiance),
            0.0f);
}

TEST_F(SequenceSessionTest, FramesCanBeTakenOutOfOrder) {
  SequenceSession session = MakeSession();
  const auto first = session.Next();
  ASSERT_TRUE(first && first->result);
  ASSERT_TRUE(session.Seek(2));
  const auto third = session.Next();
  ASSERT_TRUE(third && third->result) << third->result.error().reason;
  EXPECT_EQ(third->frame->index, 2);
  EXPECT_EQ(third->frame->time, loaded_->sequence.frames[2].time);
  ASSERT_TRUE(session.Seek(0));
  EXPECT_EQ(session.Next()->frame->index, 0);
}

class ObjectsOfASession : public SequenceSessionTest {
 protected:
  ObjectsOfASession()
      : session_(MakeSession(WithoutMemory())), objects_(loaded_->sequence.virtual_objects) {}

  // A frame's composite is then the same whatever came before.
  SessionOptions WithoutMemory() {
    SessionOptions options = CoarseOptions();
    options.pipeline.filter.reset();
    options.pipeline.camera_matching.blur = false;
    options.lighting = folder_.Write("light.jsonl",
                                     "{\"frame\": 0, \"sun_irradiance_rgb\": [700, 650, 600], "
                                     "\"sky_irradiance_rgb\": [60, 90, 120], "
                                     "\"sky_shape\": {\"uniform\": [1, 1, 1]}}\n");
    return options;
  }

  std::vector<glm::vec3> CompositeOf(const std::vector<VirtualObjectEntry>& objects) {
    session_.SetObjects(objects);
    session_.Seek(0);
    auto step = session_.Next();
    EXPECT_TRUE(step->result) << step->result.error().reason;
    return std::move(step->result->composite.radiance.pixels);
  }

  TemporaryFolder folder_;
  SequenceSession session_;
  std::vector<VirtualObjectEntry> objects_;
};

TEST_F(ObjectsOfASession, MoveAndComeBack) {
  const auto at_home = CompositeOf(objects_);
  std::vector<VirtualObjectEntry> elsewhere = objects_;
  elsewhere[0].world_from_object[3].x += 0.5;
  EXPECT_FALSE(CompositeOf(elsewhere) == at_home);
  EXPECT_TRUE(CompositeOf(objects_) == at_home);
}

// An estimate depends on the frames before: the light of a frame that is drawn again may not.
TEST_F(ObjectsOfASession, AreDrawnAgainInTheLightThatWasFound) {
  SequenceSession estimating = MakeSession();
  SessionStep first = *estimating.Next();
  ASSERT_TRUE(first.result);
  const auto at_home = first.result->composite.radiance.pixels;
  const glm::dvec3 sun = first.result->estimate.lighting.sun.irradiance_rgb;
  std::vector<VirtualObjectEntry> elsewhere = objects_;
  elsewhere[0].world_from_object[3].x += 0.5;
  estimating.SetObjects(elsewhere);
  SessionStep moved = estimating.Redraw(first);
  ASSERT_TRUE(moved.result);
  EXPECT_FALSE(moved.result->composite.radiance.pixels == at_home);
  estimating.SetObjects(objects_);
  const SessionStep back = estimating.Redraw(moved);
  ASSERT_TRUE(back.result);
  EXPECT_EQ(back.result->estimate.lighting.sun.irradiance_rgb, sun);
  EXPECT_TRUE(back.result->composite.radiance.pixels == at_home);
}

TEST_F(ObjectsOfASession, AreAddedAndTakenAway) {
  const auto one = CompositeOf(objects_);
  std::vector<VirtualObjectEntry> two = objects_;
  two.push_back(objects_[0]);
  two[1].world_from_object[3].x += 0.5;
  const auto both = CompositeOf(two);
  EXPECT_FALSE(both == one);
  // The copy alone is where it was put, not where its file's first entry stands.
  const auto copy = CompositeOf({two[1]});
  EXPECT_FALSE(copy == one);
  EXPECT_FALSE(copy == both);

  session_.SetObjects({});
  session_.Seek(0);
  const auto none = session_.Next();
  ASSERT_TRUE(none && none->result);
  EXPECT_TRUE(none->result->composite.radiance.pixels == none->frame->radiance.pixels);
  EXPECT_TRUE(CompositeOf(objects_) == one);
}

TEST_F(ObjectsOfASession, StayWhereANewFileCannotBeRead) {
  const auto before = CompositeOf(objects_);
  std::vector<VirtualObjectEntry> bad = objects_;
  bad.push_back({"no-such-file.obj", glm::dmat4(1.0)});
  EXPECT_THROW(session_.SetObjects(bad), std::runtime_error);
  EXPECT_TRUE(CompositeOf(objects_) == before);
}

TEST(LoadedSequence, FramesThatDoNotFitIntoMemoryAreRefusedFirst) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "huge_frames";
  std::filesystem::remove_all(folder);
  std::filesystem::copy(CoarseOptions().sequence, folder);  // Without frames: none is read.
  Sequence huge = ReadSequence(folder);
  huge.intrinsics.width_px = 65536;
  huge.intrinsics.height_px = 65536;
  WriteSequence(huge, folder);
  SessionOptions options = CoarseOptions();
  options.sequence = folder;
  try {
    LoadSequence(options);
    ADD_FAILURE() << "a terabyte was there";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("frames of 65536x65536 pixels may take 1040.0 GiB"));
  }
}

// The clear sky is then less bright around the sun.
TEST_F(SequenceSessionTest, AStatedHazeIsUsed) {
  SessionOptions options = CoarseOptions();
  options.haze = 0.01;
  const auto stated = LoadSequence(options);
  EXPECT_EQ(stated->scene.aerosol_optical_depth_500nm, 0.01);
  EXPECT_THAT(stated->site.notes, Contains(HasSubstr("by the stated haze: 0.01 at 500 nm")));
  const auto light = [](std::shared_ptr<const LoadedSequence> sequence) {
    SequenceSession session(std::move(sequence), CoarseOptions());
    const auto step = session.Next();
    return step.value().result.value().estimate.lighting.SkyIrradianceRgb();
  };
  EXPECT_NE(light(stated), light(loaded_));
}

TEST_F(SequenceSessionTest, CodeValuesWithoutAnExposureAreRelative) {
  SessionOptions options = CoarseOptions();
  options.frames = FrameKind::kLdr;
  SequenceSession recorded(loaded_, CoarseOptions());
  const auto step = recorded.Next();
  ASSERT_TRUE(step && step->result);
  CapturedPicture captured;
  captured.picture = recorded.Show(*step);
  captured.time = step->frame->time;
  SequenceSession own = MakeSession(options);
  const SessionStep relative = own.Process(captured);
  ASSERT_TRUE(relative.result) << relative.result.error().reason;
  EXPECT_EQ(relative.result->estimate.units, LightUnits::kRelativePerFrame);
  captured.exposure = 0.02;
  const SessionStep absolute = own.Process(captured);
  ASSERT_TRUE(absolute.result);
  EXPECT_EQ(absolute.result->estimate.units, LightUnits::kAbsolute);
  EXPECT_EQ(absolute.frame->index, 1);
  options.ignore_exposure = true;
  const SessionStep ignored = MakeSession(options).Process(captured);
  ASSERT_TRUE(ignored.result);
  EXPECT_EQ(ignored.result->estimate.units, LightUnits::kRelativePerFrame);
  // What nothing virtual touches keeps the camera's codes.
  const Rgb8Image shown = own.Show(absolute);
  const auto& codes = std::get<Rgb8Image>(captured.picture);
  const Composite& composite = absolute.result->composite;
  for (std::size_t i = 0; i < shown.pixels.size(); ++i) {
    if (composite.change.pixels[i] != static_cast<std::uint8_t>(PixelChange::kNone)) continue;
    ASSERT_EQ(shown.pixels[i], codes.pixels[i]);
  }
}

TEST_F(SequenceSessionTest, ACapturedPictureThatCannotBeIsItsOwnErrorAlone) {
  SequenceSession session = MakeSession();
  const UtcTime time = loaded_->sequence.frames.at(0).time;
  const CameraIntrinsics& camera = loaded_->sequence.intrinsics;
  const auto reason = [&](CapturedPicture captured) {
    captured.time = time;
    const SessionStep step = session.Process(std::move(captured));
    return step.result ? std::string("composited") : step.result.error().reason;
  };
  CapturedPicture small;
  small.picture = RgbImage(3, 2);
  EXPECT_THAT(reason(small), HasSubstr("found 3x2"));
  CapturedPicture empty;
  EXPECT_THAT(reason(empty), HasSubstr("found 0x0"));
  CapturedPicture dark;
  dark.picture = Rgb8Image(camera.width_px, camera.height_px);
  dark.exposure = -1.0;
  EXPECT_THAT(reason(dark), HasSubstr("expected an exposure above 0"));
  CapturedPicture broken;
  RgbImage not_finite(camera.width_px, camera.height_px);
  for (glm::vec3& pixel : not_finite.pixels) {
    pixel = glm::vec3(std::numeric_limits<float>::quiet_NaN());
  }
  broken.picture = not_finite;
  EXPECT_THAT(reason(broken), HasSubstr("expected finite radiances"));
  const auto next = session.Next();
  ASSERT_TRUE(next && next->result);
}

// The sun's part that is made ahead is the one that a frame without it makes itself: at the same
// times light and composites are the same bit for bit. A step of the raster is 48 s.
TEST_F(SequenceSessionTest, TheSunsPartMadeAheadGivesTheSameComposites) {
  SessionOptions options = CoarseOptions();
  options.pipeline.influence.rays_per_receiver = 16;
  options.pipeline.filter.reset();
  // The same light in each frame: an estimate also depends on the frames before.
  const TemporaryFolder folder;
  std::string lines;
  for (int frame = 0; frame < 10'000; ++frame) {
    lines += "{\"frame\": " + std::to_string(frame) +
             ", \"sun_irradiance_rgb\": [700, 650, 600], "
             "\"sky_irradiance_rgb\": [60, 90, 120]}\n";
  }
  options.lighting = folder.Write("light.jsonl", lines);
  SequenceSession at_once = MakeSession(options);
  options.pipeline.sun_ahead = true;
  SequenceSession ahead = MakeSession(options);
  CapturedPicture captured;
  captured.picture = MakeSession().Next()->frame->radiance;
  const UtcTime start = loaded_->sequence.frames.at(0).time;
  int frames_of_older_suns = 0;
  int steps = 0;
  double last_age_s = -24.0;
  // Ten seconds a frame, each shown until the sun of its own time is there.
  for (int i = 0; i < 15; ++i) {
    captured.time = start + std::chrono::seconds(10 * i);
    const SessionStep expected = at_once.Process(captured);
    ASSERT_TRUE(expected.result) << expected.result.error().reason;
    EXPECT_LE(std::abs(expected.result->sun_age_s), 24.0);
    SessionStep step = ahead.Process(captured);
    ASSERT_TRUE(step.result) << step.result.error().reason;
    while (step.result->sun_age_s != expected.result->sun_age_s) {
      // An older one's: its age says so.
      EXPECT_GT(step.result->sun_age_s, expected.result->sun_age_s);
      EXPECT_NEAR(
          std::remainder(step.result->sun_age_s - expected.result->sun_age_s, 48.0), 0.0, 1e-6);
      ++frames_of_older_suns;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      step = ahead.Process(captured);
      ASSERT_TRUE(step.result) << step.result.error().reason;
    }
    EXPECT_EQ(
        LargestDifference(step.result->composite.radiance, expected.result->composite.radiance),
        0.0f)
        << "frame " << i << ", after " << frames_of_older_suns << " of older suns";
    steps += expected.result->sun_age_s < last_age_s ? 1 : 0;
    last_age_s = expected.result->sun_age_s;
  }
  EXPECT_GE(steps, 2);
}

// Each draws in a context of its own.
TEST_F(SequenceSessionTest, TwoSessionsTakeTurnsOnOneThread) {
  auto first = std::make_unique<SequenceSession>(loaded_, CoarseOptions());
  const auto of_first = first->Next();
  SequenceSession second = MakeSession();
  const auto of_second = second.Next();
  ASSERT_TRUE(of_first && of_first->result && of_second && of_second->result);
  EXPECT_EQ(LargestDifference(of_first->result->composite.radiance,
                              of_second->result->composite.radiance),
            0.0f);
  const auto first_again = first->Next();
  ASSERT_TRUE(first_again && first_again->result);
  first.reset();
  const auto second_again = second.Next();
  ASSERT_TRUE(second_again && second_again->result);
  EXPECT_EQ(LargestDifference(first_again->result->composite.radiance,
                              second_again->result->composite.radiance),
            0.0f);
}

}  // namespace
}  // namespace pleinair::sequence_session_test
