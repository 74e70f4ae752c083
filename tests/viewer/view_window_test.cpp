// `pleinair view` as a person uses it: a display, keys and a pointer; what it leaves is what the
// commands give.
//
// Nothing here depends on how fast the machine is: each step waits for what it does.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <set>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "calib/lens.h"
#include "datasets/sequence.h"
#include "objects/object_placement.h"
#include "scene/image_io.h"
#include "scene/mesh_io.h"
#include "tests/scene/shell.h"
#include "tests/scene/temporary_folder.h"
#include "tests/viewer/background_program.h"

namespace pleinair::view_window_test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::HasSubstr;

const fs::path kCourtyard = fs::path(PLEINAIR_SOURCE_DIR) / "datasets/samples/courtyard";

bool IsInstalled(const std::string& program) {
  return Shell("command -v " + program).exit_code == 0;
}

// A display without a screen, under a number that is free.
class Display {
 public:
  explicit Display(const fs::path& folder, const std::string& size = "1366x900")
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
  fs::path number_file_;
  BackgroundProgram server_;
  std::string name_;
};

// A window on the display.
class View {
 public:
  // `command`: of a program that opens it.
  View(const Display& display, const std::string& command, const fs::path& log)
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
  // Of frame `frame`, with or without edits that are not saved.
  bool AwaitTitle(const std::string& ending) {
    return Await([&] { return Title().ends_with(ending) || program_.HasEnded(); }) &&
           !program_.HasEnded();
  }
  // "Right", "ctrl+s", several after another.
  void Press(const std::string& keys) { Line("key --delay 5 " + keys); }
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
class ViewWindow : public testing::Test {
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

  static std::string Coarse(const fs::path& cache = *shared_ / "cache") {
    return " --cache " + cache.string() + " --set prepare.patch_size_m=4 --set prepare.rays=16";
  }
  static std::string Settings() {
    return Coarse() +
           " --set light.samples=200 --set pipeline.view.receiver_block_px=16"
           " --set pipeline.object_light.gather.rays_per_receiver=32"
           " --set pipeline.influence.rays_per_receiver=16";
  }
  static void CopyCourtyard(const fs::path& folder) {
    fs::create_directories(folder);
    for (const fs::directory_entry& entry : fs::directory_iterator(kCourtyard)) {
      if (entry.path().filename() == "truth") continue;
      fs::copy(entry.path(), folder / entry.path().filename(), fs::copy_options::recursive);
    }
  }

  fs::path Site() const { return folder_ / "yard"; }
  fs::path Out() const { return folder_ / "out"; }
  fs::path SiteFile() const { return Site() / "sequence.json"; }
  fs::path StateFile() const { return folder_ / "config/pleinair/view.json"; }
  std::string Log() const { return ContentOf(folder_ / "log"); }

  void WriteState(const std::string& panels) const {
    fs::create_directories(StateFile().parent_path());
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
  std::unique_ptr<View> OpenSite() const {
    auto view = Open(Command(Site().string() + Settings()));
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
  std::vector<VirtualObjectEntry> Saved() const { return ReadSequence(Site()).virtual_objects; }
  glm::dmat4 SavedPose() const { return Saved().at(0).world_from_object; }

  // What `pleinair site place` makes of the site's file as it is now.
  std::string Placed(const std::string& arguments) const {
    const fs::path copy = folder_ / "commanded";
    fs::remove_all(copy);
    fs::copy(Site(), copy, fs::copy_options::recursive);
    const Ended placed = Shell(std::string(PLEINAIR_PROGRAM) + " site place " + copy.string() +
                               " --object 0 " + arguments);
    EXPECT_EQ(placed.exit_code, 0) << placed.output;
    return ContentOf(copy / "sequence.json");
  }
  glm::dmat4 PlacedPose(const std::string& arguments) const {
    Placed(arguments);
    return ReadSequence(folder_ / "commanded").virtual_objects.at(0).world_from_object;
  }
  static std::string Pixel(const glm::dvec2& pixel) {
    return fmt::format("--pixel {},{}", pixel.x, pixel.y);
  }
  static double Distance(const glm::dmat4& a, const glm::dmat4& b) {
    double most = 0.0;
    for (int c = 0; c < 4; ++c) most = std::max(most, glm::distance(a[c], b[c]));
    return most;
  }
  glm::dvec2 FootPx() const {
    const PlaceableObject object(LoadMesh(Site() / "object.obj").mesh);
    const Camera camera = ReadSequence(Site()).CameraOfFrame(0);
    const glm::dvec3 foot = FootOf(object, SavedPose());
    return ProjectToPixel(camera.intrinsics,
                          glm::dvec3(camera.camera_from_world * glm::dvec4(foot, 1.0)))
        .value();
  }

  inline static std::unique_ptr<TemporaryFolder> shared_;
  inline static std::unique_ptr<Display> display_;
  TemporaryFolder folder_;
};

TEST_F(ViewWindow, GoesThroughFramesByKeys) {
  const auto view = OpenSite();
  for (const auto& [key, frame] : {std::pair{"Right", 1},
                                   std::pair{"Right", 2},
                                   std::pair{"Left", 1},
                                   std::pair{"End", 5},
                                   std::pair{"Right", 0},
                                   std::pair{"Left", 5},
                                   std::pair{"Home", 0}}) {
    EXPECT_TRUE(view->Hold(key, fmt::format("frame {}", frame)));
  }
  view->Do("keydown Tab");  // Selects the one object again, and takes no keys away.
  EXPECT_TRUE(view->Hold("Right", "frame 1"));
  view->Do("keyup Tab");
  EXPECT_TRUE(view->Hold("Home", "frame 0"));
  view->Press("l End");  // It does not loop: the last frame stays.
  ASSERT_TRUE(view->AwaitTitle("frame 5"));
  view->Press("Right Left");
  EXPECT_TRUE(view->AwaitTitle("frame 4"));
  view->Press("l space");
  std::set<std::string> titles;
  EXPECT_TRUE(Await([&] { return titles.insert(view->Title()), titles.size() == 6; }));
  view->Press("space ctrl+q");
  EXPECT_EQ(view->ExitCode(), 0) << Log();
}

// The keys that move frames and objects move through panels, when they are asked to.
TEST_F(ViewWindow, PanelsHaveTheKeysFromF10ToEscape) {
  WriteState(R"(["Light", "Objects"])");
  const auto view = OpenSite();
  ASSERT_TRUE(view->Hold("Right", "frame 1"));
  view->Press("F10 End Home Left q");
  view->Press("Escape");
  EXPECT_TRUE(view->Hold("Right", "frame 2"));
  view->Press("ctrl+q");
  EXPECT_EQ(view->ExitCode(), 0) << Log();
}

TEST_F(ViewWindow, EditsByKeysAreWhatTheCommandWrites) {
  const auto view = OpenSite();
  const glm::ivec2 place = PlaceOf({200.0, 300.0});
  view->Move(place.x, place.y);
  const std::string put = Placed(Pixel(PixelAt(place)));
  view->Press("p");
  ASSERT_TRUE(view->AwaitTitle("frame 0 *"));
  ASSERT_TRUE(Save(*view));
  EXPECT_TRUE(view->AwaitTitle("frame 0"));
  EXPECT_EQ(ContentOf(SiteFile()), put);

  for (const auto& [keys, arguments] : {std::pair{"q", "--turn-deg 15"},
                                        std::pair{"e e", "--turn-deg -30"},
                                        std::pair{"r", "--lift 0.05"},
                                        std::pair{"shift+f", "--lift -0.005"},
                                        std::pair{"shift+q", "--turn-deg 1"},
                                        std::pair{"equal", "--scale 1.1"},
                                        std::pair{"minus minus", "--scale 0.8264462809917356"}}) {
    SCOPED_TRACE(keys);
    const glm::dmat4 expected = PlacedPose(arguments);
    view->Press(keys);
    ASSERT_TRUE(Save(*view));
    EXPECT_LT(Distance(SavedPose(), expected), 1e-12);
  }
  view->Press("p");
  ASSERT_TRUE(Save(*view));
  for (const auto& [keys, step] : {std::pair{"d", glm::dvec2(1.0, 0.0)},
                                   std::pair{"shift+a", glm::dvec2(-10.0, 0.0)},
                                   std::pair{"w w", glm::dvec2(0.0, -2.0)},
                                   std::pair{"shift+s", glm::dvec2(0.0, 10.0)}}) {
    SCOPED_TRACE(keys);
    const glm::dvec2 before = FootPx();
    view->Press(keys);
    ASSERT_TRUE(Save(*view));
    EXPECT_LT(glm::distance(FootPx(), before + step), 0.02 * glm::length(step) + 0.02);
  }
  view->Press("ctrl+q");
  EXPECT_EQ(view->ExitCode(), 0) << Log();
}

TEST_F(ViewWindow, ObjectsAreDuplicatedDeletedAndBroughtBack) {
  const auto view = OpenSite();
  const auto count = [&](const std::string& keys) {
    view->Press(keys);
    EXPECT_TRUE(Save(*view)) << keys;
    return Saved().size();
  };
  EXPECT_EQ(count("ctrl+d"), 2u);
  EXPECT_EQ(count("ctrl+z"), 1u);
  EXPECT_EQ(count("ctrl+y"), 2u);
  // The second one is selected; Tab goes on to the first.
  const glm::dmat4 first = Saved()[0].world_from_object;
  const glm::dmat4 second = Saved()[1].world_from_object;
  EXPECT_EQ(count("Tab q"), 2u);
  EXPECT_NE(Saved()[0].world_from_object, first);
  EXPECT_EQ(Saved()[1].world_from_object, second);
  EXPECT_EQ(count("Delete"), 1u);
  EXPECT_EQ(Saved()[0].world_from_object, second);
  EXPECT_EQ(count("Delete"), 0u);
  EXPECT_EQ(count("ctrl+z ctrl+z ctrl+z"), 2u);
  EXPECT_EQ(Saved()[0].world_from_object, first);
  EXPECT_EQ(count("ctrl+shift+z"), 2u);
  EXPECT_NE(Saved()[0].world_from_object, first);
  view->Press("ctrl+q");
  EXPECT_EQ(view->ExitCode(), 0) << Log();
}

TEST_F(ViewWindow, DraggingPutsTheObjectWhereItIsLetGo) {
  const auto view = OpenSite();
  const glm::ivec2 from = PlaceOf({200.0, 300.0});
  const glm::ivec2 to = PlaceOf({300.0, 330.0});
  view->Move(from.x, from.y);
  view->Press("p");
  ASSERT_TRUE(view->AwaitTitle("frame 0 *"));
  ASSERT_TRUE(Save(*view));
  ASSERT_TRUE(view->AwaitTitle("frame 0"));
  const glm::dmat4 expected = PlacedPose(Pixel(PixelAt(to)));
  const std::string start = ContentOf(SiteFile());
  // All at once: no picture is drawn in between on a slow machine.
  const glm::ivec2 grip = from - glm::ivec2(0, 12);
  view->Do(
      fmt::format("mousemove --window {0} {1} {2} mousedown 1 mousemove --window {0} {3} {4} "
                  "mousemove --window {0} {5} {6} mouseup 1",
                  view->Line("getwindowfocus"),
                  grip.x,
                  grip.y,
                  (from.x + to.x) / 2,
                  (from.y + to.y) / 2,
                  to.x,
                  to.y));
  ASSERT_TRUE(view->AwaitTitle("frame 0 *"));
  ASSERT_TRUE(Save(*view));
  // The turn about the axis is carried over the way of two steps in place of one.
  EXPECT_LT(Distance(SavedPose(), expected), 1e-9);
  view->Press("ctrl+z");  // It was one edit.
  ASSERT_TRUE(Save(*view));
  EXPECT_EQ(ContentOf(SiteFile()), start);
  view->Press("ctrl+q");
  EXPECT_EQ(view->ExitCode(), 0) << Log();
}

TEST_F(ViewWindow, ASnapshotRunsAsItWasShown) {
  const auto view = OpenSite();
  view->Press("F12");
  const fs::path snapshot = Out() / "snapshot-20050621-075200";
  ASSERT_TRUE(Await([&] { return fs::exists(snapshot); }));
  view->Press("ctrl+q");
  EXPECT_EQ(view->ExitCode(), 0) << Log();
  std::string run = ContentOf(snapshot / "run.txt");
  ASSERT_TRUE(run.starts_with("pleinair ")) << run;
  run = PLEINAIR_PROGRAM + run.substr(std::string("pleinair").size());
  run.pop_back();
  const Ended again =
      Shell("cd " + snapshot.string() + " && " + run + " --cache " + (*shared_ / "cache").string());
  ASSERT_EQ(again.exit_code, 0) << again.output;
  EXPECT_TRUE(ReadDisplayImage(snapshot / "out/composite/000000.png").pixels ==
              ReadDisplayImage(snapshot / "composite.png").pixels);
}

TEST_F(ViewWindow, AnEditStaysUntilItCanBeSaved) {
  const auto view = OpenSite();
  const std::string whole = ContentOf(SiteFile());
  const glm::dmat4 expected = PlacedPose("--turn-deg 15");
  const std::string damaged = whole.substr(0, whole.size() / 2);
  folder_.Write("yard/sequence.json", damaged);
  view->Press("q");
  ASSERT_TRUE(view->AwaitTitle("frame 0 *"));
  view->Press("ctrl+s");
  ASSERT_TRUE(Await([&] { return Log().find("sequence.json") != std::string::npos; })) << Log();
  EXPECT_EQ(ContentOf(SiteFile()), damaged);
  EXPECT_TRUE(view->Title().ends_with("frame 0 *")) << view->Title();
  folder_.Write("yard/sequence.json", whole);
  ASSERT_TRUE(Save(*view));
  EXPECT_LT(Distance(SavedPose(), expected), 1e-12);
  view->Press("ctrl+q");
  EXPECT_EQ(view->ExitCode(), 0) << Log();
}

TEST_F(ViewWindow, OpensAsItWasLeft) {
  {
    const auto view = OpenSite();
    // The second and the last panel, an overlay, a third of a stop, no loop.
    view->Press("F3 F9 alt+4 bracketright l");
    view->Do("search --onlyvisible --name '^pleinair' windowsize --sync 1000 700");
    view->Press("ctrl+q");
    EXPECT_EQ(view->ExitCode(), 0) << Log();
  }
  const std::string left = ContentOf(StateFile());
  const Json state = Json::parse(left);
  EXPECT_EQ(state["open_panels"], Json({"Objects", "Settings"}));
  EXPECT_EQ(state["overlay"], "normals");
  EXPECT_NEAR(state["exposure_stops"].get<double>(), 1.0 / 3.0, 1e-12);
  EXPECT_EQ(state["loops"], false);
  EXPECT_EQ(state["window"]["width"], 1000);
  EXPECT_EQ(state["window"]["height"], 700);
  fs::remove(StateFile().parent_path() / "view-layout.ini");
  {
    const auto view = OpenSite();
    fs::remove(StateFile());
    view->Press("ctrl+q");
    EXPECT_EQ(view->ExitCode(), 0) << Log();
  }
  EXPECT_EQ(ContentOf(StateFile()), left);
}

TEST_F(ViewWindow, ClosesWhileASiteIsPrepared) {
  const auto view = Open(Command(Site().string() + Coarse(folder_ / "cache") + " --as-new"));
  ASSERT_EQ(view->Title(), "pleinair");  // Before the first frame.
  const std::string state = ContentOf(StateFile());
  view->Press("ctrl+q");
  EXPECT_EQ(view->ExitCode(), 0) << Log();
  EXPECT_EQ(ContentOf(StateFile()), state);  // As new: neither read nor written.
}

TEST_F(ViewWindow, ASequenceThatIsMissingIsOneLine) {
  const auto view = Open(Command((folder_ / "none").string()));
  EXPECT_EQ(view->ExitCode(), 2);
  const std::string log = Log();
  EXPECT_THAT(log, HasSubstr("none"));
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1) << log;
}

TEST_F(ViewWindow, WithoutADisplayIsOneLine) {
  const Ended ended = Shell("env -u DISPLAY -u WAYLAND_DISPLAY " + Command(Site().string()));
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.output, HasSubstr("no display"));
  EXPECT_EQ(std::count(ended.output.begin(), ended.output.end(), '\n'), 1) << ended.output;
}

TEST_F(ViewWindow, ACameraIsFrozenRecordedAndLeft) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers do not load behind the stand-in";
#endif
  const auto view =
      Open(std::string(PLEINAIR_STAND_IN) + " " + kCourtyard.string() + " --loop 0 -- env " +
           Command("/dev/video90 --site " + Site().string() + Settings()) +
           " --exposure 0.01 --gain 100 --white-balance 5000 --rate 10");
  const auto shown = [&] { return view->Title(); };
  ASSERT_TRUE(Await([&] { return shown().find(" frame ") != std::string::npos; })) << Log();
  const std::string first = shown();
  EXPECT_TRUE(Await([&] { return shown() != first; }));
  view->Press("ctrl+r");
  const auto recorded = [&]() -> fs::path {
    if (!fs::exists(Out())) return {};
    for (const fs::directory_entry& entry : fs::directory_iterator(Out())) return entry.path();
    return {};
  };
  ASSERT_TRUE(Await([&] { return !recorded().empty(); }));
  const auto frames = [&] {
    const std::string lines = ContentOf(recorded() / "frames.jsonl");
    return std::count(lines.begin(), lines.end(), '\n');
  };
  ASSERT_TRUE(Await([&] { return frames() >= 2; }));
  view->Press("ctrl+r");
  // Frozen: an edit is seen in the picture that stays.
  view->Press("space q");
  ASSERT_TRUE(view->AwaitTitle(" *"));
  ASSERT_TRUE(Save(*view));
  const std::string frozen = shown();
  view->Press("space");
  EXPECT_TRUE(Await([&] { return shown() != frozen; }));
  view->Press("ctrl+q");
  EXPECT_EQ(view->ExitCode(), 0) << Log();

  const Ended run = Shell(std::string(PLEINAIR_PROGRAM) + " run " + recorded().string() +
                          Settings() + " --frames-limit 2 --out " + (folder_ / "run").string());
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_TRUE(fs::exists(folder_ / "run/composite/000001.png")) << run.output;
}

}  // namespace
}  // namespace pleinair::view_window_test
