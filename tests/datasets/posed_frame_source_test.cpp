#include "datasets/posed_frame_source.h"

#include <chrono>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/json_cursor.h"
#include "datasets/pose_lines.h"
#include "tests/calib/noisy_poses.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::posed_frame_source_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

// As many frames as there are times; a frame at time -1 s is an error of the source.
class Frames final : public FrameSource {
 public:
  explicit Frames(std::vector<UtcTime> times) : times_(std::move(times)) {}
  std::optional<tl::expected<Frame, FrameError>> Next() override {
    if (next_ == static_cast<int>(times_.size())) return std::nullopt;
    const int index = next_++;
    const UtcTime time = times_[static_cast<std::size_t>(index)];
    if (time == kBroken) return tl::unexpected(FrameError{index, time, "broken"});
    Frame frame;
    frame.index = index;
    frame.time = time;
    frame.camera.intrinsics = TrackedCamera();
    return frame;
  }
  std::optional<int> Count() const override { return static_cast<int>(times_.size()); }
  bool Seek(int index) override {
    next_ = index;
    return true;
  }

  static constexpr UtcTime kBroken = UtcTime(-1s);

 private:
  std::vector<UtcTime> times_;
  int next_ = 0;
};

glm::dmat4 Standing(double x) { return LookAt({x, -2.0, 1.0}, {x, 0.0, 0.5}); }

std::string LineOf(const std::string& time, const glm::dmat4& pose) {
  nlohmann::json rows = nlohmann::json::array();
  for (int row = 0; row < 4; ++row) {
    rows.push_back({pose[0][row], pose[1][row], pose[2][row], pose[3][row]});
  }
  return nlohmann::json{{"time_utc", time}, {"camera_from_world", rows}}.dump();
}

TEST(PosedFrames, HaveThePoseOfTheirTime) {
  PoseTrack track;
  for (int i = 0; i <= 10; ++i) track.Add({FrameTime(i, 10.0), Standing(0.1 * i)});
  std::vector<std::pair<int, double>> held;
  const auto frames = MakePosedFrameSource(
      std::make_unique<Frames>(std::vector{FrameTime(1, 20.0),
                                           Frames::kBroken,
                                           FrameTime(20, 20.0),
                                           FrameTime(22, 20.0),
                                           FrameTime(60, 20.0)}),
      [&](UtcTime time) { return track.At(time); },
      [&](const Frame& frame, double held_s) { held.emplace_back(frame.index, held_s); });
  EXPECT_EQ(frames->Count(), 5);
  EXPECT_NEAR(CentreOfPose((*frames->Next())->camera.camera_from_world).x, 0.05, 1e-9);
  EXPECT_EQ((*frames->Next()).error().reason, "broken");
  EXPECT_EQ((*frames->Next())->camera.camera_from_world, Standing(1.0));
  EXPECT_EQ((*frames->Next())->camera.camera_from_world, Standing(1.0));
  const auto lost = frames->Next();
  ASSERT_FALSE(*lost);
  EXPECT_EQ(lost->error().index, 4);
  EXPECT_EQ(lost->error().reason,
            "camera pose is not known: the last pose is 2.000 s older than the frame, expected at "
            "most 0.200 s");
  EXPECT_FALSE(frames->Next());
  ASSERT_EQ(held.size(), 1u);
  EXPECT_EQ(held[0].first, 3);
  EXPECT_NEAR(held[0].second, 0.1, 1e-9);
  EXPECT_TRUE(frames->Seek(2));
  EXPECT_EQ((*frames->Next())->index, 2);
}

TEST(SteadyFrames, StandStillAndBeginAgainWhereTheyAreSought) {
  std::vector<UtcTime> times;
  times.reserve(120);
  for (int i = 0; i < 120; ++i) times.push_back(FrameTime(i));
  NoisyPoses noisy(0.5, 3);
  std::vector<glm::dmat4> raw;
  const glm::dmat4 truth = Standing(0.0);
  auto posed = MakePosedFrameSource(std::make_unique<Frames>(times),
                                    [&](UtcTime) -> tl::expected<TrackPose, std::string> {
                                      raw.push_back(noisy.Of(truth));
                                      return TrackPose{raw.back(), 0.0};
                                    });
  const auto steady = MakeSteadyFrameSource(std::move(posed));
  double raw_sum = 0.0;
  double sum = 0.0;
  for (int i = 0; i < 120; ++i) {
    const glm::dmat4 pose = (*steady->Next())->camera.camera_from_world;
    if (i < 60) continue;
    const glm::dvec2 wobble = WobblePx(truth, pose);
    const glm::dvec2 raw_wobble = WobblePx(truth, raw.back());
    sum += glm::dot(wobble, wobble);
    raw_sum += glm::dot(raw_wobble, raw_wobble);
  }
  // 60 to 91 poses are averaged: an eighth of the noise, and what a sample of 60 leaves open.
  EXPECT_LT(std::sqrt(sum / raw_sum), 0.25);
  EXPECT_FALSE(steady->Next());
  EXPECT_TRUE(steady->Seek(40));
  const glm::dmat4 sought = (*steady->Next())->camera.camera_from_world;
  EXPECT_EQ(sought, raw.back());
}

TEST(PoseLines, AreReadToTheEndOfTheFile) {
  const TemporaryFolder folder;
  const auto file = folder / "poses.jsonl";
  std::ofstream(file) << LineOf("2026-06-21T00:00:00.100Z", Standing(0.1)) << "\n\n"
                      << LineOf("2026-06-21T00:00:00Z", Standing(0.0)) << "\r\n"
                      << LineOf("2026-06-21T00:00:00.2Z", Standing(0.2));  // Without its end.
  const PoseTrack track = ReadPoses(file);
  EXPECT_EQ(track.At(FrameTime(0))->camera_from_world, Standing(0.0));
  EXPECT_EQ(track.At(FrameTime(2, 10.0))->camera_from_world, Standing(0.2));
}

TEST(PoseLines, RefusalsSayWhereAndWhatWasExpected) {
  const TemporaryFolder folder;
  const auto file = folder / "poses.jsonl";
  const std::string good = LineOf("2026-06-21T00:00:00Z", Standing(0.0));
  glm::dmat4 mirrored = Standing(0.0);
  for (int c = 0; c < 4; ++c) mirrored[c][0] = -mirrored[c][0];
  glm::dmat4 torn = Standing(0.0);
  torn[1] *= 1.1;
  const std::pair<std::string, std::string> cases[] = {
      {LineOf("2026-06-21T00:00:00Z", mirrored), "a rotation, not a mirror image"},
      {LineOf("2026-06-21T00:00:00Z", torn), "a rigid transform"},
      {LineOf("yesterday", Standing(0.0)), "time_utc: expected a UTC time"},
      {R"({"time_utc": "2026-06-21T00:00:00Z"})", "camera_from_world: expected"},
      {R"({"time": 3})", "found \"time\""},
      {"[1, 2]", "expected an object"},
      {"pose", "poses.jsonl:2: "},
      {std::string(1000, '['), "poses.jsonl:2: "}};
  for (const auto& [line, reason] : cases) {
    std::ofstream(file) << good << "\n" << line << "\n" << good << "\n";
    try {
      ReadPoses(file);
      FAIL() << "accepted: " << line;
    } catch (const JsonError& error) {
      EXPECT_THAT(error.what(), HasSubstr("poses.jsonl:2: "));
      EXPECT_THAT(error.what(), HasSubstr(reason));
      EXPECT_THAT(error.what(), testing::Not(HasSubstr("\n")));
    }
  }
  std::ofstream(file) << "\n";
  EXPECT_THROW(ReadPoses(file), JsonError);
  EXPECT_THROW(ReadPoses(folder / "none"), JsonError);
  EXPECT_THROW(ReadPoses("/tmp"), JsonError);
}

}  // namespace
}  // namespace pleinair::posed_frame_source_test
