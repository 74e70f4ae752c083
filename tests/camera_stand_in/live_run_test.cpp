// `pleinair run` of a camera, which the stand-in is: what a run leaves, and that its recording
// gives the same.
//
// Nothing here depends on how fast the machine is: frames that are dropped are no failure, and on a
// slow one more of them are.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/videoio.hpp>

#include "scene/image_io.h"
#include "sunmodel/time_text.h"
#include "tests/scene/running_command.h"
#include "tests/scene/shell.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::live_run_test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::HasSubstr;

const std::string kCourtyard = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard";

std::vector<std::string> LinesOf(const fs::path& file) {
  std::vector<std::string> lines;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::vector<Json> JsonLinesOf(const fs::path& file) {
  std::vector<Json> lines;
  for (const std::string& line : LinesOf(file)) lines.push_back(Json::parse(line));
  return lines;
}

// The site is prepared once for all tests, coarsely.
class LiveRun : public testing::Test {
 protected:
  void SetUp() override {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "sanitizers do not load behind the stand-in";
#endif
  }
  static void SetUpTestSuite() {
    of_all_tests_ = std::make_unique<TemporaryFolder>();
    const Ended prepared =
        Shell(std::string(PLEINAIR_PROGRAM) + " prepare " + kCourtyard + Coarse());
    ASSERT_EQ(prepared.exit_code, 0) << prepared.output;
  }
  static void TearDownTestSuite() { of_all_tests_.reset(); }

  static std::string Coarse() {
    return " --cache " + (*of_all_tests_ / "cache").string() +
           " --set prepare.patch_size_m=4 --set prepare.rays=16";
  }
  // Coarse, and nothing is left out for a time that it took.
  static std::string Settings() {
    return Coarse() +
           " --budget 100000 --quality fast --set pipeline.view.receiver_block_px=16"
           " --set pipeline.object_light.gather.rays_per_receiver=32"
           " --set pipeline.influence.rays_per_receiver=16";
  }

  std::string Out(const std::string& name) const { return (folder_ / name).string(); }

  // Exposure and colours are stated: nothing has to settle.
  std::string Command(const std::string& stand_in, const std::string& run, int rate = 10) const {
    return std::string(PLEINAIR_STAND_IN) + " " + kCourtyard + " " + stand_in + " -- " +
           PLEINAIR_PROGRAM + " run /dev/video90 --site " + kCourtyard + Settings() +
           " --exposure 0.01 --gain 100 --white-balance 5000 --rate " + std::to_string(rate) + " " +
           run;
  }

  // The run's files are complete, and agree on how many frames there were: so many are returned.
  static std::size_t CheckComplete(const fs::path& out) {
    const std::vector<Json> light = JsonLinesOf(out / "lighting.jsonl");
    for (std::size_t i = 0; i < light.size(); ++i) EXPECT_EQ(light[i]["frame"], i);
    EXPECT_EQ(LinesOf(out / "plan.jsonl").size(), light.size());
    const std::string report = ContentOf(out / "report.html");
    EXPECT_THAT(report, testing::EndsWith("</html>\n"));
    for (const auto& file : fs::directory_iterator(out)) {
      EXPECT_THAT(file.path().filename().string(),
                  testing::Not(testing::AnyOf(HasSubstr("partial"), HasSubstr(".part"))));
    }
    const std::vector<Json> events = JsonLinesOf(out / "events.jsonl");
    EXPECT_EQ(events.front()["event"], "started");
    EXPECT_EQ(events.back()["event"], "ended");
    return light.size();
  }

  // Event's kind -> how often, with all its frames.
  static std::map<std::string, int> CountEvents(const fs::path& out) {
    std::map<std::string, int> counts;
    for (const Json& event : JsonLinesOf(out / "events.jsonl")) {
      counts[event["event"]] += event.value("count", 1);
    }
    return counts;
  }

  // What does not say how long something took.
  static Json Timeless(Json line) {
    line.erase("latency_ms");
    line.erase("timing_ms");
    return line;
  }

  // Light and composites of two runs, frame by frame.
  static void ExpectSame(const fs::path& live, const fs::path& again) {
    const std::vector<Json> a = JsonLinesOf(live / "lighting.jsonl");
    const std::vector<Json> b = JsonLinesOf(again / "lighting.jsonl");
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(Timeless(a[i]), Timeless(b[i]));
      const std::string name = fmt::format("composite/{:06}.png", i);
      const Rgb8Image composite = ReadDisplayImage(live / name);
      EXPECT_EQ(composite.pixels, ReadDisplayImage(again / name).pixels) << name;
    }
  }

  inline static std::unique_ptr<TemporaryFolder> of_all_tests_;
  TemporaryFolder folder_;
};

// A header and one frame after another: three planes of a byte a pixel. BT.601, full range.
void ExpectPictures(const fs::path& y4m, const std::vector<fs::path>& pictures) {
  const std::string stream = ContentOf(y4m);
  const std::size_t header = stream.find('\n') + 1;
  EXPECT_THAT(stream.substr(0, header), HasSubstr("YUV4MPEG2 W480 H360 "));
  constexpr std::size_t kPixels = 480 * 360;
  const std::string marker = "FRAME\n";
  const std::size_t frame_bytes = marker.size() + 3 * kPixels;
  ASSERT_EQ((stream.size() - header) % frame_bytes, 0u);
  ASSERT_EQ((stream.size() - header) / frame_bytes, pictures.size());
  for (std::size_t frame = 0; frame < pictures.size(); ++frame) {
    const std::size_t at = header + frame * frame_bytes;
    EXPECT_EQ(stream.substr(at, marker.size()), marker);
    const Rgb8Image shown = ReadDisplayImage(pictures[frame]);
    double worst = 0.0;
    for (std::size_t i = 0; i < kPixels; ++i) {
      const glm::u8vec3& rgb = shown.pixels[i];
      const double luma = 0.299 * rgb.x + 0.587 * rgb.y + 0.114 * rgb.z;
      const auto code = static_cast<unsigned char>(stream[at + marker.size() + i]);
      worst = std::max(worst, std::abs(code - luma));
    }
    EXPECT_LE(worst, 0.5 + 1e-9);
  }
}

// Of a run of so many composites.
std::vector<fs::path> CompositesOf(const fs::path& out, std::size_t count) {
  std::vector<fs::path> composites;
  for (std::size_t frame = 0; frame < count; ++frame) {
    composites.push_back(out / fmt::format("composite/{:06}.png", frame));
  }
  return composites;
}

TEST_F(LiveRun, ItsRecordingGivesTheSameLightAndCompositesBitForBit) {
  for (const std::string format : {"RGB24", "YUYV", "MJPEG"}) {
    SCOPED_TRACE(format);
    const fs::path live = Out(format);
    const fs::path recording = Out(format + "-recording");
    const fs::path again = Out(format + "-again");
    const Ended run =
        Shell(Command("--loop 0",
                      "--frames-limit 4 --format " + format + " --out " + live.string() +
                          " --record " + recording.string() + " --stream y4m:" + Out("live.y4m") +
                          " --lighting-stream " + Out("live.jsonl")));
    ASSERT_EQ(run.exit_code, 0) << run.output;
    EXPECT_EQ(CheckComplete(live), 4u);
    EXPECT_EQ(LinesOf(recording / "frames.jsonl").size(), 4u);
    ExpectPictures(Out("live.y4m"), CompositesOf(live, 4));
    EXPECT_EQ(ContentOf(Out("live.jsonl")), ContentOf(live / "lighting.jsonl"));

    const Ended replay = Shell(std::string(PLEINAIR_PROGRAM) + " run " + recording.string() +
                               Settings() + " --out " + again.string());
    ASSERT_EQ(replay.exit_code, 0) << replay.output;
    ExpectSame(live, again);
    // Of a camera's frames the scene-linear pictures are not written unless they are asked for.
    EXPECT_FALSE(fs::exists(live / "composite/000000.exr"));
    EXPECT_TRUE(fs::exists(again / "composite/000000.exr"));
  }
}

// A tracker's poses, of a camera that is moved about: the recording has those that were used. One
// line is a mirror image: an event.
TEST_F(LiveRun, FollowsPosesFromOutsideAndRecordsThem) {
  const Json sequence = Json::parse(ContentOf(fs::path(kCourtyard) / "sequence.json"));
  const UtcTime start =
      ParseUtcTime(sequence["frames"][0]["time_utc"].get<std::string>()) - std::chrono::seconds(5);
  Json pose = sequence["camera"]["camera_from_world"];
  const double x_m = pose[0][3].get<double>();
  const fs::path poses = folder_ / "poses.jsonl";
  {
    std::ofstream lines(poses);
    for (int i = 0; i < 3000; ++i) {
      pose[0][3] = x_m + 0.1 * std::sin(0.3 * i);
      const UtcTime time = start + i * std::chrono::milliseconds(100);
      lines << Json{{"time_utc", FormatUtcTime(time)}, {"camera_from_world", pose}}.dump() << "\n";
      if (i > 0) continue;
      Json mirrored = pose;
      for (Json& value : mirrored[0]) value = -value.get<double>();
      lines << Json{{"time_utc", FormatUtcTime(time)}, {"camera_from_world", mirrored}}.dump()
            << "\n";
    }
  }
  const fs::path live = Out("live");
  const fs::path recording = Out("recording");
  const Ended run =
      Shell(Command("--loop 0",
                    "--frames-limit 4 --format RGB24 --poses " + poses.string() + " --out " +
                        live.string() + " --record " + recording.string()));
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_EQ(CheckComplete(live), 4u);
  EXPECT_EQ(CountEvents(live)["pose"], 1);
  EXPECT_THAT(ContentOf(live / "events.jsonl"), HasSubstr("a rotation, not a mirror image"));
  const std::vector<Json> frames = JsonLinesOf(recording / "frames.jsonl");
  ASSERT_EQ(frames.size(), 4u);
  std::set<double> places_m;
  for (const Json& frame : frames) {
    const double place_m = frame["camera_from_world"][0][3].get<double>();
    EXPECT_LE(std::abs(place_m - x_m), 0.1 + 1e-9);
    places_m.insert(place_m);
  }
  EXPECT_EQ(places_m.size(), 4u);
  const fs::path again = Out("again");
  const Ended replay = Shell(std::string(PLEINAIR_PROGRAM) + " run " + recording.string() +
                             Settings() + " --out " + again.string());
  ASSERT_EQ(replay.exit_code, 0) << replay.output;
  ExpectSame(live, again);
}

// The courtyard has no markers: each frame says so, and nothing of them is recorded.
TEST_F(LiveRun, LooksForMarkersInItsPictures) {
  const fs::path board = folder_.Write("board.json", R"({"format": "pleinair-markers", "version": 1,
      "dictionary": "apriltag_36h11",
      "markers": [{"id": 3, "corners_world_m": [[0, 1, 0], [1, 1, 0], [1, 0, 0], [0, 0, 0]]}]})");
  const fs::path out = Out("out");
  const Ended run = Shell(Command("--loop 0",
                                  "--frames-limit 2 --markers " + board.string() + " --out " +
                                      out.string() + " --record " + Out("recording")));
  EXPECT_EQ(run.exit_code, 2) << run.output;
  EXPECT_EQ(CheckComplete(out), 2u);
  for (const Json& line : JsonLinesOf(out / "lighting.jsonl")) {
    EXPECT_EQ(line["error"], "camera pose is not known: no marker is seen");
  }
  EXPECT_TRUE(LinesOf(folder_ / "recording" / "frames.jsonl").empty());
}

// While a site is prepared, pictures are streamed, recorded and in the video as they came;
// composites follow.
TEST_F(LiveRun, ShowsPicturesAsTheyComeWhileItsSiteIsPrepared) {
  const fs::path out = Out("out");
  const fs::path recording = Out("recording");
  const std::string unprepared = " --set prepare.rays=32";
  const Ended run =
      Shell(Command("--loop 0",
                    "--frames-limit 3 --video --format RGB24 --out " + out.string() + " --record " +
                        recording.string() + " --stream y4m:" + Out("live.y4m") + unprepared,
                    15));
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_EQ(CheckComplete(out), 3u);
  const std::map<std::string, int> counts = CountEvents(out);
  EXPECT_EQ(counts.at("preparing"), 1);
  EXPECT_EQ(counts.at("prepared"), 1);
  EXPECT_EQ(CountEvents(recording).at("prepared"), 1);
  const std::vector<Json> recorded = JsonLinesOf(recording / "frames.jsonl");
  ASSERT_GT(recorded.size(), 3u);
  const std::size_t passed = recorded.size() - 3;
  std::vector<fs::path> pictures;
  for (std::size_t i = 0; i < passed; ++i) {
    pictures.push_back(recording / recorded[i]["image_ldr"].get<std::string>());
  }
  const std::vector<fs::path> composites = CompositesOf(out, 3);
  pictures.insert(pictures.end(), composites.begin(), composites.end());
  ExpectPictures(Out("live.y4m"), pictures);

  const cv::VideoCapture video((out / "composite.mp4").string());
  EXPECT_DOUBLE_EQ(video.get(cv::CAP_PROP_FPS), 15.0);
  EXPECT_EQ(video.get(cv::CAP_PROP_FRAME_COUNT), static_cast<double>(recorded.size()));
}

// White balance and gain settle before the lock, so exposure is set while pictures come.
TEST_F(LiveRun, NoPictureIsOfSettingsBeforeTheLockWhateverTheSensorsDelay) {
  const fs::path recording = folder_ / "recording";
  const Ended record = Shell(std::string(PLEINAIR_STAND_IN) + " " + kCourtyard +
                             " --pictures 3:3 --loop 0 --control-delay 4 -- " + PLEINAIR_PROGRAM +
                             " record /dev/video90 --site " + kCourtyard +
                             " --exposure 0.03 --frames-limit 3 --out " + recording.string());
  ASSERT_EQ(record.exit_code, 0) << record.output;
  std::set<std::string> pictures;
  for (const auto& file : fs::directory_iterator(recording / "frames")) {
    pictures.insert(ContentOf(file.path()));
  }
  EXPECT_EQ(pictures.size(), 1u);
}

// Every frame that was recorded is one that was composited, also the last one.
TEST_F(LiveRun, EndsWhenItsTimeIsOver) {
  const fs::path out = Out("out");
  const fs::path recording = Out("recording");
  const Ended run = Shell(Command(
      "--loop 0",
      "--duration 0.5 --pictures none --out " + out.string() + " --record " + recording.string()));
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const std::size_t frames = CheckComplete(out);
  EXPECT_GE(frames, 1u);
  EXPECT_EQ(LinesOf(recording / "frames.jsonl").size(), frames);
  EXPECT_FALSE(fs::exists(out / "composite") && !fs::is_empty(out / "composite"));
}

TEST_F(LiveRun, EndsCleanlyWhenItIsAskedTo) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const fs::path out = Out(std::to_string(signal));
    const fs::path recording = Out(std::to_string(signal) + "-recording");
    RunningCommand run(
        Command("--loop 0", "--out " + out.string() + " --record " + recording.string()) +
        " >/dev/null 2>&1");
    ASSERT_TRUE(run.RunsUntil([&] { return !LinesOf(out / "lighting.jsonl.partial").empty(); }))
        << "ended before its first frame";
    EXPECT_EQ(run.EndBy(signal), 0) << signal;
    const std::size_t frames = CheckComplete(out);
    EXPECT_GE(frames, 1u);
    EXPECT_EQ(LinesOf(recording / "frames.jsonl").size(), frames);
  }
}

// The pipe holds less than a picture: the output waits for its reader from the first one on.
TEST_F(LiveRun, EndsWithoutTheReaderOfAStream) {
  const std::string pipe = Out("pipe");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  const auto frames_until = [&](const std::string& end) -> std::size_t {
    SCOPED_TRACE(end);
    const fs::path out = Out("out");
    const std::string options =
        fmt::format("{} --pictures none --stream y4m:{} --out {}", end, pipe, out.string());
    const std::string log = Out("log");
    RunningCommand run(Command("--loop 0", options) + " >" + log + " 2>&1");
    // How long it takes to start depends on what else the machine does.
    run.RunsUntil([&] {
      return ContentOf(out / "events.jsonl.partial").find("prepared") != std::string::npos;
    });
    const auto start = std::chrono::steady_clock::now();
    const bool goes_on = run.RunsUntil(
        [&] { return std::chrono::steady_clock::now() - start > std::chrono::seconds(60); });
    EXPECT_FALSE(goes_on) << "it waits for its reader";
    EXPECT_EQ(run.EndBy(SIGKILL), 0) << ContentOf(log);
    EXPECT_EQ(CountEvents(out).at("output"), 1);
    EXPECT_THAT(ContentOf(log), HasSubstr(pipe + ": its reader does not read"));
    return CheckComplete(out);
  };
  EXPECT_EQ(frames_until("--frames-limit 2"), 2u);
  // A machine that makes less than two frames in it gets more time.
  std::size_t frames = 0;
  for (int seconds = 1; frames < 2 && seconds <= 32; seconds *= 2) {
    frames = frames_until(fmt::format("--duration {}", seconds));
  }
  EXPECT_GE(frames, 2u);
  close(reader);
}

// What happens to a camera: each has its event, and the run goes on to the end of the stream. That
// the clock is put forward by an hour is no hour of the run's duration.
TEST_F(LiveRun, GoesOnThroughFaultsAndReportsEach) {
  const fs::path out = Out("out");
  const Ended run = Shell(Command(
      "--loop 20 --fault time-repeat@0.5,time-back@2,drop@2.5,clock-back@3,clock-forward@3.6,"
      "format-change@4.5,unplug@6,unplug-renumber@7.5,stall@9",
      "--duration 1000 --pictures none --out " + out.string()));
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_GE(CheckComplete(out), 1u);
  EXPECT_THAT(run.output, HasSubstr("the stream has ended"));
  const std::map<std::string, int> counts = CountEvents(out);
  const auto count = [&](const char* kind) { return counts.contains(kind) ? counts.at(kind) : 0; };
  EXPECT_GE(count("timestamp"), 2) << ContentOf(out / "events.jsonl");
  EXPECT_GE(count("frame-lost"), 1);
  EXPECT_EQ(count("format-changed"), 1);
  EXPECT_EQ(count("unplugged"), 2);
  EXPECT_EQ(count("stalled"), 1);
  // After the change of format, both unpluggings and the stall.
  EXPECT_EQ(count("reconnected"), 4);
  EXPECT_EQ(count("ended"), 2);
  const std::string events = ContentOf(out / "events.jsonl");
  EXPECT_THAT(events, HasSubstr("stepped by -3600.0"));
  EXPECT_THAT(events, HasSubstr("stepped by +3600.0"));
  EXPECT_THAT(events, HasSubstr("/dev/video91"));
}

// Every second picture is bad: a frame of its own error each, none ends the run. And both streams'
// disc is full from the first byte on.
TEST_F(LiveRun, GoesOnPastBadPicturesAndFullDiscs) {
  for (const auto& [fault, format, reason] : {std::array{"truncate", "YUYV", "bytes of YUYV"},
                                              std::array{"corrupt", "MJPEG", "damage"}}) {
    SCOPED_TRACE(fault);
    std::string faults;
    for (int i = 0; i < 60; ++i) {
      faults += fmt::format("{}{}@{:.1f}", i == 0 ? "" : ",", fault, 0.1 + 0.2 * i);
    }
    const fs::path out = Out(fault);
    const Ended run = Shell(Command("--loop 20 --fault " + faults,
                                    "--frames-limit 12 --pictures none --stream y4m:/dev/full "
                                    "--lighting-stream /dev/full --format " +
                                        std::string(format) + " --out " + out.string()));
    ASSERT_EQ(run.exit_code, 0) << run.output;
    const std::size_t frames = CheckComplete(out);
    int failed = 0;
    for (const Json& line : JsonLinesOf(out / "lighting.jsonl")) {
      if (!line.contains("error")) continue;
      ++failed;
      EXPECT_THAT(line["error"].get<std::string>(), HasSubstr(reason));
    }
    EXPECT_GE(failed, 1);
    EXPECT_EQ(frames, 12u);
    EXPECT_LT(failed, 12);
    const std::map<std::string, int> counts = CountEvents(out);
    // Those that came while the site was prepared are events alone.
    EXPECT_GE(counts.at("frame-damaged"), failed);
    EXPECT_EQ(counts.at("output"), 2);
    EXPECT_THAT(ContentOf(out / "events.jsonl"), HasSubstr("/dev/full"));
  }
}

TEST_F(LiveRun, SaysInItsEventsWhyItEndedEarly) {
  const fs::path out = Out("out");
  // So many in a row that a slow machine does not drop all of them.
  std::string faults;
  for (int picture = 30; picture < 90; ++picture) {
    faults += fmt::format("{}truncate@{}p", picture == 30 ? "" : ",", picture);
  }
  const Ended run = Shell(Command("--loop 20 --fault " + faults,
                                  "--strict --pictures none --format YUYV --out " + out.string()));
  EXPECT_EQ(run.exit_code, 2) << run.output;
  EXPECT_GE(CheckComplete(out), 1u);
  const Json bad = JsonLinesOf(out / "lighting.jsonl").back();
  EXPECT_TRUE(bad.contains("error")) << bad;
  EXPECT_EQ(CountEvents(out).at("failed"), 1);
  EXPECT_THAT(ContentOf(out / "events.jsonl"), HasSubstr("as asked: "));
  EXPECT_THAT(ContentOf(out / "report.html"), HasSubstr("as asked: "));
}

// Its composites fill it; what is kept for the report of the disk is enough for the light of a day.
TEST_F(LiveRun, EndsWithAWholeReportWhereTheDiskIsFull) {
  const fs::path disk = folder_ / "disk";
  fs::create_directory(disk);
  const std::string out = (disk / "out").string();
  const auto on_small_disk = [&](const std::string& command) {
    return Shell("unshare --map-root-user --mount sh -c 'mount -t tmpfs -o size=9m none " +
                 disk.string() + " && " + command + "'");
  };
  if (on_small_disk("true").exit_code != 0) GTEST_SKIP() << "no disk may be mounted here";
  const Ended run = on_small_disk(Command("--loop 0", "--out " + out) + "; code=$?; cp -r " + out +
                                  " " + Out("kept") + "; exit $code");
  EXPECT_EQ(run.exit_code, 2) << run.output;
  EXPECT_GE(CheckComplete(Out("kept")), 10u);
  EXPECT_EQ(CountEvents(Out("kept")).at("disk"), 2);
  EXPECT_THAT(ContentOf(folder_ / "kept/report.html"), HasSubstr("<svg"));
  EXPECT_THAT(ContentOf(folder_ / "kept/report.html"), HasSubstr("No space left on device"));
  // The last line alone is an error.
  const std::string last = run.output.substr(run.output.rfind('\n', run.output.size() - 2) + 1);
  EXPECT_THAT(last, testing::StartsWith("pleinair: " + out + "/")) << run.output;
  EXPECT_THAT(last, HasSubstr("No space left on device")) << run.output;
  EXPECT_THAT(run.output, testing::Not(HasSubstr("\nerror "))) << run.output;
}

// Its site's mesh is no mesh, which only preparing it finds.
TEST_F(LiveRun, KeepsEarlierResultsWhereItCannotBegin) {
  const fs::path site = folder_ / "site";
  fs::copy(kCourtyard, site);
  std::ofstream(site / "scene.obj") << "f 1 2 3\n";
  const fs::path out = folder_ / "out";
  fs::create_directory(out);
  for (const char* name : {"lighting.jsonl", "events.jsonl", "report.html"}) {
    std::ofstream(out / name) << "of an earlier run";
  }
  const Ended run =
      Shell(std::string(PLEINAIR_STAND_IN) + " " + kCourtyard + " --loop 0 -- " + PLEINAIR_PROGRAM +
            " run /dev/video90 --site " + site.string() + Settings() + " --out " + out.string());
  EXPECT_EQ(run.exit_code, 2) << run.output;
  EXPECT_THAT(run.output, HasSubstr("scene.obj"));
  for (const char* name : {"lighting.jsonl", "events.jsonl", "report.html"}) {
    EXPECT_EQ(ContentOf(out / name), "of an earlier run") << name;
  }
  EXPECT_FALSE(fs::exists(out / "lighting.jsonl.partial"));
}

TEST_F(LiveRun, RefusesACameraThatIsNotThere) {
  const std::string command = std::string(PLEINAIR_STAND_IN) + " " + kCourtyard + " -- " +
                              PLEINAIR_PROGRAM + " run /dev/video91 --site " + kCourtyard +
                              Settings() + " --out " + Out("out");
  const Ended run = Shell(command);
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.output, HasSubstr("pleinair: /dev/video91: "));
  EXPECT_EQ(std::count(run.output.begin(), run.output.end(), '\n'), 1) << run.output;
}

}  // namespace
}  // namespace pleinair::live_run_test
