// Poses of another program while a camera streams: pipes, files that grow, shared memory.
#include "datasets/camera/pose_stream.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sunmodel/time_text.h"
#include "tests/calib/noisy_poses.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::pose_stream_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

glm::dmat4 Standing(double x) { return LookAt({x, -2.0, 1.0}, {x, 0.0, 0.5}); }

std::string LineOf(int frame, const glm::dmat4& pose) {
  nlohmann::json rows = nlohmann::json::array();
  for (int row = 0; row < 4; ++row) {
    rows.push_back({pose[0][row], pose[1][row], pose[2][row], pose[3][row]});
  }
  return nlohmann::json{{"time_utc", FormatUtcTime(FrameTime(frame))}, {"camera_from_world", rows}}
             .dump() +
         "\n";
}

// So long a wait that a test that needs it fails by its time.
PoseStreamOptions Patient() {
  PoseStreamOptions options;
  options.wait_s = 20.0;
  return options;
}

class Pipe {
 public:
  Pipe() {
    if (mkfifo(Path().c_str(), 0600) != 0) throw std::runtime_error("no pipe");
  }
  std::string Path() const { return (folder_ / "pipe").string(); }
  // As a tracker does that starts, writes and ends.
  void Write(const std::string& text) const {
    const int out = open(Path().c_str(), O_WRONLY | O_CLOEXEC);
    if (write(out, text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
      throw std::runtime_error("not written");
    }
    close(out);
  }

 private:
  TemporaryFolder folder_;
};

TEST(PoseStream, MatchesLatePosesToTheirFrames) {
  const Pipe pipe;
  EventLog events;
  PoseStream stream(pipe.Path(), Patient(), events);
  pipe.Write(LineOf(0, Standing(0.0)));
  // The frame's pose comes later than the frame, and between two.
  std::thread tracker([&] {
    std::this_thread::sleep_for(30ms);
    pipe.Write(LineOf(4, Standing(0.4)));
  });
  const auto between = stream.At(FrameTime(1));
  tracker.join();
  ASSERT_TRUE(between) << between.error();
  EXPECT_NEAR(CentreOfPose(between->camera_from_world).x, 0.1, 1e-6);
  EXPECT_EQ(between->held_s, 0.0);
  // One that comes out of order still counts.
  pipe.Write(LineOf(2, Standing(0.3)) + LineOf(5, Standing(0.5)));
  ASSERT_TRUE(stream.At(FrameTime(5)));
  EXPECT_EQ(stream.At(FrameTime(2))->camera_from_world, Standing(0.3));
  EXPECT_EQ(events.CountOf(EventKind::kPose), 0);
}

TEST(PoseStream, WaitsAsLongAsAsked) {
  const Pipe pipe;
  EventLog events;
  PoseStreamOptions options;
  options.wait_s = 0.05;
  PoseStream stream(pipe.Path(), options, events);
  EXPECT_EQ(stream.At(FrameTime(0)).error(), "there is no pose yet");
  pipe.Write(LineOf(0, Standing(0.0)));
  while (!stream.At(FrameTime(0))) {
  }
  const auto start = std::chrono::steady_clock::now();
  const auto held = stream.At(FrameTime(3));
  EXPECT_GE(std::chrono::steady_clock::now() - start, 50ms);
  ASSERT_TRUE(held);
  EXPECT_NEAR(held->held_s, 0.1, 1e-6);
  EXPECT_THAT(stream.At(FrameTime(30)).error(), HasSubstr("the last pose is 1.000 s older"));
}

TEST(PoseStream, PassesOverWhatIsNoPoseWithAnEvent) {
  const Pipe pipe;
  EventLog events;
  PoseStream stream(pipe.Path(), Patient(), events);
  glm::dmat4 mirrored = Standing(0.0);
  for (int c = 0; c < 4; ++c) mirrored[c][0] = -mirrored[c][0];
  // A line cut in two by the pipe's end is one line.
  const std::string good = LineOf(1, Standing(0.1));
  pipe.Write("\n" + LineOf(0, mirrored) + "nonsense\n" + good.substr(0, 20));
  pipe.Write(good.substr(20));
  const auto pose = stream.At(FrameTime(1));
  ASSERT_TRUE(pose) << pose.error();
  EXPECT_EQ(pose->camera_from_world, Standing(0.1));
  EXPECT_EQ(events.CountOf(EventKind::kPose), 2);
  const std::vector<Event> taken = events.TakeAll();
  ASSERT_EQ(taken.size(), 1u);  // Within a second.
  EXPECT_THAT(taken[0].text, HasSubstr(pipe.Path() + ":2: camera_from_world: expected a rotation"));
  EXPECT_THAT(taken[0].text, testing::Not(HasSubstr("\n")));
}

TEST(PoseStream, ALineWithoutEndIsBounded) {
  const Pipe pipe;
  EventLog events;
  PoseStream stream(pipe.Path(), Patient(), events);
  std::thread tracker([&] {
    for (int i = 0; i < 200; ++i) pipe.Write(std::string(1000, 'x'));
    pipe.Write("\n" + LineOf(0, Standing(0.0)));
  });
  EXPECT_TRUE(stream.At(FrameTime(0)));
  tracker.join();
  const std::vector<Event> taken = events.TakeAll();
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_THAT(taken[0].text, HasSubstr("found a line of 64 KiB or more"));
}

// A clock that is set back by an hour: what was before is no pose of now.
TEST(PoseStream, ForgetsWhatIsLaterWhenTimesGoBack) {
  const Pipe pipe;
  EventLog events;
  PoseStream stream(pipe.Path(), Patient(), events);
  pipe.Write(LineOf(108000, Standing(9.0)));
  ASSERT_TRUE(stream.At(FrameTime(108000)));
  pipe.Write(LineOf(0, Standing(0.0)));
  // Frames no longer wait for nothing, and none has the pose of an hour later.
  while (stream.At(FrameTime(108000))) {
    std::this_thread::sleep_for(1ms);
    if (!stream.At(FrameTime(0))) continue;
    break;
  }
  EXPECT_EQ(stream.At(FrameTime(0))->camera_from_world, Standing(0.0));
  const std::vector<Event> taken = events.TakeAll();
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_THAT(taken[0].text, HasSubstr("the poses' times went back"));
}

TEST(PoseStream, FollowsAFileThatGrows) {
  const TemporaryFolder folder;
  const auto file = folder / "poses.jsonl";
  std::ofstream(file) << LineOf(0, Standing(0.0));
  EventLog events;
  PoseStream stream(file.string(), Patient(), events);
  EXPECT_TRUE(stream.At(FrameTime(0)));
  std::ofstream(file, std::ios::app) << LineOf(3, Standing(0.3));
  EXPECT_EQ(stream.At(FrameTime(3))->camera_from_world, Standing(0.3));
}

TEST(PoseStream, StopsWaiting) {
  const Pipe pipe;
  EventLog events;
  PoseStream stream(pipe.Path(), Patient(), events);
  std::thread stopper([&] {
    std::this_thread::sleep_for(20ms);
    stream.Stop();
  });
  EXPECT_FALSE(stream.At(FrameTime(0)));
  stopper.join();
}

// A tracker's side of a slot, as docs/live.md describes it.
class Tracker {
 public:
  explicit Tracker(std::size_t bytes = sizeof(PoseSlot), const char* magic = "plnrpose")
      : name_(fmt::format("pleinair-test-{}", getpid())) {
    const int descriptor = shm_open(("/" + name_).c_str(), O_RDWR | O_CREAT | O_TRUNC, 0600);
    if (descriptor < 0 || ftruncate(descriptor, static_cast<off_t>(bytes)) != 0) {
      throw std::runtime_error("no shared memory");
    }
    words_ = static_cast<std::uint64_t*>(
        mmap(nullptr, sizeof(PoseSlot), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0));
    close(descriptor);
    if (bytes < sizeof(PoseSlot)) return;
    std::memcpy(words_, magic, 8);
    words_[1] = 1;
  }
  ~Tracker() {
    munmap(words_, sizeof(PoseSlot));
    shm_unlink(("/" + name_).c_str());
  }
  Tracker(const Tracker&) = delete;
  Tracker& operator=(const Tracker&) = delete;

  std::string Source() const { return "shm:" + name_; }
  void Begin() { Step(); }
  void End() { Step(); }
  void Put(int frame, const glm::dmat4& pose) {
    Store(3, static_cast<std::uint64_t>(FrameTime(frame).time_since_epoch().count()));
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column) {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &pose[column][row], sizeof bits);
        Store(4 + 4 * static_cast<std::size_t>(row) + static_cast<std::size_t>(column), bits);
      }
    }
  }
  void Write(int frame, const glm::dmat4& pose) {
    Begin();
    Put(frame, pose);
    End();
  }

 private:
  void Store(std::size_t word, std::uint64_t bits) {
    std::atomic_ref(words_[word]).store(bits, std::memory_order_relaxed);
  }
  void Step() { std::atomic_ref(words_[2]).fetch_add(1, std::memory_order_seq_cst); }

  std::string name_;
  std::uint64_t* words_ = nullptr;
};

TEST(PoseStream, ReadsASlotInSharedMemory) {
  Tracker tracker;
  EventLog events;
  PoseStream stream(tracker.Source(), Patient(), events);
  for (int i = 0; i < 20; ++i) {
    tracker.Write(i, Standing(0.1 * i));
    const auto pose = stream.At(FrameTime(i));
    ASSERT_TRUE(pose) << pose.error();
    EXPECT_EQ(pose->camera_from_world, Standing(0.1 * i));
  }
  // A pose that is being written is not read.
  tracker.Begin();
  tracker.Put(25, Standing(5.0));
  std::this_thread::sleep_for(20ms);
  tracker.Put(20, Standing(2.0));
  tracker.End();
  ASSERT_TRUE(stream.At(FrameTime(20)));
  EXPECT_EQ(stream.At(FrameTime(20))->camera_from_world, Standing(2.0));
  EXPECT_EQ(events.CountOf(EventKind::kPose), 0);
  // One that is none.
  tracker.Write(21, glm::dmat4(0.0));
  while (events.CountOf(EventKind::kPose) == 0) std::this_thread::sleep_for(1ms);
  EXPECT_THAT(events.TakeAll()[0].text, HasSubstr("expected a rigid transform"));
}

TEST(PoseStream, RefusesSourcesThatAreNone) {
  EventLog events;
  const auto refusal = [&](const std::string& source) {
    try {
      const PoseStream stream(source, {}, events);
      return std::string("accepted");
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
  };
  EXPECT_THAT(refusal("/nowhere/pipe"), HasSubstr("/nowhere/pipe: expected a pipe or file"));
  EXPECT_THAT(refusal("shm:pleinair-none"), HasSubstr("shm:pleinair-none: expected shared memory"));
  {
    const Tracker small(100);
    EXPECT_THAT(refusal(small.Source()), HasSubstr("shared memory of 160 bytes or more"));
  }
  const Tracker other(sizeof(PoseSlot), "somebody");
  EXPECT_THAT(refusal(other.Source()), HasSubstr("begins with plnrpose"));
  PoseStreamOptions options;
  options.wait_s = -1.0;
  EXPECT_THROW(PoseStream("-", options, events), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::pose_stream_test
