// Cameras and objects that move as nothing should: whatever they did, a frame is finite, changes
// only what its mask says, and is the same as if nothing had come before it.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "calib/timed_pose.h"
#include "session/sequence_session.h"
#include "sunmodel/time_text.h"
#include "tests/calib/marker_scene.h"
#include "tests/scene/temporary_folder.h"
#include "tests/session/bundled_courtyard.h"

namespace pleinair::motion_hard_cases_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr int kMostFrames = 64;

SessionOptions CoarseOptions() {
  SessionOptions options = CoarseCourtyard();
  options.pipeline.object_light.gather.rays_per_receiver = 32;
  options.pipeline.influence.rays_per_receiver = 16;
  return options;
}

class MotionHardCases : public testing::Test {
 protected:
  static void SetUpTestSuite() { loaded = LoadSequence(CoarseOptions()); }
  static void TearDownTestSuite() { loaded.reset(); }

  MotionHardCases() : session_(loaded, UnderKnownLight()) {}

  // Light that is known, and nothing that is averaged over frames.
  SessionOptions UnderKnownLight() {
    SessionOptions options = CoarseOptions();
    options.pipeline.camera_matching.blur = false;
    std::string lines;
    for (int i = 0; i < kMostFrames; ++i) {
      lines += fmt::format(
          "{{\"frame\": {}, \"sun_irradiance_rgb\": [700, 650, 600], "
          "\"sky_irradiance_rgb\": [60, 90, 120], \"sky_shape\": {{\"uniform\": [1, 1, 1]}}}}\n",
          i);
    }
    options.lighting = folder_.Write("light.jsonl", lines);
    return options;
  }

  // The recording's camera with a quarter of its pixels a side.
  static Camera SmallCamera() {
    Camera camera = loaded->sequence.CameraOfFrame(0);
    CameraIntrinsics& small = camera.intrinsics;
    small.width_px /= 4;
    small.height_px /= 4;
    small.fx_px /= 4.0;
    small.fy_px /= 4.0;
    small.cx_px = 0.25 * (small.cx_px + 0.5) - 0.5;
    small.cy_px = 0.25 * (small.cy_px + 0.5) - 0.5;
    return camera;
  }
  static UtcTime StartTime() { return loaded->sequence.frames.front().time; }
  static glm::dvec3 ObjectM() {
    return glm::dvec3(loaded->sequence.virtual_objects[0].world_from_object[3]);
  }

  // A grey gradient: no pixel is like its neighbour.
  static CapturedPicture PictureAt(const Camera& camera, UtcTime time) {
    CapturedPicture captured;
    RgbImage picture(camera.intrinsics.width_px, camera.intrinsics.height_px);
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
      picture.pixels[i] = glm::vec3(20.0f + 0.001f * static_cast<float>(i));
    }
    captured.picture = std::move(picture);
    captured.camera = camera;
    captured.time = time;
    return captured;
  }

  // The composite's pixels, after a look at them; none where the frame says why it has none.
  std::vector<glm::vec3> CompositeOf(const glm::dmat4& camera_from_world, UtcTime time) {
    Camera camera = SmallCamera();
    camera.camera_from_world = camera_from_world;
    const CapturedPicture captured = PictureAt(camera, time);
    const auto& input = std::get<RgbImage>(captured.picture);
    SessionStep step = session_.Process(captured);
    if (!step.result) {
      EXPECT_FALSE(step.result.error().reason.empty());
      EXPECT_THAT(step.result.error().reason, testing::Not(HasSubstr("\n")));
      return {};
    }
    const Composite& composite = step.result->composite;
    std::size_t changed = 0;
    for (std::size_t i = 0; i < input.pixels.size(); ++i) {
      const glm::vec3& pixel = composite.radiance.pixels[i];
      EXPECT_TRUE(std::isfinite(pixel.x + pixel.y + pixel.z)) << "pixel " << i;
      EXPECT_GE(std::min({pixel.x, pixel.y, pixel.z}), 0.0f) << "pixel " << i;
      if (composite.change.pixels[i] == static_cast<std::uint8_t>(PixelChange::kNone)) {
        EXPECT_EQ(pixel, input.pixels[i]) << "pixel " << i;
      } else {
        ++changed;
      }
    }
    last_changed_ = changed;
    return std::move(step.result->composite.radiance.pixels);
  }
  std::vector<glm::vec3> CompositeAtStart() {
    std::vector<glm::vec3> pixels = CompositeOf(SmallCamera().camera_from_world, StartTime());
    EXPECT_FALSE(pixels.empty());
    return pixels;
  }

  static std::shared_ptr<const LoadedSequence> loaded;
  TemporaryFolder folder_;
  SequenceSession session_;
  std::size_t last_changed_ = 0;  // Pixels.
};
std::shared_ptr<const LoadedSequence> MotionHardCases::loaded;

// From the yard through the building behind it, 7 m high and 9 m deep, and out at its back; in
// places exactly on a wall.
TEST_F(MotionHardCases, CameraThroughAWall) {
  const std::vector<glm::vec3> before = CompositeAtStart();
  EXPECT_GT(last_changed_, 50u);
  const glm::dmat4 world_from_yard =
      glm::rotate(glm::dmat4(1.0), -18.0 * 3.14159265358979 / 180.0, glm::dvec3(0, 0, 1));
  const auto in_world = [&](double x, double y, double z) {
    return glm::dvec3(world_from_yard * glm::dvec4(x, y, z, 1.0));
  };
  int frame = 0;
  for (const double y : {6.0, 7.5, 7.99, 8.0, 8.01, 8.5, 12.0, 16.99, 17.0, 17.5, 20.0}) {
    // Looks ahead, then back at the object.
    for (const double ahead : {10.0, -10.0}) {
      SCOPED_TRACE(fmt::format("y {} looking {}", y, ahead));
      CompositeOf(LookAt(in_world(2.0, y, 1.6), in_world(2.0, y + ahead, 1.6)),
                  StartTime() + 33ms * ++frame);
    }
  }
  EXPECT_EQ(CompositeAtStart(), before);
}

// Also below the ground, and so far off that nothing is in view.
TEST_F(MotionHardCases, CameraWhereNoneCanBe) {
  const std::vector<glm::vec3> before = CompositeAtStart();
  for (const glm::dvec3& eye : {glm::dvec3(0.0, 0.0, -2.0),
                                glm::dvec3(0.0, 0.0, 0.0),
                                glm::dvec3(0.0, 0.0, 1e-6),
                                glm::dvec3(1e4, 1e4, 500.0),
                                glm::dvec3(1e7, 0.0, 2.0)}) {
    SCOPED_TRACE(fmt::format("({}, {}, {})", eye.x, eye.y, eye.z));
    CompositeOf(LookAt(eye, eye + glm::dvec3(1.0, 1.0, 0.0)), StartTime());
    CompositeOf(LookAt(eye, ObjectM() + glm::dvec3(0.0, 0.0, 1.0)), StartTime());
  }
  EXPECT_EQ(CompositeAtStart(), before);
}

// The camera walks through the object; nothing is left of it once it is behind.
TEST_F(MotionHardCases, CameraThroughTheObject) {
  const std::vector<glm::vec3> before = CompositeAtStart();
  const glm::dvec3 along = glm::normalize(glm::dvec3(0.6, 0.8, 0.0));
  const glm::dvec3 heart = ObjectM() + glm::dvec3(0.0, 0.0, 1.0);
  std::size_t most_changed = 0;
  for (const double away_m : {3.0, 1.0, 0.5, 0.3, 0.22, 0.2, 0.1, 0.01, 0.0, -0.1, -0.25, -1.0}) {
    SCOPED_TRACE(away_m);
    CompositeOf(LookAt(heart - away_m * along, heart + (1.0 - away_m) * along), StartTime());
    most_changed = std::max(most_changed, last_changed_);
  }
  EXPECT_GT(most_changed, 1000u);  // It was in view.
  EXPECT_EQ(CompositeAtStart(), before);
}

// The same with the object in motion: pushed through the camera that stands.
TEST_F(MotionHardCases, ObjectThroughTheCamera) {
  const std::vector<glm::vec3> before = CompositeAtStart();
  const std::vector<VirtualObjectEntry> there = loaded->sequence.virtual_objects;
  const glm::dmat4 world_from_camera = glm::inverse(SmallCamera().camera_from_world);
  for (const double depth_m : {4.0, 1.0, 0.3, 0.1, 0.0, -0.2, -1.0}) {
    SCOPED_TRACE(depth_m);
    std::vector<VirtualObjectEntry> moved = there;
    const glm::dvec3 place(world_from_camera * glm::dvec4(0.0, 0.0, depth_m, 1.0));
    moved[0].world_from_object[3] = glm::dvec4(place - glm::dvec3(0.0, 0.0, 1.2), 1.0);
    session_.SetObjects(moved);
    CompositeAtStart();
  }
  session_.SetObjects(there);
  EXPECT_EQ(CompositeAtStart(), before);
}

TEST_F(MotionHardCases, TeleportsLeaveNothingBehind) {
  const glm::dmat4 elsewhere = LookAt(ObjectM() + glm::dvec3(4.0, -4.0, 2.5), ObjectM());
  const std::vector<glm::vec3> here = CompositeAtStart();
  const std::vector<glm::vec3> there = CompositeOf(elsewhere, StartTime());
  EXPECT_NE(here, there);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(CompositeAtStart(), here) << i;
    EXPECT_EQ(CompositeOf(elsewhere, StartTime()), there) << i;
  }
}

// Frames of one time, of a time before, of an hour later and back: each has its own sun.
TEST_F(MotionHardCases, NoTimeBetweenFramesAndTimeThatGoesBack) {
  const glm::dmat4 pose = SmallCamera().camera_from_world;
  const std::vector<glm::vec3> now = CompositeAtStart();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(CompositeAtStart(), now);
  const std::vector<glm::vec3> later = CompositeOf(pose, StartTime() + 1h);
  EXPECT_NE(later, now);
  EXPECT_EQ(CompositeAtStart(), now);
  EXPECT_EQ(CompositeOf(pose, StartTime() + 1h), later);
  // A step that no clock shows, there and back.
  CompositeOf(pose, StartTime() + 1ns);
  CompositeOf(pose, StartTime() - 1ns);
  EXPECT_EQ(CompositeAtStart(), now);
}

TEST_F(MotionHardCases, AMirroredPoseIsRefusedInOneLine) {
  const std::vector<glm::vec3> before = CompositeAtStart();
  glm::dmat4 mirrored = SmallCamera().camera_from_world;
  for (int column = 0; column < 4; ++column) mirrored[column][0] = -mirrored[column][0];
  glm::dmat4 stretched = SmallCamera().camera_from_world;
  stretched[2] *= 1.01;
  glm::dmat4 not_finite = SmallCamera().camera_from_world;
  not_finite[3].x = std::nan("");
  for (const auto& [bad, reason] : {std::pair{mirrored, "a rotation, not a mirror image"},
                                    std::pair{stretched, "a rigid transform"},
                                    std::pair{not_finite, "a rigid transform"}}) {
    Camera camera = SmallCamera();
    camera.camera_from_world = bad;
    const SessionStep step = session_.Process(PictureAt(camera, StartTime()));
    ASSERT_FALSE(step.result);
    EXPECT_THAT(step.result.error().reason,
                HasSubstr(std::string("camera_from_world: expected ") + reason));
    EXPECT_THAT(step.result.error().reason, testing::Not(HasSubstr("\n")));
  }
  EXPECT_EQ(CompositeAtStart(), before);
}

// Poses from outside that are missing for some frames: these say so, the others are composited at
// their poses, which need not be in sequence.json.
TEST_F(MotionHardCases, FramesWithoutAPoseSaySo) {
  const Sequence& sequence = loaded->sequence;
  const glm::dmat4 own = sequence.CameraOfFrame(0).camera_from_world;
  const auto pose_of = [&](std::size_t frame) {
    return Changed(own, {{0.01 * static_cast<double>(frame), 0.0, 0.0}, {0.0, 0.001, 0.0}});
  };
  std::string lines;
  for (const std::size_t frame : {0u, 1u, 3u}) {
    const glm::dmat4 pose = pose_of(frame);
    nlohmann::json rows = nlohmann::json::array();
    for (int row = 0; row < 4; ++row) {
      rows.push_back({pose[0][row], pose[1][row], pose[2][row], pose[3][row]});
    }
    lines += nlohmann::json{{"time_utc", FormatUtcTime(sequence.frames[frame].time)},
                            {"camera_from_world", rows}}
                 .dump() +
             "\n";
  }
  SessionOptions options = CoarseOptions();
  options.poses = folder_.Write("poses.jsonl", lines);
  const auto with_poses = LoadSequence(options);
  EXPECT_EQ(with_poses->sequence.CameraOfFrame(2).camera_from_world, pose_of(0));
  std::vector<std::string> notes;
  const auto frames = FramesOf(options, *with_poses, notes);
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    const auto frame = frames->Next();
    ASSERT_TRUE(frame);
    if (i == 2 || i > 3) {
      ASSERT_FALSE(*frame) << i;
      EXPECT_THAT(frame->error().reason,
                  HasSubstr(i == 2 ? "camera pose is not known: there is no pose for"
                                   : "camera pose is not known: the last pose is"))
          << i;
    } else {
      ASSERT_TRUE(*frame) << i;
      EXPECT_EQ((*frame)->camera.camera_from_world, pose_of(i)) << i;
    }
  }
  options.markers = options.poses;
  EXPECT_THROW(LoadSequence(options), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::motion_hard_cases_test
