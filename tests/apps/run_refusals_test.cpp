// `pleinair run` on recordings and machines with something missing: what it says, and what it
// leaves alone.
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "apps/run_command.h"
#include "apps/stop_signals.h"
#include "tests/scene/temporary_folder.h"
#include "tests/session/command_folder.h"

namespace pleinair::run_refusals_test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// Another value while it lives.
class EnvironmentVariable {
 public:
  EnvironmentVariable(const char* name, const std::string& value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    setenv(name, value.c_str(), 1);
  }
  ~EnvironmentVariable() { before_ ? setenv(name_, before_->c_str(), 1) : unsetenv(name_); }
  EnvironmentVariable(const EnvironmentVariable&) = delete;
  EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

// The bundled recording's first frame, coarsely prepared, to be changed.
class RunRefusals : public CommandFolder {
 protected:
  void SetUp() override {
    CommandFolder::SetUp();
    const fs::path courtyard = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard";
    fs::create_directory(folder_ / "seq");
    for (const auto& entry : fs::directory_iterator(courtyard)) {
      if (entry.is_regular_file()) fs::copy(entry.path(), folder_ / "seq");
    }
    fs::create_directory(folder_ / "seq/frames");
    fs::copy(courtyard / "frames/000000.exr", folder_ / "seq/frames");
    std::ifstream(folder_ / "seq/sequence.json") >> document_;
    document_["frames"].erase(document_["frames"].begin() + 1, document_["frames"].end());
    Save();
    options_.sequence = folder_ / "seq";
    options_.cache = folder_ / "cache";
    options_.out = folder_ / "out";
    options_.prepare.patch_size_m = 4.0;
    options_.prepare.rays = 16;
  }
  void Save() { Write("seq/sequence.json", document_.dump()); }

  std::string Run() const {
    return Refusal(
        +[](const RunCommandOptions& options) {
          RunRunCommand(options);
          return std::string();
        },
        options_);
  }
  std::string Report() const {
    std::stringstream text;
    text << std::ifstream(options_.out / "report.html").rdbuf();
    return text.str();
  }

  nlohmann::json document_;
  RunCommandOptions options_;
};

TEST_F(RunRefusals, NeverWritesIntoTheRecording) {
  fs::rename(folder_ / "seq/frames", folder_ / "seq/composite");
  document_["frames"][0]["image"] = "composite/000000.exr";
  Save();
  const auto bytes = fs::file_size(folder_ / "seq/composite/000000.exr");
  options_.out = folder_ / "seq";
  EXPECT_THAT(Run(), HasSubstr("which is only read"));
  EXPECT_EQ(fs::file_size(folder_ / "seq/composite/000000.exr"), bytes);
}

TEST_F(RunRefusals, NeverWritesMapsIntoTheRecording) {
  PrepareCommandOptions prepare;
  prepare.sequence = folder_ / "seq";
  prepare.cache = folder_ / "cache";
  prepare.maps = folder_ / "seq/maps";
  const std::string refusal = Refusal(
      +[](const PrepareCommandOptions& options) {
        RunPrepareCommand(options);
        return std::string();
      },
      prepare);
  EXPECT_THAT(refusal, HasSubstr("seq/maps: is, holds or lies in"));
  EXPECT_FALSE(fs::exists(folder_ / "seq/maps"));
}

// A wrong target is said before anything is prepared, and a run that cannot begin takes no earlier
// one's results: those of its folder, its pictures and its lines.
TEST_F(RunRefusals, KeepsEarlierResultsUntilItBegins) {
  options_.picture_stream = "y4m:" + (folder_ / "live.y4m").string();
  options_.lighting_stream = (folder_ / "light.jsonl").string();
  ASSERT_EQ(Run(), "accepted");
  const std::vector<fs::path> results = {
      options_.out / "lighting.jsonl", folder_ / "live.y4m", folder_ / "light.jsonl"};
  std::vector<std::string> contents;
  contents.reserve(results.size());
  for (const fs::path& result : results) contents.push_back(ContentOf(result));
  const auto expect_kept = [&] {
    for (std::size_t i = 0; i < results.size(); ++i) {
      EXPECT_EQ(ContentOf(results[i]), contents[i]) << results[i];
    }
  };

  RunCommandOptions unprepared = options_;
  unprepared.cache = folder_ / "another_cache";
  for (const auto& [stream, lines, why] :
       {std::array{
            "y4m:/no/such/folder/live.y4m", "-", "/no/such/folder/live.y4m: expected a file"},
        std::array{"v4l2:/no/such/device", "-", "expected a loopback device"},
        std::array{
            "y4m:-", "/no/such/folder/light.jsonl", "light.jsonl: expected a file or pipe"}}) {
    std::swap(options_, unprepared);
    options_.picture_stream = stream;
    options_.lighting_stream = lines;
    EXPECT_THAT(Run(), HasSubstr(why));
    EXPECT_FALSE(fs::exists(folder_ / "another_cache")) << "prepared first: " << why;
    std::swap(options_, unprepared);
    expect_kept();
  }

  document_["scene"]["mesh"] = "absent.obj";
  Save();
  EXPECT_THAT(Run(), HasSubstr("absent.obj"));
  expect_kept();
  options_.out = folder_ / "new";
  EXPECT_THAT(Run(), HasSubstr("absent.obj"));
  EXPECT_FALSE(fs::exists(folder_ / "new")) << "nothing is in it";
}

// It would be removed with the earlier run's results, or replaced by the run's own.
TEST_F(RunRefusals, NoStreamHasAResultsName) {
  const std::string lines = (options_.out / "lighting.jsonl").string();
  options_.lighting_stream = lines;
  EXPECT_THAT(Run(), HasSubstr("--lighting-stream: " + lines));
  options_.lighting_stream.clear();
  for (const char* name : {"composite.mp4", "composite/000000.png"}) {
    options_.picture_stream = "y4m:" + (options_.out / name).string();
    EXPECT_THAT(Run(), HasSubstr("--stream: " + (options_.out / name).string()));
  }
  EXPECT_FALSE(fs::exists(options_.out));
}

TEST_F(RunRefusals, WritesOverALongerStreamOfAnEarlierRun) {
  Write("live.y4m", std::string(1'000'000, 'x'));
  Write("light.jsonl", std::string(100'000, 'x'));
  options_.picture_stream = "y4m:" + (folder_ / "live.y4m").string();
  options_.lighting_stream = (folder_ / "light.jsonl").string();
  ASSERT_EQ(Run(), "accepted");
  const std::string pictures = ContentOf(folder_ / "live.y4m");
  constexpr std::size_t kOneFrame = 6 + 3 * 480 * 360;
  EXPECT_EQ(pictures.size(), pictures.find('\n') + 1 + kOneFrame);
  EXPECT_EQ(ContentOf(folder_ / "light.jsonl"), ContentOf(options_.out / "lighting.jsonl"));
}

TEST_F(RunRefusals, EndsWithTheFirstFramesReasonWhereAllFail) {
  document_["frames"][0]["image"] = "frames/999999.exr";
  Save();
  EXPECT_THAT(Run(),
              AllOf(HasSubstr("failed; frame 0: "),
                    HasSubstr("frames/999999.exr: expected an image file, found nothing")));
  EXPECT_THAT(Report(), AllOf(HasSubstr("999999.exr"), Not(HasSubstr("gnuplot"))));
  EXPECT_TRUE(fs::exists(options_.out / "lighting.jsonl"));
  options_.stop_on_bad_frame = true;
  EXPECT_THAT(Run(), HasSubstr("stopped at frame 0, as asked: "));
}

TEST_F(RunRefusals, KeepsTheEarlierRunsResultsWhereAllFramesFail) {
  ASSERT_EQ(Run(), "accepted");
  const std::string report = Report();
  const std::string light = ContentOf(options_.out / "lighting.jsonl");
  document_["frames"][0]["image"] = "frames/999999.exr";
  Save();
  EXPECT_THAT(Run(), HasSubstr("failed; frame 0: "));
  EXPECT_TRUE(fs::exists(options_.out / "composite/000000.exr"));
  EXPECT_EQ(Report(), report);
  EXPECT_EQ(ContentOf(options_.out / "lighting.jsonl"), light);
  EXPECT_FALSE(fs::exists(options_.out / "lighting.jsonl.partial"));
}

// Its stream blocks, since nobody reads: the signal comes before the first frame's end, and nobody
// who reads is needed to end the run.
TEST_F(RunRefusals, EndsWithTheFramesDoneWhereItIsInterrupted) {
  document_["frames"].push_back(document_["frames"][0]);
  document_["frames"][1]["time_utc"] = "2005-06-21T10:30:00Z";
  Save();
  const std::string pipe = (folder_ / "pipe").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  options_.picture_stream = "y4m:" + pipe;
  std::jthread interrupting([reader] {
    constexpr int kPatienceMs = 300'000;
    pollfd readable{reader, POLLIN, 0};
    poll(&readable, 1, kPatienceMs);
    kill(getpid(), SIGINT);
  });
  EXPECT_EQ(Run(), "interrupted after 1 of 2 frames");
  interrupting.join();
  close(reader);
  EXPECT_THAT(Report(), HasSubstr("interrupted after 1 of 2 frames"));
  EXPECT_TRUE(fs::exists(options_.out / "composite/000000.png"));
  EXPECT_FALSE(fs::exists(options_.out / "composite/000001.png"));
  const std::string light = ContentOf(options_.out / "lighting.jsonl");
  EXPECT_EQ(std::count(light.begin(), light.end(), '\n'), 1);
  struct sigaction of_interrupt {};
  sigaction(SIGINT, nullptr, &of_interrupt);
  EXPECT_EQ(of_interrupt.sa_handler, SIG_DFL) << "as it was before";
}

TEST_F(RunRefusals, EndsWithTheFramesDoneWhereItIsStrict) {
  document_["frames"].push_back(document_["frames"][0]);
  document_["frames"][1]["time_utc"] = "2005-06-21T10:30:00Z";
  document_["frames"][1]["image"] = "frames/999999.exr";
  Save();
  options_.stop_on_bad_frame = true;
  EXPECT_THAT(Run(), HasSubstr("stopped at frame 1, as asked: "));
  EXPECT_THAT(Report(), HasSubstr("stopped at frame 1"));
  EXPECT_TRUE(fs::exists(options_.out / "lighting.jsonl"));
}

TEST(StopFlag, LeavesAnIgnoredSignalIgnored) {
  struct sigaction before {};
  struct sigaction ignored {};
  ignored.sa_handler = SIG_IGN;
  sigaction(SIGHUP, &ignored, &before);
  {
    const StopFlag stop;
    raise(SIGHUP);
    EXPECT_FALSE(stop.IsSet());
    raise(SIGTERM);
    raise(SIGTERM);  // Of the same request.
    EXPECT_TRUE(stop.IsSet());
  }
  EXPECT_FALSE(StopFlag().IsSet()) << "a request is for one run";
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // The process has threads.
  EXPECT_EXIT(
      {
        const StopFlag stop;
        raise(SIGINT);
        std::this_thread::sleep_for(std::chrono::milliseconds(1100));
        raise(SIGINT);
      },
      testing::ExitedWithCode(128 + SIGINT),
      "");
  sigaction(SIGHUP, &before, nullptr);
}

TEST_F(RunRefusals, DrawsItsChartsWithoutATemporaryFolder) {
  const EnvironmentVariable temporary("TMPDIR", "/nonexistent/it's");
  EXPECT_EQ(Run(), "accepted");
  EXPECT_THAT(Report(), HasSubstr("<svg"));
}

TEST_F(RunRefusals, ReportsWithoutChartsWhereThereIsNoGnuplot) {
  const EnvironmentVariable path("PATH", folder_.string());
  EXPECT_EQ(Run(), "accepted");
  EXPECT_THAT(Report(),
              AllOf(HasSubstr("gnuplot could not draw"),
                    HasSubstr("gnuplot-nox"),
                    Not(HasSubstr("<svg")),
                    HasSubstr("data:image/jpeg")));
}

TEST_F(RunRefusals, ReportsWithoutATruthThatCannotBeRead) {
  fs::create_directory(folder_ / "seq/truth");
  Write("seq/truth/truth.json", "{\"frames\": 3}");
  EXPECT_EQ(Run(), "accepted");
  EXPECT_THAT(Report(), HasSubstr("the report is without truth: "));
}

// What light does between real surfaces, and what the survey found, do not depend on what stands
// there virtually; only the probes do, which stand around it.
TEST_F(RunRefusals, PreparesNothingButProbesForAnotherObject) {
  std::vector<std::string> stages;
  const Progress progress = [&](std::string_view stage, double share) {
    if (share == 0.0) stages.emplace_back(stage);
  };
  LoadSequence(options_, progress);
  EXPECT_EQ(stages.size(), 3u);
  stages.clear();
  Write("seq/other.obj",
        "v 0 0 0\nv 3 0 0\nv 0 3 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  document_["virtual_object"]["mesh"] = "other.obj";
  document_["virtual_object"]["world_from_object"][0][3] = 1.5;
  Save();
  LoadSequence(options_, progress);
  EXPECT_THAT(stages, ElementsAre("probes"));
  stages.clear();
  LoadSequence(options_, progress);
  EXPECT_THAT(stages, IsEmpty());
}

}  // namespace
}  // namespace pleinair::run_refusals_test
