// The stand-in as a stranger's program sees it: its lists, calls, times, controls and command line.
#include <linux/videodev2.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "datasets/sequence.h"
#include "tests/camera_stand_in/stand_in_client.h"

namespace pleinair::camera_stand_in_test {
namespace {

using Json = nlohmann::json;

TEST(CameraStandIn, ListsFormatsSizesRatesAndControls) {
  const ClientRun list = StandIn("--rate 24", "list /dev/video90");
  ASSERT_EQ(list.exit_code, 0) << list.output;
  EXPECT_EQ(list.Lines()[0]["card"], "pleinair stand-in");
  EXPECT_EQ(list.Lines()[0]["bus"], "stand-in:90");
  std::string formats;
  for (const Json& line : list.With("format")) {
    formats += line["format"].get<std::string>() + " ";
    const Json& sizes = line["sizes"];
    ASSERT_GE(sizes.size(), 4u) << line;
    EXPECT_EQ(sizes[0], Json::array({480, 360, {24, 5, 10, 15, 20, 25, 30, 50, 60}}));
    for (const int width : {320, 640, 1280}) {
      EXPECT_TRUE(std::any_of(sizes.begin(), sizes.end(), [&](const Json& size) {
        return size[0] == width && size[1] == width * 3 / 4;
      })) << line;
    }
  }
  EXPECT_EQ(formats, "YUYV NV12 MJPG GREY RGB3 RGGB RG10 pRAA RG12 pRCC ");
  EXPECT_EQ(list.With("control").size(), 8u);
  for (const Json& control : list.With("value")) EXPECT_EQ(control["value"], control["normal"]);
  EXPECT_EQ(list.With("value").size(), 6u);  // All but the two headings.
}

TEST(CameraStandIn, AnswersCallsOutOfTurnAsDriversDo) {
  const ClientRun rules = StandIn("--loop 0", "rules /dev/video90");
  ASSERT_EQ(rules.exit_code, 0) << rules.output;
  const Json expected{{"poll_idle", POLLERR},
                      {"stream_without_buffers", EINVAL},
                      {"unknown", ENOTTY},
                      {"format", true},
                      {"buffers", 0},
                      {"second_buffers", EBUSY},
                      {"second_format", false},
                      {"streamon", 0},
                      {"poll_empty", 0},
                      {"dequeue_empty", EAGAIN},
                      {"queue", 0},
                      {"queue_twice", EINVAL},
                      {"poll_filled", POLLIN},
                      {"free_streaming", EBUSY},
                      {"streamoff", 0},
                      {"free", 0},
                      {"second_then", 0},
                      {"first_then", 0}};
  EXPECT_EQ(rules.Lines()[0], expected);
}

TEST(CameraStandIn, CountsAndTimesEveryTickAndEnds) {
  const ClientRun run = StandIn("--rate 25 --loop 3", "stream /dev/video90 format=YUYV");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const std::vector<Json> frames = run.Frames();
  ASSERT_GE(frames.size(), 2u);
  const auto first_ns = frames[0]["time_ns"].get<std::int64_t>();
  for (const Json& frame : frames) {
    const auto time_ns = frame["time_ns"].get<std::int64_t>();
    const auto sequence = frame["sequence"].get<std::int64_t>();
    EXPECT_LE(std::abs(time_ns - first_ns - sequence * kSecondNs / 25), kMicrosecondNs);
    EXPECT_TRUE(frame["flags"].get<unsigned>() & V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC);
    EXPECT_EQ((frame["flags"].get<unsigned>() & V4L2_BUF_FLAG_LAST) != 0, sequence == 17);
  }
  EXPECT_EQ(frames[0]["sequence"], 0);
  EXPECT_EQ(frames.back()["sequence"], 3 * kPictures - 1);
  EXPECT_EQ(run.Lines().back()["error"], EPIPE);
}

TEST(CameraStandIn, StartsAtTheRecordingsTime) {
  const ClientRun run = StandIn("--rate 25 --loop 3 --pictures 2:4", "stream /dev/video90");
  const auto expected = ReadSequence(kCourtyard).frames[2].time.time_since_epoch().count();
  const std::vector<Json> frames = run.Frames();
  ASSERT_FALSE(frames.empty());
  const auto first_ns = frames[0]["time_ns"].get<std::int64_t>();
  for (const Json& frame : frames) {
    EXPECT_LE(std::abs(first_ns + frame["offset_ns"].get<std::int64_t>() - expected),
              kClockReadingNs);
  }
}

TEST(CameraStandIn, DropsPicturesThatFindNoBufferAndCountsThem) {
  const ClientRun run = StandIn("--rate 30 --loop 6", "stream /dev/video90 hold_at=5");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const std::vector<Json> frames = run.Frames();
  // Half a second is 15 pictures; the client held one buffer, and three could be filled.
  EXPECT_LE(frames.size(), 36u - 11u);
  EXPECT_EQ(frames.back()["sequence"], 35);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const auto ticks = frames[i]["sequence"].get<int>() - frames[i - 1]["sequence"].get<int>();
    const auto time =
        frames[i]["time_ns"].get<std::int64_t>() - frames[i - 1]["time_ns"].get<std::int64_t>();
    EXPECT_LE(std::abs(time - ticks * kSecondNs / 30), kMicrosecondNs);
  }
}

TEST(CameraStandIn, ControlsReachTheFrameThatIsDue) {
  for (const int delay : {1, 4}) {
    const ClientRun run = StandIn("--rate 20 --loop 0 --pictures 0:0 --control-delay " +
                                      std::to_string(delay) + " --fault unplug@1.5",
                                  "stream /dev/video90 format=RG12 set_at=3 exposure=50");
    const std::vector<Json> writes = run.With("set");
    ASSERT_EQ(writes.size(), 1u) << run.output;
    EXPECT_EQ(writes[0]["set"], 0);
    EXPECT_EQ(writes[0]["value"], 50);
    const std::vector<Json> frames = run.Frames();
    const double before = frames[0]["mean"];
    const auto changed = std::find_if(frames.begin(), frames.end(), [&](const Json& frame) {
      return frame["mean"].get<double>() != before;
    });
    ASSERT_NE(changed, frames.end());
    // The last frame that had been captured when the control was written.
    const std::int64_t interval = kSecondNs / 20;
    const std::int64_t last = (*changed)["time_ns"].get<std::int64_t>() - delay * interval;
    const auto missing =
        (*changed)["sequence"].get<int>() - (*(changed - 1))["sequence"].get<int>() - 1;
    EXPECT_LE(last - missing * interval, writes[0]["after_ns"].get<std::int64_t>());
    EXPECT_GE(last + interval + kMicrosecondNs, writes[0]["before_ns"].get<std::int64_t>());
    for (auto frame = changed; frame != frames.end(); ++frame) {
      EXPECT_EQ((*frame)["mean"], (*changed)["mean"]);
    }
  }
}

TEST(CameraStandIn, WorksInChildrenOfTheCommand) {
  const ClientRun run =
      Program(kCourtyard.string() +
              " --number 7 -- bash -c 'test -c /dev/video7 && test -r /dev/video7 && " +
              PLEINAIR_CAMERA_CLIENT + " list /dev/video7 >/dev/null && " + "date -u +%Y-%m-%d'");
  EXPECT_EQ(run.output, "2005-06-21\n");
  EXPECT_EQ(run.exit_code, 0);
}

TEST(CameraStandIn, OpenCvReadsIt) {
  const ClientRun run = StandIn("--rate 20 --loop 4", "opencv /dev/video90");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_EQ(run.Lines().back()["opened"], true);
  EXPECT_GE(run.Lines().back()["count"].get<int>(), 2);
}

TEST(CameraStandIn, PassesExitCodesAndSignalsOn) {
  const std::string start = kCourtyard.string() + " -- ";
  EXPECT_EQ(Program(start + "sh -c 'exit 7'").exit_code, 7);
  EXPECT_EQ(Program(start + "sh -c 'kill -TERM $PPID; exec sleep 60'").exit_code, 128 + SIGTERM);
  EXPECT_EQ(Program(start + "/no/such/command 2>/dev/null").exit_code, 127);
}

TEST(CameraStandIn, RefusesWrongInputInOneLine) {
  const std::string yard = kCourtyard.string();
  EXPECT_EQ(Program("/no/such/folder -- true 2>&1").exit_code, 2);
  for (const char* options : {"",
                              " --rate 0 -- true",
                              " --rate nan -- true",
                              " --pictures 2:9 -- true",
                              " --pictures 3:1 -- true",
                              " --pictures x -- true",
                              " --size 640 -- true",
                              " --size 99999x99999 -- true",
                              " --format RGB -- true",
                              " --number 256 -- true",
                              " --fault unplug -- true",
                              " --fault melt@1 -- true",
                              " --fault unplug@-1 -- true",
                              " --fault unplug@-1p -- true",
                              " --fault unplug@1.5p -- true",
                              " --fault unplug@p -- true",
                              " --fault unplug@1p,stall@2 -- true",
                              " --fault random:1@5 -- true"}) {
    const ClientRun run = Program(yard + options + " 2>&1");
    EXPECT_EQ(run.exit_code, 2) << options;
    EXPECT_EQ(std::count(run.output.begin(), run.output.end(), '\n'), 1) << run.output;
    EXPECT_EQ(run.output.find("pleinair-camera-stand-in: "), 0u) << run.output;
  }
}

}  // namespace
}  // namespace pleinair::camera_stand_in_test
