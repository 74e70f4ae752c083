// `pleinair view` as a person uses it: a display, keys and a pointer.
//
// Nothing here depends on how fast the machine is: each step waits for what it does.
#pragma once

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <glm/vec2.hpp>

#include "tests/scene/shell.h"
#include "tests/scene/temporary_folder.h"
#include "tests/viewer/background_program.h"

namespace pleinair {

inline const std::filesystem::path kCourtyard =
    std::filesystem::path(PLEINAIR_SOURCE_DIR) / "datasets/samples/courtyard";

inline bool IsInstalled(const std::string& program) {
  return Shell("command -v " + program).exit_code == 0;
}

// A display without a screen, under a number that is free.
class Display {
 public:
  explicit Display(const std::filesystem::path& folder, const std::string& size = "1366x900")
      : number_file_(folder / "display"),
        server_("Xvfb -displayfd 3 -screen 0 " + size + "x24 -noreset -r -nolisten tcp 3>" +
                number_file_.string() + " 2>/dev/null") {
    if (!Await([this] { return ContentOf(number_file_).ends_with('\n'); })) {
      throw std::runtime_error("Xvfb does not start");
    }
    name_ = ":" + ContentOf(number_file_);
    name_.pop_back();
  }
  ~Display() {
    server_.Terminate();
    server_.ExitCode();
  }
  const std::string& Name() const { return name_; }

 private:
  std::filesystem::path number_file_;
  BackgroundProgram server_;
  std::string name_;
};

// A window on the display.
class View {
 public:
  // `command`: of a program that opens it.
  View(const Display& display, const std::string& command, const std::filesystem::path& log)
      : display_(display),
        program_("env -u WAYLAND_DISPLAY DISPLAY=" + display.Name() + " " + command + " >" +
                 log.string() + " 2>&1") {
    EXPECT_TRUE(Await([this] {
      return !(window_ = Line("search --onlyvisible --name '^pleinair'")).empty() ||
             program_.HasEnded();
    }));
    Line("windowfocus " + window_);
  }

  std::string Title() const { return Line("getwindowname " + window_); }
  // Of a frame, with or without edits that are not saved; of a layout, which a pointer waits for:
  // it means what is shown.
  bool AwaitTitle(const std::string& ending) {
    return Await([&] { return Title().ends_with(ending) || program_.HasEnded(); }) &&
           !program_.HasEnded();
  }
  // "Right", "ctrl+s", several after another.
  void Press(const std::string& keys) { Line("key --delay 5 " + keys); }
  // One after the other, as Press; also the same key again and again, on however slow a machine:
  // the window takes two presses of a key in one millisecond of the display for one.
  void PressEach(const std::string& keys) {
    std::istringstream each(keys);
    for (std::string key; each >> key;) Line("key " + key);
  }
  // As a finger does: until it is seen what it does. The display repeats no keys.
  ::testing::AssertionResult Hold(const std::string& key, const std::string& title) {
    Line("keydown " + key);
    const bool is_reached = AwaitTitle(title);
    Line("keyup " + key);
    return is_reached ? ::testing::AssertionSuccess()
                      : ::testing::AssertionFailure() << key << ": " << Title();
  }
  void Move(int x, int y) { Line(fmt::format("mousemove --window {} {} {}", window_, x, y)); }
  void Do(const std::string& action) { Line(action); }
  std::optional<int> ExitCode() { return program_.ExitCode(); }
  bool HasEnded() { return program_.HasEnded(); }
  std::string Line(const std::string& action) const {
    std::string output =
        StandardOutputOf("DISPLAY=" + display_.Name() + " xdotool " + action + " 2>/dev/null")
            .output;
    if (output.ends_with('\n')) output.pop_back();
    return output;
  }

 private:
  const Display& display_;
  std::string window_;
  BackgroundProgram program_;
};

// The site is prepared once for all tests, coarsely.
class WindowTest : public testing::Test {
 protected:
  // 960 points wide, without panels: the courtyard's 480x360 pixels in double size, below a menu of
  // 21 points.
  static constexpr int kMenuHeight = 21;
  static constexpr int kPointsAPixel = 2;

  static void SetUpTestSuite() {
    if (!IsInstalled("Xvfb") || !IsInstalled("xdotool")) return;
    shared_ = std::make_unique<TemporaryFolder>();
    display_ = std::make_unique<Display>(shared_->Path());
    const Ended prepared =
        Shell(std::string(PLEINAIR_PROGRAM) + " prepare " + kCourtyard.string() + Coarse());
    ASSERT_EQ(prepared.exit_code, 0) << prepared.output;
  }
  static void TearDownTestSuite() {
    display_.reset();
    shared_.reset();
  }

  void SetUp() override {
    if (!shared_) GTEST_SKIP() << "Xvfb or xdotool is not installed";
    CopyCourtyard(Site());
    WriteState("[]");
  }

  static std::string Coarse(const std::filesystem::path& cache = *shared_ / "cache") {
    return " --cache " + cache.string() + " --set prepare.patch_size_m=4 --set prepare.rays=16";
  }
  static std::string Settings() {
    return Coarse() +
           " --set light.samples=200 --set pipeline.view.receiver_block_px=16"
           " --set pipeline.object_light.gather.rays_per_receiver=32"
           " --set pipeline.influence.rays_per_receiver=16";
  }
  static void CopyCourtyard(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    for (const std::filesystem::directory_entry& entry :
         std::filesystem::directory_iterator(kCourtyard)) {
      if (entry.path().filename() == "truth") continue;
      std::filesystem::copy(
          entry.path(), folder / entry.path().filename(), std::filesystem::copy_options::recursive);
    }
  }

  std::filesystem::path Site() const { return folder_ / "yard"; }
  std::filesystem::path Out() const { return folder_ / "out"; }
  std::filesystem::path SiteFile() const { return Site() / "sequence.json"; }
  std::filesystem::path StateFile() const { return folder_ / "config/pleinair/view.json"; }
  std::string Log() const { return ContentOf(folder_ / "log"); }

  void WriteState(const std::string& panels) const {
    std::filesystem::create_directories(StateFile().parent_path());
    folder_.Write("config/pleinair/view.json",
                  R"({"window": {"width": 960, "height": 820, "maximised": false},
                      "open_panels": )" +
                      panels +
                      R"(, "overlay": "", "exposure_stops": 0, "frames_per_second": 10,
                      "loops": true})");
  }

  std::string Command(const std::string& arguments) const {
    return "XDG_CONFIG_HOME=" + (folder_ / "config").string() + " " + PLEINAIR_PROGRAM + " view " +
           arguments + " --out " + Out().string();
  }
  std::unique_ptr<View> Open(const std::string& command) const {
    return std::make_unique<View>(*display_, command, folder_ / "log");
  }
  std::unique_ptr<View> OpenSite(const std::string& arguments = {}) const {
    auto view = Open(Command(Site().string() + Settings() + arguments));
    EXPECT_TRUE(view->AwaitTitle("pleinair: yard frame 0")) << view->Title() << Log();
    return view;
  }

  // The place in the window that shows a pixel, and the pixel that a place shows.
  static glm::ivec2 PlaceOf(const glm::dvec2& pixel) {
    return glm::ivec2(double{kPointsAPixel} * (pixel + 0.5)) + glm::ivec2(0, kMenuHeight);
  }
  static glm::dvec2 PixelAt(const glm::ivec2& place) {
    return glm::dvec2(place - glm::ivec2(0, kMenuHeight)) / double{kPointsAPixel} - 0.5;
  }

  // Saves, and waits until the file is another one.
  ::testing::AssertionResult Save(View& view) const {
    const std::string before = ContentOf(SiteFile());
    view.Press("ctrl+s");
    if (!Await([&] { return ContentOf(SiteFile()) != before; })) {
      return ::testing::AssertionFailure() << "the site's file is as it was; " << view.Title();
    }
    return ::testing::AssertionSuccess();
  }

  inline static std::unique_ptr<TemporaryFolder> shared_;
  inline static std::unique_ptr<Display> display_;
  TemporaryFolder folder_;
};

}  // namespace pleinair
