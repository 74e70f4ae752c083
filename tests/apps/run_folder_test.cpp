#include "apps/run_folder.h"

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

#include "tests/scene/file_size_limit.h"
#include "tests/scene/temporary_folder.h"
#include "tests/session/command_folder.h"

namespace pleinair::run_folder_test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class RunFolderTest : public CommandFolder {
 protected:
  template <typename Call>
  static std::string MessageOf(const Call& call) {
    try {
      call();
    } catch (const std::exception& error) {
      return error.what();
    }
    return "accepted";
  }
  void Touch(const std::string& name) {
    fs::create_directories((folder_ / name).parent_path());
    Write(name, "x");
  }
  bool IsThere(const std::string& name) const { return fs::exists(folder_ / name); }
};

TEST_F(RunFolderTest, ResultsAreApartFromWhatIsRead) {
  Touch("seq/frames/000000.exr");
  Touch("elsewhere/000000.exr");
  for (const char* out : {"seq", "seq/", "seq/out", "seq/frames", "seq/../seq", "."}) {
    EXPECT_THAT(MessageOf([&] { RequireApart(folder_ / out, folder_ / "seq"); }),
                HasSubstr("which is only read"))
        << out;
  }
  for (const char* out : {"out", "sequence", "seq2/out/", "elsewhere"}) {
    EXPECT_EQ(MessageOf([&] { RequireApart(folder_ / out, folder_ / "seq/"); }), "accepted") << out;
  }
  // A link to the folder itself, or to one that a run clears.
  fs::create_directory_symlink(folder_ / "seq", folder_ / "link");
  EXPECT_NE(MessageOf([&] { RequireApart(folder_ / "link/out", folder_ / "seq"); }), "accepted");
  fs::create_directory_symlink(folder_ / "seq/frames", folder_ / "elsewhere/composite");
  EXPECT_THAT(MessageOf([&] { RequireApart(folder_ / "elsewhere", folder_ / "seq"); }),
              HasSubstr("elsewhere/composite"));
}

TEST_F(RunFolderTest, OneAtATimeAndItSaysWho) {
  const std::string me = "process " + std::to_string(getpid()) + " on ";
  {
    const FolderLock lock(folder_);
    EXPECT_EQ(lock.TakenOverFrom(), "");
    EXPECT_THAT(MessageOf([&] { FolderLock second(folder_); }),
                AllOf(HasSubstr(folder_.string() + ": another run writes there (" + me),
                      HasSubstr(" since 20")));
  }
  EXPECT_TRUE(fs::is_empty(folder_)) << "and is gone with its run";
  const FolderLock again(folder_);
}

TEST_F(RunFolderTest, AFolderThatWasMadeForNoResultIsRemoved) {
  Touch("mine/file");
  for (const char* name : {"new", "mine"}) FolderLock lock(folder_ / name);
  EXPECT_FALSE(IsThere("new"));
  EXPECT_TRUE(IsThere("mine/file"));
  {
    const FolderLock lock(folder_ / "new");
    RunFolder(lock).Finish();
  }
  EXPECT_TRUE(IsThere("new/lighting.jsonl"));
}

TEST_F(RunFolderTest, ARunWithoutAFrameKeepsTheEarlierOnesResults) {
  const char* const results[] = {
      "lighting.jsonl", "events.jsonl", "report.html", "composite.mp4", "composite/000000.png"};
  for (const char* name : results) Touch(name);
  const FolderLock lock(folder_);
  {
    RunFolder folder(lock);
    EXPECT_FALSE(folder.HadUnfinished());
    folder.AddEvent("{}");
  }
  for (const char* name : results) EXPECT_EQ(ContentOf(folder_ / name), "x") << name;
  for (const char* name : {"lighting", "plan", "events"}) {
    EXPECT_FALSE(IsThere(std::string(name) + ".jsonl.partial"));
  }
}

// It holds no longer than its process, however that ends.
TEST_F(RunFolderTest, TheLockOfADeadRunIsTakenOver) {
  const pid_t child = fork();
  if (child == 0) {
    const FolderLock lock(folder_);
    _exit(0);  // As killed: nothing is tidied up.
  }
  int status = -1;
  waitpid(child, &status, 0);
  ASSERT_EQ(status, 0);
  ASSERT_FALSE(fs::is_empty(folder_));
  const FolderLock lock(folder_);
  EXPECT_THAT(lock.TakenOverFrom(), HasSubstr("process " + std::to_string(child) + " on "));
}

// The names are a run's, but anyone's pictures may have them.
TEST_F(RunFolderTest, RefusesAFolderOfSomethingElse) {
  for (const char* name : {"composite/000123.png", "mask/000777.exr", "report.html"}) {
    fs::create_directory(folder_ / "mine");
    Touch(std::string("mine/") + name);
    EXPECT_THAT(MessageOf([&] { FolderLock lock(folder_ / "mine"); }),
                HasSubstr(std::string("mine: holds ") + name + ", but not the lighting.jsonl"));
    EXPECT_TRUE(IsThere(std::string("mine/") + name));
    EXPECT_FALSE(IsThere("mine/.pleinair.lock"));
    for (const char* log : {"mine/lighting.jsonl", "mine/lighting.jsonl.partial"}) {
      Touch(log);
      EXPECT_EQ(MessageOf([&] { FolderLock lock(folder_ / "mine"); }), "accepted");
      fs::remove(folder_ / log);
    }
    fs::remove_all(folder_ / "mine");
  }
  Touch("mine/composite/first.png");
  EXPECT_EQ(MessageOf([&] { FolderLock lock(folder_ / "mine"); }), "accepted");
}

TEST_F(RunFolderTest, RemovesWhatKilledRunsLeftAndNothingElse) {
  const char* const gone[] = {"composite/.000000.exr.4711.0.part",
                              "composite/000000.exr",
                              "mask/.000012.png.4711.31.part",
                              "environment/.000001_without_sun.exr.1.2.part",
                              "composite.partial.mp4",
                              "lighting.jsonl.partial",
                              "plan.jsonl.partial",
                              "report.html.partial",
                              ".report.html.4711.1.part",
                              "score.json"};
  const char* const kept[] = {"composite/.mine.part",
                              "composite/mine.exr",
                              ".000000.exr.part",
                              "000000.exr",
                              "mine.partial",
                              "frames/.000000.exr.1.0.part"};
  for (const char* name : gone) Touch(name);
  for (const char* name : kept) Touch(name);
  const FolderLock lock(folder_);
  RunFolder folder(lock);
  EXPECT_TRUE(folder.HadUnfinished());
  EXPECT_TRUE(IsThere("composite/000000.exr")) << "an earlier run's, until there is a frame";
  folder.Begin();
  // The logs of the new run have their working names until they are complete.
  for (const char* name : gone) {
    const bool is_new = std::string(name).ends_with("jsonl.partial");
    EXPECT_EQ(IsThere(name), is_new) << name;
  }
  for (const char* name : kept) EXPECT_TRUE(IsThere(name)) << name;
  EXPECT_FALSE(IsThere("mask")) << "nothing else was in it";
  folder.AddFrame("{}", "{}");
  folder.Finish();
  EXPECT_FALSE(IsThere("lighting.jsonl.partial"));
  EXPECT_TRUE(IsThere("lighting.jsonl"));
}

// Another one fails before its first frame; a third one can still replace what was left.
TEST_F(RunFolderTest, WhatAKilledRunLeftStaysARuns) {
  for (const char* name : {"composite/000000.png", "lighting.jsonl.partial"}) Touch(name);
  {
    const FolderLock lock(folder_);
    RunFolder folder(lock);
  }
  EXPECT_TRUE(IsThere("composite/000000.png"));
  const FolderLock lock(folder_);
  RunFolder(lock).Finish();
  EXPECT_FALSE(IsThere("composite/000000.png"));
  EXPECT_FALSE(IsThere("lighting.jsonl.partial"));
}

TEST_F(RunFolderTest, EventsAreThereFromTheFirstOneOnAndHaveTheirNameWhenComplete) {
  for (const char* name : {"events.jsonl", "lighting.jsonl"}) Touch(name);
  const FolderLock lock(folder_);
  RunFolder(lock).Finish();
  EXPECT_FALSE(IsThere("events.jsonl")) << "an earlier run's, and this one had none";
  EXPECT_FALSE(IsThere("events.jsonl.partial"));
  RunFolder folder(lock);
  folder.AddEvent(R"({"event":"started"})");
  folder.AddEvent(R"({"event":"ended"})");
  const auto content = [&](const std::string& name) {
    std::stringstream text;
    text << std::ifstream(folder_ / name).rdbuf();
    return text.str();
  };
  const std::string lines = "{\"event\":\"started\"}\n{\"event\":\"ended\"}\n";
  EXPECT_EQ(content("events.jsonl.partial"), lines) << "each at once";
  EXPECT_FALSE(IsThere("events.jsonl"));
  folder.Finish();
  EXPECT_EQ(content("events.jsonl"), lines);
  EXPECT_FALSE(IsThere("events.jsonl.partial"));
}

TEST_F(RunFolderTest, ItsLogsHaveAllOfAFrameWhereTheDiskIsFull) {
  const std::string line = R"({"frame":0})";
  const FolderLock lock(folder_);
  RunFolder folder(lock);
  folder.AddFrame(line, line);
  const auto refusal = [&](const std::string& lighting, const std::string& plan) {
    const FileSizeLimit limit(3 * line.size());
    return MessageOf([&] { folder.AddFrame(lighting, plan); });
  };
  const std::string longer(3 * line.size(), 'x');
  EXPECT_THAT(refusal(longer, line), HasSubstr("lighting.jsonl.partial: cannot be written: "));
  EXPECT_THAT(refusal(line, longer), HasSubstr("plan.jsonl.partial: cannot be written: "));
  folder.AddFrame(line, line);
  folder.Finish();
  for (const char* name : {"lighting.jsonl", "plan.jsonl"}) {
    EXPECT_EQ(ContentOf(folder_ / name), line + "\n" + line + "\n") << name;
  }
}

TEST_F(RunFolderTest, ReplacesRegularFilesAlone) {
  fs::create_directory(folder_ / "out");
  Write("out/plan.jsonl", "of an earlier run");
  ASSERT_EQ(mkfifo((folder_ / "out/report.html").c_str(), 0600), 0);
  EXPECT_THAT(MessageOf([&] { FolderLock lock(folder_ / "out"); }),
              HasSubstr("out/report.html: cannot be written: expected a regular file there"));
  EXPECT_TRUE(fs::is_fifo(folder_ / "out/report.html"));
  EXPECT_TRUE(IsThere("out/plan.jsonl")) << "refused before anything is removed";
  fs::remove(folder_ / "out/report.html");
  Write("out/mask", "mine");
  EXPECT_THAT(MessageOf([&] { FolderLock lock(folder_ / "out"); }),
              HasSubstr("out/mask: expected a folder for pictures"));
  Write("file", "mine");
  EXPECT_THAT(MessageOf([&] { FolderLock lock(folder_ / "file"); }),
              HasSubstr("file: expected a folder"));
}

}  // namespace
}  // namespace pleinair::run_folder_test
