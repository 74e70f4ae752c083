// What the stand-in does on demand: each fault as a program sees it.
#include <linux/videodev2.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/camera_stand_in/stand_in_client.h"

namespace pleinair::stand_in_faults_test {
namespace {

using Json = nlohmann::json;

std::string Faulty(const std::string& faults) { return "--rate 20 --loop 6 --fault " + faults; }

TEST(CameraStandIn, UnplugsAndComesBack) {
  for (const bool renumbered : {false, true}) {
    const ClientRun run = StandIn(Faulty(renumbered ? "unplug-renumber@0.5" : "unplug@0.5"),
                                  "stream /dev/video90 recover=1");
    ASSERT_EQ(run.exit_code, 0) << run.output;
    const std::vector<Json> errors = run.With("error");
    ASSERT_EQ(errors.size(), 2u);
    EXPECT_EQ(errors[0]["error"], ENODEV);
    EXPECT_TRUE(errors[0]["poll"].get<int>() & POLLERR);
    EXPECT_TRUE(errors[0]["poll"].get<int>() & POLLHUP);
    const std::vector<Json> starts = run.With("device");
    ASSERT_EQ(starts.size(), 2u);
    EXPECT_EQ(starts[1]["device"], renumbered ? "/dev/video91" : "/dev/video90");
    const std::vector<Json> frames = run.Frames();
    const auto again = std::find_if(
        frames.begin() + 1, frames.end(), [](const Json& frame) { return frame["sequence"] == 0; });
    ASSERT_NE(again, frames.end());
    EXPECT_GE(
        (*again)["time_ns"].get<std::int64_t>() - (*(again - 1))["time_ns"].get<std::int64_t>(),
        kSecondNs);
    EXPECT_LE((*(again - 1))["sequence"].get<int>(), 9);  // Stream time 0.45 s.
    // It goes on with the next picture: 10 were played before.
    EXPECT_EQ(frames.back()["sequence"], 6 * kPictures - 10 - 1);
  }
}

// However slowly they are taken: half a second passes after the second picture.
TEST(CameraStandIn, CountsThePicturesBeforeAFault) {
  const ClientRun run =
      StandIn("--rate 20 --loop 0 --fault unplug@5p", "stream /dev/video90 hold_at=1");
  const std::vector<Json> errors = run.With("error");
  ASSERT_EQ(errors.size(), 1u) << run.output;
  EXPECT_EQ(errors[0]["error"], ENODEV);
  EXPECT_GE(run.Frames().size(), 5u);
  // Pictures in the client's four buffers can be taken before the next tick unplugs.
  EXPECT_LE(run.Frames().size(), 5u + 4u);
}

TEST(CameraStandIn, Stalls) {
  const ClientRun run = StandIn(Faulty("stall@0.5"), "stream /dev/video90");
  const std::vector<Json> frames = run.Frames();
  const auto after =
      std::adjacent_find(frames.begin(), frames.end(), [](const Json& a, const Json& b) {
        return b["time_ns"].get<std::int64_t>() - a["time_ns"].get<std::int64_t>() >= 3 * kSecondNs;
      });
  ASSERT_NE(after, frames.end()) << run.output;
  EXPECT_LE((*after)["sequence"].get<int>(), 9);
  EXPECT_EQ(frames.back()["sequence"], 6 * kPictures - 1);  // No picture was lost by it.
  EXPECT_EQ(run.exit_code, 0);
}

TEST(CameraStandIn, StallsForever) {
  const ClientRun run =
      Program(kCourtyard.string() + " " + Faulty("stall-forever@0.2 -- timeout 3 ") +
              PLEINAIR_CAMERA_CLIENT + " stream /dev/video90");
  EXPECT_EQ(run.exit_code, 124);  // timeout's.
  ASSERT_FALSE(run.Frames().empty());
  EXPECT_LE(run.Frames().back()["sequence"].get<int>(), 3);
}

TEST(CameraStandIn, ChangesItsSizeAndBack) {
  const ClientRun run =
      StandIn(Faulty("format-change@0.5,format-change@1"), "stream /dev/video90 recover=1");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const std::vector<Json> errors = run.With("error");
  ASSERT_EQ(errors.size(), 3u);
  const std::vector<Json> events = run.With("event");
  ASSERT_EQ(events.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(errors[i]["error"], EIO);
    EXPECT_EQ(errors[i]["poll"].get<int>() & (POLLERR | POLLPRI), POLLERR | POLLPRI);
    EXPECT_EQ(events[i]["event"], V4L2_EVENT_SOURCE_CHANGE);
  }
  const std::vector<Json> starts = run.With("width");
  ASSERT_EQ(starts.size(), 3u);
  EXPECT_NE(starts[1]["width"], kWidth);
  EXPECT_EQ(starts[1]["width"], run.With("new_width")[0]["new_width"]);
  EXPECT_EQ(starts[2]["width"], kWidth);
}

TEST(CameraStandIn, TruncatesABuffer) {
  const ClientRun run = StandIn(Faulty("truncate@0.5"), "stream /dev/video90");
  int short_ones = 0;
  for (const Json& frame : run.Frames()) {
    const int bytes = frame["bytes"];
    EXPECT_TRUE(bytes == kWidth * kHeight * 3 || bytes == kWidth * kHeight * 3 / 2) << bytes;
    short_ones += bytes < kWidth * kHeight * 3 ? 1 : 0;
  }
  EXPECT_EQ(short_ones, 1);
}

int CountFlagged(const ClientRun& run) {
  const std::vector<Json> frames = run.Frames();
  return static_cast<int>(std::count_if(frames.begin(), frames.end(), [](const Json& frame) {
    return (frame["flags"].get<unsigned>() & V4L2_BUF_FLAG_ERROR) != 0;
  }));
}

TEST(CameraStandIn, CorruptsBuffers) {
  EXPECT_EQ(CountFlagged(StandIn(Faulty("corrupt@0.4,corrupt@0.8"), "stream /dev/video90")), 2);
  // Every other damaged JPEG is one that the driver has not noticed.
  const ClientRun run =
      StandIn("--rate 20 --loop 30 --pictures 3:3 --fault corrupt@0.4,corrupt@0.8",
              "stream /dev/video90 format=MJPG");
  EXPECT_EQ(CountFlagged(run), 1);
  const std::vector<Json> frames = run.Frames();
  EXPECT_EQ(std::count_if(frames.begin(),
                          frames.end(),
                          [&](const Json& frame) { return frame["mean"] != frames[0]["mean"]; }),
            1);
}

TEST(CameraStandIn, RepeatsAndTurnsBackTimestamps) {
  const auto steps = [](const ClientRun& run, auto&& is_one) {
    const std::vector<Json> frames = run.Frames();
    int count = 0;
    for (std::size_t i = 1; i < frames.size(); ++i) {
      const std::int64_t step =
          frames[i]["time_ns"].get<std::int64_t>() - frames[i - 1]["time_ns"].get<std::int64_t>();
      count += is_one(step) ? 1 : 0;
    }
    return count;
  };
  const ClientRun repeat = StandIn(Faulty("time-repeat@0.5"), "stream /dev/video90");
  EXPECT_EQ(steps(repeat, [](std::int64_t step) { return step == 0; }), 1) << repeat.output;
  const ClientRun back = StandIn(Faulty("time-back@0.5"), "stream /dev/video90");
  EXPECT_EQ(steps(back, [](std::int64_t step) { return step < 0; }), 1) << back.output;
}

TEST(CameraStandIn, StepsTheWallClock) {
  for (const int direction : {-1, 1}) {
    const ClientRun run = StandIn(Faulty(direction < 0 ? "clock-back@0.5" : "clock-forward@0.5"),
                                  "stream /dev/video90");
    const std::vector<Json> frames = run.Frames();
    ASSERT_GE(frames.size(), 2u);
    const std::int64_t step = frames.back()["offset_ns"].get<std::int64_t>() -
                              frames.front()["offset_ns"].get<std::int64_t>();
    EXPECT_LE(std::abs(step - direction * 3600 * kSecondNs), 2 * kClockReadingNs);
  }
}

TEST(CameraStandIn, LosesSequenceNumbers) {
  const ClientRun run = StandIn(Faulty("drop@0.5"), "stream /dev/video90");
  const std::vector<Json> frames = run.Frames();
  const auto jump =
      std::adjacent_find(frames.begin(), frames.end(), [](const Json& a, const Json& b) {
        return b["sequence"].get<int>() - a["sequence"].get<int>() > 5;
      });
  ASSERT_NE(jump, frames.end());
  EXPECT_LE((*jump)["sequence"].get<int>(), 9);
  EXPECT_GE((*(jump + 1))["sequence"].get<int>(), 15);
}

TEST(CameraStandIn, RefusesAndClampsControls) {
  const std::string client = "stream /dev/video90 set_at=0 exposure=400";
  const Json refused = StandIn(Faulty("control-refused@0"), client).With("set")[0];
  EXPECT_EQ(refused["set"], EBUSY);
  EXPECT_EQ(refused["value"], 100);
  const Json clamped = StandIn(Faulty("control-clamped@0"), client).With("set")[0];
  EXPECT_EQ(clamped["set"], 0);
  EXPECT_EQ(clamped["value"], 110);
}

TEST(CameraStandIn, RepeatsItsRandomFaults) {
  // Both the faults and the end count pictures that the client has had: a busy machine's client
  // loses pictures, so a recording might end before the last fault.
  const auto ends = [&] {
    const ClientRun run = StandIn("--rate 60 --loop 0 --fault random:7:6@48p",
                                  "stream /dev/video90 recover=1 pictures=80");
    EXPECT_EQ(run.exit_code, 0) << run.output;
    std::string errors;
    for (const Json& line : run.With("error")) errors += line["error"].dump() + " ";
    return errors;
  };
  const std::string first = ends();
  EXPECT_NE(first, "");  // Something ended the stream in between.
  EXPECT_EQ(ends(), first);
}

}  // namespace
}  // namespace pleinair::stand_in_faults_test
