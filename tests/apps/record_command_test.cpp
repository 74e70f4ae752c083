// Recordings of a camera that is a recording itself.

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "datasets/frame_source.h"
#include "datasets/sequence.h"
#include "tests/scene/running_command.h"
#include "tests/scene/shell.h"
#include "tests/scene/temporary_folder.h"
#include "tests/session/command_folder.h"

namespace pleinair::record_command_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const fs::path kSample = fs::path(PLEINAIR_SOURCE_DIR) / "datasets/samples/courtyard";

class RecordCommand : public CommandFolder {
 protected:
  void SetUp() override {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "sanitizers do not load behind the stand-in";
#endif
    CommandFolder::SetUp();
  }

  static std::string Command(const std::string& camera, const std::string& arguments) {
    return std::string(PLEINAIR_STAND_IN) + " " + camera + " -- " + PLEINAIR_PROGRAM + " record " +
           arguments;
  }
  // `record` at the sample's site, `camera` being its camera.
  static Ended Record(const std::string& camera, const std::string& arguments) {
    // Where a refusal is expected and does not come, the recording would have no end. Others take
    // as long as the machine is busy.
    return Shell("timeout 300 " + Command(camera, arguments));
  }
  std::string Path(const char* name) const { return (folder_ / name).string(); }

  static std::vector<Frame> FramesOf(const fs::path& sequence) {
    const auto source = MakeRecordedFrameSource(ReadSequence(sequence), FrameKind::kLdr);
    std::vector<Frame> frames;
    while (auto frame = source->Next()) {
      EXPECT_TRUE(*frame) << frame->error().reason;
      if (*frame) frames.push_back(std::move(**frame));
    }
    return frames;
  }
  // How often each event is in the recording.
  std::map<std::string, int> Events(const char* name) const {
    std::ifstream file(folder_ / name / "events.jsonl");
    std::map<std::string, int> counts;
    for (std::string line; std::getline(file, line);) {
      ++counts[nlohmann::json::parse(line).at("event").get<std::string>()];
    }
    return counts;
  }
};

// The second camera plays what was recorded of the first one.
TEST_F(RecordCommand, RecordsWhatTheCameraGives) {
  const std::string site = " --site " + kSample.string();
  Ended ended = Record(kSample.string() + " --loop 3",
                       "/dev/video90 --auto --format YUYV --out " + Path("first") + site);
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  const std::vector<Frame> first = FramesOf(Path("first"));
  ASSERT_GT(first.size(), 3u);
  for (const char* store : {"raw", "ffv1"}) {
    fs::remove_all(Path("second"));
    ended = Record(Path("first"),
                   "/dev/video90 --auto --format RGB24 --out " + Path("second") + " --store " +
                       store + " --site " + Path("first"));
    EXPECT_EQ(ended.exit_code, 0) << ended.output;
    EXPECT_THAT(ended.output, HasSubstr(" 0 dropped, 0 lost by the driver, 0 damaged"));
    const std::vector<Frame> second = FramesOf(Path("second"));
    ASSERT_EQ(second.size(), first.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
      EXPECT_EQ(second[i].codes->pixels, first[i].codes->pixels) << i;
    }
    EXPECT_LT(std::chrono::abs(second[0].time - first[0].time), std::chrono::milliseconds(1));
  }
}

// The same pictures as through the single-planar one; a change of the source is noticed, too.
TEST_F(RecordCommand, ReadsTheMultiPlanarInterface) {
  for (const char* format : {"RGB24", "NV12", "MJPEG", "SRGGB10"}) {
    SCOPED_TRACE(format);
    std::vector<std::vector<Frame>> recorded;
    for (const char* interface : {"", " --multi-planar"}) {
      fs::remove_all(Path("day"));
      const Ended ended = Record(
          kSample.string() + " --pictures 1:1 --loop 30 --fault format-change@4p" + interface,
          std::string("/dev/video90 --auto --frames-limit 8 --format ") + format + " --out " +
              Path("day") + " --site " + kSample.string());
      EXPECT_EQ(ended.exit_code, 0) << ended.output;
      EXPECT_EQ(Events("day")["format-changed"], 1);
      recorded.push_back(FramesOf(Path("day")));
      ASSERT_EQ(recorded.back().size(), 8u);
    }
    EXPECT_EQ(recorded[0][0].radiance.pixels, recorded[1][0].radiance.pixels);
  }
}

TEST_F(RecordCommand, EndsCleanlyAtASignal) {
  for (const int signal : {SIGINT, SIGTERM}) {
    SCOPED_TRACE(signal);
    fs::remove_all(Path("day"));
    RunningCommand recording(
        Command(kSample.string() + " --loop 0",
                "/dev/video90 --auto --out " + Path("day") + " --site " + kSample.string()) +
        " >" + Path("output") + " 2>&1");
    const fs::path pictures = folder_ / "day/frames.jsonl";
    ASSERT_TRUE(recording.RunsUntil([&] { return !ContentOf(pictures).empty(); }))
        << ContentOf(Path("output"));
    EXPECT_EQ(recording.EndBy(signal), 0);
    EXPECT_THAT(ContentOf(Path("output")), HasSubstr(" pictures, "));
    EXPECT_GT(FramesOf(Path("day")).size(), 0u);
    EXPECT_EQ(Events("day")["ended"], 1);
  }
}

// The only picture passes while exposure is locked.
TEST_F(RecordCommand, EndsWithOneWhereNoPictureCame) {
  const Ended ended = Record(kSample.string() + " --pictures 0:0",
                             "/dev/video90 --out " + Path("day") + " --site " + kSample.string());
  EXPECT_EQ(ended.exit_code, 1) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("no picture was recorded"));
}

TEST_F(RecordCommand, NotesARateThatTheCameraDoesNotHave) {
  const std::string arguments =
      "/dev/video90 --auto --frames-limit 1 --site " + kSample.string() + " --out ";
  EXPECT_EQ(Record(kSample.string(), arguments + Path("thirty") + " --rate 30").exit_code, 0);
  EXPECT_EQ(Events("thirty")["control"], 0);
  const Ended ended = Record(kSample.string(), arguments + Path("fast") + " --rate 977");
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_EQ(Events("fast")["control"], 1);
  EXPECT_THAT(ended.output, HasSubstr("warning control: /dev/video90: rate: expected"));
}

// It comes back with its default gain, and refuses every control. The lock is done by picture 15.
TEST_F(RecordCommand, StatesNoGainWhereItIsAnotherOneAfterReconnection) {
  const Ended ended = Record(kSample.string() + " --loop 0 --fault control-refused@40p,unplug@44p",
                             "/dev/video90 --gain 250 --frames-limit 60 --out " + Path("day") +
                                 " --site " + kSample.string());
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  const std::vector<Frame> frames = FramesOf(Path("day"));
  ASSERT_EQ(frames.size(), 60u);
  EXPECT_TRUE(frames.front().exposure);
  EXPECT_FALSE(frames.back().exposure);
  EXPECT_EQ(frames.back().units, LightUnits::kRelativePerFrame);
}

TEST_F(RecordCommand, GoesOnWhenTheCameraIsBack) {
  const Ended ended = Record(kSample.string() + " --loop 0 --fault corrupt@2p,unplug-renumber@10p",
                             "/dev/video90 --auto --rate 10 --frames-limit 20 --out " +
                                 Path("day") + " --site " + kSample.string());
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  SCOPED_TRACE(ContentOf(folder_ / "day/events.jsonl"));
  EXPECT_EQ(FramesOf(Path("day")).size() + Events("day")["frame-damaged"], 20u);
  std::map<std::string, int> events = Events("day");
  EXPECT_EQ(events["unplugged"], 1);
  EXPECT_EQ(events["reconnected"], 1);
  EXPECT_EQ(events["frame-damaged"], 1);
}

// As udev's in /dev/v4l/by-id. The link is only where it was: its identity finds it again.
TEST_F(RecordCommand, OpensTheCameraThatALinkLeadsTo) {
  fs::create_symlink("/dev/video90", folder_ / "webcam");
  const Ended ended = Record(kSample.string() + " --loop 0 --fault unplug-renumber@6p",
                             Path("webcam") + " --auto --frames-limit 20 --out " + Path("day") +
                                 " --site " + kSample.string());
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_EQ(FramesOf(Path("day")).size(), 20u);
  EXPECT_EQ(Events("day")["reconnected"], 1);
  const Ended refused =
      Record(kSample.string(),
             "/dev/v4l/by-id/usb-none --out " + Path("none") + " --site " + kSample.string());
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.output, HasSubstr("pleinair: /dev/v4l/by-id/usb-none: expected a camera"));
}

TEST_F(RecordCommand, FindsTheCameraThatTheSiteNames) {
  const fs::path site = folder_ / "site";
  fs::copy(kSample, site, fs::copy_options::recursive);
  const auto name_camera = [&](const char* camera) {
    std::ifstream in(kSample / "sequence.json");
    nlohmann::json json = nlohmann::json::parse(in);
    json["camera_device"] = camera;
    std::ofstream(site / "sequence.json") << json;
  };
  name_camera("/dev/video90");
  const std::string arguments = site.string() + " --auto --frames-limit 2 --out ";
  EXPECT_EQ(Record(kSample.string(), arguments + Path("a")).exit_code, 0);
  EXPECT_EQ(FramesOf(Path("a")).size(), 2u);
  name_camera("Webcam|usb-elsewhere");
  const Ended ended = Record(kSample.string(), arguments + Path("b"));
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.output, HasSubstr("expected the camera 'Webcam|usb-elsewhere', which is not"));
}

TEST_F(RecordCommand, RefusesInOneLine) {
  const std::string site = " --site " + kSample.string();
  const std::string out = " --out " + Path("day");
  const std::pair<std::string, std::string> refusals[] = {
      {"/dev/video90" + out, "record: expected --site FOLDER"},
      {kSample.string() + out, "camera_device: expected a device or a camera's identity"},
      {"/dev/video91" + site + out, "/dev/video91: expected a camera"},
      {"/dev/video90" + site, "--out is required"},
      {"/dev/video90 --site " + Path("nowhere") + out, "found nothing"},
      {"/dev/video90 --every 3weeks" + site + out, "--every '3weeks': expected a time above 0"},
      {"/dev/video90 --every 0" + site + out, "--every '0': expected a time above 0"},
      {"/dev/video90 --format SGRBG99" + site + out, "--format 'SGRBG99': expected a pixel format"},
      {"/dev/video90 --size 640" + site + out, "--size '640': expected two numbers"},
      {"/dev/video90 --size 640x640" + site + out,
       "--size 640x640: expected a size that the camera"},
      {"/dev/video90 --exposure 1/0" + site + out, "camera exposure: expected a number above 0"},
      {"/dev/video90 --exposure soon" + site + out, "--exposure 'soon': expected seconds"},
      {"/dev/video90 --auto --gain 2" + site + out, "expected automatic controls or values"},
      {"/dev/video90 --store avi" + site + out, "--store: expected raw, ffv1 or h264, found 'avi'"},
      {"/dev/video90 --format SRGGB10 --store ffv1" + site + out, "expected the store `raw`"},
      {"/dev/video90 --duration 1e12" + site + out, "MB of free space, found"},
  };
  for (const auto& [arguments, reason] : refusals) {
    SCOPED_TRACE(arguments);
    const Ended ended = Record(kSample.string() + " --loop 0", arguments);
    EXPECT_EQ(ended.exit_code, 2);
    EXPECT_THAT(ended.output, testing::StartsWith("pleinair: "));
    EXPECT_THAT(ended.output, HasSubstr(reason));
    EXPECT_EQ(std::ranges::count(ended.output, '\n'), 1) << ended.output;
    EXPECT_FALSE(fs::exists(folder_ / "day/sequence.json"));
    fs::remove_all(Path("day"));
  }
}

}  // namespace
}  // namespace pleinair::record_command_test
