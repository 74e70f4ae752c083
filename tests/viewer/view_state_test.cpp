// What the window remembers, written and read.
#include "apps/viewer/view_state.h"

#include <cstdlib>
#include <optional>
#include <string>

#include <gmock/gmock.h>

#include "tests/scene/temporary_folder.h"

namespace pleinair::view_state_test {
namespace {

// A variable of the environment, for the time of a test.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    Set(value);
  }
  ~Variable() { Set(old_ ? old_->c_str() : nullptr); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  void Set(const char* value) {
    if (value != nullptr) {
      setenv(name_, value, 1);
    } else {
      unsetenv(name_);
    }
  }
  const char* name_;
  std::optional<std::string> old_;
};

ViewState Unusual() {
  ViewState state;
  state.window = {1366, 768, true};
  state.open_panels = {"Events", "Settings"};
  state.overlay = "normals";
  state.exposure_stops = -1.0 / 3.0;
  state.frames_per_second = 24.5;
  state.loops = false;
  return state;
}

TEST(ViewState, IsReadAsItWasWritten) {
  const TemporaryFolder folder;
  // The folder is made where there is none.
  WriteViewState(Unusual(), folder / "config/pleinair");
  const std::optional<ViewState> read = ReadViewState(folder / "config/pleinair");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->window.width, 1366);
  EXPECT_EQ(read->window.height, 768);
  EXPECT_TRUE(read->window.is_maximised);
  EXPECT_THAT(read->open_panels, testing::ElementsAre("Events", "Settings"));
  EXPECT_EQ(read->overlay, "normals");
  EXPECT_EQ(read->exposure_stops, -1.0 / 3.0);
  EXPECT_EQ(read->frames_per_second, 24.5);
  EXPECT_FALSE(read->loops);
}

TEST(ViewState, AFileThatDoesNotHoldIsAsNone) {
  const TemporaryFolder folder;
  EXPECT_FALSE(ReadViewState(folder.Path()));
  WriteViewState(Unusual(), folder.Path());
  const std::string whole = ContentOf(folder / "view.json");
  // Each part of it that is cut off.
  for (std::size_t bytes = 0; bytes + 2 < whole.size(); ++bytes) {
    folder.Write("view.json", whole.substr(0, bytes));
    EXPECT_FALSE(ReadViewState(folder.Path())) << whole.substr(0, bytes);
  }
  for (const char* text : {"[]", "7", "{\"window\": {\"width\": \"wide\"}}", "\xff\xfe"}) {
    folder.Write("view.json", text);
    EXPECT_FALSE(ReadViewState(folder.Path())) << text;
  }
}

TEST(ViewState, NumbersOfAnotherTimeAreBroughtIntoRange) {
  const TemporaryFolder folder;
  ViewState state = Unusual();
  state.window = {1, 1'000'000, false};
  state.frames_per_second = 0.0;
  state.exposure_stops = 1e9;
  WriteViewState(state, folder.Path());
  const std::optional<ViewState> read = ReadViewState(folder.Path());
  ASSERT_TRUE(read);
  EXPECT_GE(read->window.width, 320);
  EXPECT_LE(read->window.height, 16384);
  EXPECT_GT(read->frames_per_second, 0.0);
  EXPECT_LE(read->exposure_stops, 6.0);
}

TEST(ViewState, StandsInTheUsersConfiguration) {
  {
    const Variable config("XDG_CONFIG_HOME", "/somewhere/config");
    EXPECT_EQ(ViewStateFolder(), "/somewhere/config/pleinair");
  }
  const Variable home("HOME", "/home/someone");
  for (const char* unset : {static_cast<const char*>(nullptr), ""}) {
    const Variable config("XDG_CONFIG_HOME", unset);
    EXPECT_EQ(ViewStateFolder(), "/home/someone/.config/pleinair");
  }
  const Variable config("XDG_CONFIG_HOME", nullptr);
  const Variable homeless("HOME", nullptr);
  EXPECT_EQ(ViewStateFolder(), "");
}

TEST(ViewState, AFolderThatCannotBeMadeIsOneLine) {
  const TemporaryFolder folder;
  folder.Write("file", "in the way");
  const std::string message =
      MessageOf([&] { WriteViewState(ViewState{}, folder / "file/below"); });
  EXPECT_FALSE(message.empty());
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

}  // namespace
}  // namespace pleinair::view_state_test
