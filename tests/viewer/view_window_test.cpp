// `pleinair view` as a person uses it: a display, keys and a pointer; what it leaves is what the
// commands give.
//
// Nothing here depends on how fast the machine is: each step waits for what it does.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <set>
#include <sstream>
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
#include "sunmodel/time_text.h"
#include "tests/viewer/view_window.h"

namespace pleinair::view_window_test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::HasSubstr;

// What is saved of the site's objects, and what the command makes of them.
class ViewWindow : public WindowTest {
 protected:
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

// It shows what is new when it is there again.
TEST_F(ViewWindow, GoesOnAfterItWasHidden) {
  const auto view = OpenSite();
  const std::string window = view->Line("search --onlyvisible --name '^pleinair'");
  view->Press("space");
  ASSERT_TRUE(Await([&] { return !view->Title().ends_with("frame 0"); }));
  view->Do("windowunmap --sync " + window);
  view->Do("windowmap --sync " + window);
  const std::string before = view->Title();
  EXPECT_TRUE(Await([&] { return view->Title() != before; }));
  view->Do("windowfocus --sync " + window);
  view->Press("space ctrl+q");
  EXPECT_EQ(view->ExitCode(), 0) << Log();
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

// A tracker's poses of a camera in the window: what is recorded has those that were used.
TEST_F(ViewWindow, ACameraFollowsPosesFromOutside) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers do not load behind the stand-in";
#endif
  const Json sequence = Json::parse(ContentOf(SiteFile()));
  const UtcTime start =
      ParseUtcTime(sequence["frames"][0]["time_utc"].get<std::string>()) - std::chrono::seconds(5);
  Json pose = sequence["camera"]["camera_from_world"];
  const double x_m = pose[0][3].get<double>();
  std::string lines;
  for (int i = 0; i < 3000; ++i) {
    pose[0][3] = x_m + 0.1 * std::sin(0.3 * i);
    const UtcTime time = start + i * std::chrono::milliseconds(100);
    lines += Json{{"time_utc", FormatUtcTime(time)}, {"camera_from_world", pose}}.dump() + "\n";
  }
  const fs::path poses = folder_.Write("poses.jsonl", lines);
  const auto view =
      Open(std::string(PLEINAIR_STAND_IN) + " " + kCourtyard.string() + " --loop 0 -- env " +
           Command("/dev/video90 --site " + Site().string() + Settings()) + " --poses " +
           poses.string() + " --exposure 0.01 --gain 100 --white-balance 5000 --rate 5");
  ASSERT_TRUE(Await([&] { return view->Title().find(" frame ") != std::string::npos; })) << Log();
  view->Press("ctrl+r");
  const auto recorded = [&]() -> std::string {
    if (!fs::exists(Out())) return {};
    for (const fs::directory_entry& entry : fs::directory_iterator(Out())) {
      return ContentOf(entry.path() / "frames.jsonl");
    }
    return {};
  };
  ASSERT_TRUE(Await([&] {
    const std::string frames = recorded();
    return std::count(frames.begin(), frames.end(), '\n') >= 3;
  })) << Log();
  view->Press("ctrl+q");
  EXPECT_EQ(view->ExitCode(), 0) << Log();
  std::set<double> places_m;
  std::istringstream frames(recorded());
  for (std::string line; std::getline(frames, line);) {
    const double place_m = Json::parse(line)["camera_from_world"][0][3].get<double>();
    EXPECT_LE(std::abs(place_m - x_m), 0.1 + 1e-9);
    places_m.insert(place_m);
  }
  EXPECT_GE(places_m.size(), 3u);
}

}  // namespace
}  // namespace pleinair::view_window_test
