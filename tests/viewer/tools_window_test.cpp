// The tools of `pleinair view` by keys and pointer: what they save is what the commands make of the
// same picks.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "calib/calibration_board.h"
#include "calib/camera_pose.h"
#include "calib/colour_chart.h"
#include "calib/lens.h"
#include "calib/response.h"
#include "datasets/sequence.h"
#include "datasets/site_file.h"
#include "objects/surface_point.h"
#include "scene/image_io.h"
#include "scene/lat_long.h"
#include "scene/mesh_io.h"
#include "sunmodel/angles.h"
#include "tests/calib/drawn_boards.h"
#include "tests/viewer/view_window.h"

namespace pleinair::tools_window_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ToolsWindow : public WindowTest {
 protected:
  // The recording's frame 3 as an 8-bit camera sees it at several exposures, a frame each.
  static constexpr std::array kExposures{0.004, 0.008, 0.016};
  using Painter = std::function<void(RgbImage&)>;
  void WriteBracket(const ResponseCurve& response, const Painter& paint = {}) const {
    RgbImage light = ReadRadianceImage(kCourtyard / "frames/000003.exr");
    if (paint) paint(light);
    EditSiteFile(Site(), [&](nlohmann::ordered_json& json) {
      nlohmann::ordered_json frames = nlohmann::ordered_json::array();
      for (std::size_t i = 0; i < kExposures.size(); ++i) {
        const std::string name = fmt::format("frames/bracket{}.png", i);
        WritePng(Site() / name, CodesFromRadiance(light, response, kExposures[i]));
        frames.push_back({{"image_ldr", name},
                          {"time_utc", fmt::format("2005-06-21T09:50:0{}Z", i)},
                          {"exposure", kExposures[i]}});
      }
      json["frames"] = frames;
    });
  }
  // Another curve than sRGB's, and another one for each channel.
  static ResponseCurve OtherResponse() {
    ResponseTable table{};
    for (std::size_t c = 0; c < table.size(); ++c) {
      for (std::size_t code = 0; code < table[c].size(); ++code) {
        table[c][code] = static_cast<float>(
            std::pow(static_cast<double>(code) / 255.0, 1.7 + 0.1 * static_cast<double>(c)));
      }
    }
    return ResponseCurve::FromTable(table);
  }
  std::string Exposures() const {
    return fmt::format("{},{},{}", kExposures[0], kExposures[1], kExposures[2]);
  }
  std::string Pictures() const {
    std::string names;
    for (std::size_t i = 0; i < kExposures.size(); ++i) {
      names += " " + (Site() / fmt::format("frames/bracket{}.png", i)).string();
    }
    return names;
  }
  // A copy of the site as it is now, for a command to change.
  fs::path Copy() const {
    fs::path copy = folder_ / "commanded";
    fs::remove_all(copy);
    fs::copy(Site(), copy, fs::copy_options::recursive);
    return copy;
  }
  static void Calibrate(const std::string& arguments) {
    const Ended ended = Shell(std::string(PLEINAIR_PROGRAM) + " calibrate " + arguments);
    EXPECT_EQ(ended.exit_code, 0) << ended.output;
  }
  static std::string ResponseIn(const fs::path& site) {
    return ContentOf(site / "camera_response.json");
  }
  void End(View& view) const {
    view.PressEach("ctrl+q");
    EXPECT_EQ(view.ExitCode(), 0) << Log();
  }

  // Where the mesh has a surface of the picture in the survey map.
  glm::dvec2 PlaceInSurvey(const glm::dvec2& pixel) const {
    const auto surface = SurfaceAt(caster_, mesh_, sequence_.CameraOfFrame(0), pixel);
    EXPECT_TRUE(surface);
    return LatLongFromDirection(surface->position_m - sequence_.environment->position_m,
                                {survey_.width, survey_.height}) -
           0.5;
  }
  static std::string Row(const glm::dvec2& pixel, const glm::dvec2& in_survey) {
    return fmt::format("{},{},6,{},{},3\n", pixel.x, pixel.y, in_survey.x, in_survey.y);
  }
  // The response, and ends.
  void Save(View& view) const {
    view.PressEach("ctrl+s");
    EXPECT_TRUE(Await([&] { return fs::exists(Site() / "camera_response.json"); })) << Log();
    End(view);
  }
  void CalibrateColour(const fs::path& site, const std::string& rows) const {
    const fs::path regions = folder_.Write("regions.csv", rows);
    Calibrate("colour " + site.string() + " --from-picture " +
              (site / "frames/bracket0.png").string() + " --to-picture " +
              (site / "environment.exr").string() + " --regions " + regions.string());
  }
  // The mesh's vertex next to a place.
  glm::dvec3 Nearest(const glm::dvec3& place_m) const {
    return *std::min_element(mesh_.positions_m.begin(),
                             mesh_.positions_m.end(),
                             [&](const glm::vec3& a, const glm::vec3& b) {
                               return glm::distance(glm::dvec3(a), place_m) <
                                      glm::distance(glm::dvec3(b), place_m);
                             });
  }
  static glm::dvec3 CentreOf(const glm::dmat4& camera_from_world) {
    return glm::dvec3(glm::inverse(camera_from_world)[3]);
  }

  // Keys that move the cursor, from one pixel to another.
  static std::string Way(const glm::ivec2& from, const glm::ivec2& to) {
    std::string keys;
    const auto add = [&](int steps, const char* back, const char* on) {
      const std::string key = steps < 0 ? back : on;
      for (int i = 0; i < std::abs(steps) / 10; ++i) keys += "shift+" + key + " ";
      for (int i = 0; i < std::abs(steps) % 10; ++i) keys += key + " ";
    };
    add(to.x - from.x, "a", "d");
    add(to.y - from.y, "w", "s");
    return keys;
  }
  // Where the cursor is first: the middle of a picture.
  static glm::ivec2 Middle(int width, int height) { return {(width - 1) / 2, (height - 1) / 2}; }
  const glm::ivec2 middle_ = Middle(480, 360);
  const Sequence sequence_ = ReadSequence(kCourtyard);
  const Mesh mesh_ = LoadMesh(kCourtyard / sequence_.scene_mesh).mesh;
  const RayCaster caster_{mesh_};
  const RgbImage survey_ = ReadRadianceImage(kCourtyard / sequence_.environment->image);
};

TEST_F(ToolsWindow, AResponseFromABracketIsTheCommands) {
  WriteBracket(OtherResponse());
  const fs::path copy = Copy();
  const auto view = OpenSite(" --frames ldr");
  view->PressEach("t t t t p Right");
  ASSERT_TRUE(view->AwaitTitle("frame 1"));
  // The last one is taken twice, and once taken back.
  view->PressEach("p Right");
  ASSERT_TRUE(view->AwaitTitle("frame 2"));
  view->PressEach("p p ctrl+z");
  Save(*view);
  Calibrate("response" + Pictures() + " --exposures " + Exposures() + " --site " + copy.string());
  EXPECT_EQ(ResponseIn(Site()), ResponseIn(copy));
  EXPECT_EQ(ReadSequence(Site()).response_ldr, "camera_response.json");
}

// A chart in the picture, its corners set by the pointer: one beside its place, and then dragged
// there.
TEST_F(ToolsWindow, AResponseFromAColorCheckerIsTheCommands) {
  constexpr glm::ivec2 kFirst(100, 60);
  constexpr int kPatchPx = 30;
  WriteBracket(OtherResponse(), [&](RgbImage& light) {
    for (int i = 0; i < kChartPatches; ++i) {
      const glm::ivec2 at = kFirst + kPatchPx * glm::ivec2(i % 6, i / 6);
      const double reflectance = kChartReflectance[static_cast<std::size_t>(i)];
      for (int y = 0; y < kPatchPx; ++y) {
        for (int x = 0; x < kPatchPx; ++x) {
          light.At(at.x + x, at.y + y) = glm::vec3(static_cast<float>(60.0 * reflectance));
        }
      }
    }
  });
  const fs::path copy = Copy();
  const glm::dvec2 low = glm::dvec2(kFirst) - 0.5;
  const glm::dvec2 high = low + double{kPatchPx} * glm::dvec2(6.0, 4.0);
  const std::array<glm::dvec2, 4> corners{
      low, glm::dvec2(high.x, low.y), high, glm::dvec2(low.x, high.y)};
  const auto view = OpenSite(" --frames ldr");
  // By way of the colours, under which the picture is smaller.
  view->PressEach("t t t");
  ASSERT_TRUE(view->AwaitTitle("pleinair, colours: yard frame 0")) << view->Title();
  view->PressEach("t");
  ASSERT_TRUE(view->AwaitTitle("pleinair: yard frame 0")) << view->Title();
  view->PressEach("c p");
  std::string stated;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::ivec2 place = PlaceOf(corners[i]) + glm::ivec2(i == 2 ? 20 : 0, 0);
    view->Move(place.x, place.y);
    view->Do("click 1");
    const glm::dvec2 pixel = PixelAt(PlaceOf(corners[i]));
    stated += fmt::format("{}{},{}", stated.empty() ? "" : ",", pixel.x, pixel.y);
  }
  const glm::ivec2 place = PlaceOf(corners[2]);
  view->Do(
      fmt::format("mousemove --window {0} {1} {3} mousedown 1 mousemove --window {0} {2} {3} "
                  "mouseup 1",
                  view->Line("getwindowfocus"),
                  place.x + 20,
                  place.x,
                  place.y));
  view->PressEach("Right");
  ASSERT_TRUE(view->AwaitTitle("frame 1"));
  view->PressEach("p Right");
  ASSERT_TRUE(view->AwaitTitle("frame 2"));
  view->PressEach("p");
  Save(*view);
  Calibrate("response" + Pictures() + " --chart --corners " + stated + " --exposures " +
            Exposures() + " --site " + copy.string());
  EXPECT_EQ(ResponseIn(Site()), ResponseIn(copy));
}

// By keys alone: surfaces of the picture, whose places in the survey map the mesh gives.
TEST_F(ToolsWindow, ColoursTiedToTheSurveyByKeysAreTheCommands) {
  WriteBracket(ResponseCurve::Srgb());
  const fs::path copy = Copy();
  const auto view = OpenSite(" --frames ldr");
  view->PressEach("t t t");
  std::string rows;
  glm::ivec2 at = middle_;
  for (const glm::ivec2& pixel :
       {glm::ivec2(239, 319), glm::ivec2(329, 149), glm::ivec2(88, 239)}) {
    // Pressed, and let go.
    view->PressEach(Way(at, pixel) + "Return Return");
    at = pixel;
    rows += Row(at, PlaceInSurvey(at));
  }
  // One more, and taken back.
  view->PressEach("shift+d shift+d Return Return ctrl+z");
  Save(*view);
  CalibrateColour(copy, rows);
  EXPECT_EQ(ResponseIn(Site()), ResponseIn(copy));
}

// In both pictures, one above the other.
TEST_F(ToolsWindow, ColoursTiedByThePointerAreTheCommands) {
  WriteBracket(ResponseCurve::Srgb());
  const fs::path copy = Copy();
  const auto view = OpenSite(" --frames ldr");
  view->PressEach("t t t");
  ASSERT_TRUE(view->AwaitTitle("pleinair, colours: yard frame 0")) << view->Title();
  // Below the menu, above the bar of two lines, half each.
  constexpr double kBar = 60.0;
  const double height = 0.5 * (820.0 - kMenuHeight - kBar);
  const double scale = height / 360.0;
  const double other_scale = std::min(960.0 / survey_.width, height / survey_.height);
  const glm::dvec2 origin(0.0, kMenuHeight);
  const glm::dvec2 other_origin(0.0, kMenuHeight + height);
  const auto drag = [&](const glm::ivec2& from, const glm::ivec2& to) {
    view->Do(
        fmt::format("mousemove --window {0} {1} {2} mousedown 1 mousemove --window {0} {3} "
                    "{4} mouseup 1",
                    view->Line("getwindowfocus"),
                    from.x,
                    from.y,
                    to.x,
                    to.y));
  };
  std::string rows;
  for (const auto& [pressed, other] : {std::pair{glm::ivec2(250, 340), glm::ivec2(300, 620)},
                                       std::pair{glm::ivec2(340, 170), glm::ivec2(420, 560)}}) {
    drag(pressed, pressed);
    const glm::dvec2 pixel = (glm::dvec2(pressed) - origin) / scale - 0.5;
    // From where the mesh has it in the map to another place there.
    const glm::dvec2 proposed = other_origin + other_scale * (PlaceInSurvey(pixel) + 0.5);
    drag(glm::ivec2(glm::round(proposed)), other);
    rows += Row(pixel, (glm::dvec2(other) - other_origin) / other_scale - 0.5);
  }
  Save(*view);
  CalibrateColour(copy, rows);
  EXPECT_EQ(ResponseIn(Site()), ResponseIn(copy));
}

// Colours are the first tool that T comes to: their picker is there before the response changes.
TEST_F(ToolsWindow, ColoursAfterAResponseAreTheTwoCommandsInTurn) {
  WriteBracket(OtherResponse());
  const fs::path copy = Copy();
  const auto view = OpenSite(" --frames ldr");
  view->PressEach("t t t");
  ASSERT_TRUE(view->AwaitTitle("pleinair, colours: yard frame 0")) << view->Title();
  view->PressEach("t p Right");
  ASSERT_TRUE(view->AwaitTitle("frame 1"));
  view->PressEach("p Right");
  ASSERT_TRUE(view->AwaitTitle("frame 2"));
  view->PressEach("p ctrl+s");
  ASSERT_TRUE(Await([&] { return fs::exists(Site() / "camera_response.json"); })) << Log();
  const std::string calibrated = ResponseIn(Site());
  view->PressEach("Home");
  ASSERT_TRUE(view->AwaitTitle("frame 0"));
  view->PressEach("shift+t");
  ASSERT_TRUE(view->AwaitTitle("pleinair, colours: yard frame 0")) << view->Title();
  std::string rows;
  glm::ivec2 at = middle_;
  for (const glm::ivec2& pixel : {glm::ivec2(239, 319), glm::ivec2(329, 149)}) {
    view->PressEach(Way(at, pixel) + "Return Return");
    at = pixel;
    rows += Row(at, PlaceInSurvey(at));
  }
  view->PressEach("ctrl+s");
  ASSERT_TRUE(Await([&] { return ResponseIn(Site()) != calibrated; })) << Log();
  End(*view);
  Calibrate("response" + Pictures() + " --exposures " + Exposures() + " --site " + copy.string());
  EXPECT_EQ(calibrated, ResponseIn(copy));
  CalibrateColour(copy, rows);
  EXPECT_EQ(ResponseIn(Site()), ResponseIn(copy));
}

TEST_F(ToolsWindow, LinearFramesHaveNoResponseToSave) {
  const auto view = OpenSite();
  const std::string before = ContentOf(SiteFile());
  view->PressEach("t t t Return Return ctrl+s t p ctrl+s");
  ASSERT_TRUE(Await([&] { return Log().find("response: no curve yet") != std::string::npos; }));
  EXPECT_THAT(Log(), HasSubstr("the camera's pictures are linear"));
  EXPECT_EQ(ContentOf(SiteFile()), before);
  End(*view);
}

// The brush by keys: a line of discs, part of it given back, another stroke taken back.
TEST_F(ToolsWindow, TheMaskIsPaintedByKeys) {
  const auto view = OpenSite();
  view->PressEach("t Return " + Way({0, 0}, {40, 0}) + "Return");
  // Back to the middle of the line, smaller, and out.
  view->PressEach(Way({40, 0}, {20, 0}) + "minus minus minus shift+Return Return");
  view->PressEach(Way({0, 0}, {0, 60}) + "Return Return ctrl+z");
  ASSERT_TRUE(WindowTest::Save(*view)) << Log();
  End(*view);
  const Gray8Image mask = ReadMaskImage(Site() / "diffuse_mask.png");
  constexpr double kBrushPx = 12.0;
  const double small_px = kBrushPx / std::pow(1.25, 3.0);
  const glm::dvec2 start(middle_);
  int masked = 0;
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      const double along = std::clamp(x - start.x, 0.0, 40.0);
      const double off = glm::distance(glm::dvec2(x, y), start + glm::dvec2(along, 0.0));
      const double from_given = glm::distance(glm::dvec2(x, y), start + glm::dvec2(20.0, 0.0));
      masked += mask.At(x, y) != 255 ? 1 : 0;
      // A stroke is of discs at its steps: between them it is narrower by less than half a pixel.
      if (off > kBrushPx || from_given <= small_px) {
        EXPECT_EQ(mask.At(x, y), 255) << x << ' ' << y;
      } else if (off < kBrushPx - 0.5) {
        EXPECT_EQ(mask.At(x, y), 0) << x << ' ' << y;
      }
    }
  }
  EXPECT_GT(masked, 900);
}

// Corners of the mesh taken and put where the picture has them, from a pose that is a degree off.
TEST_F(ToolsWindow, ThePoseIsPickedByKeys) {
  const Camera real = ReadSequence(Site()).CameraOfFrame(0);
  EditSiteFile(Site(), [&](nlohmann::ordered_json& json) {
    const glm::dmat4 turned =
        glm::rotate(glm::dmat4(1.0), RadFromDeg(0.8), glm::dvec3(0.3, 1.0, 0.1));
    json["camera"]["camera_from_world"] = JsonOf(turned * real.camera_from_world);
  });
  const fs::path copy = Copy();
  Camera shown = ReadSequence(Site()).CameraOfFrame(0);
  const auto pixel_of = [](const Camera& camera, const glm::dvec3& point_m) {
    return ProjectToPixel(camera.intrinsics,
                          glm::dvec3(camera.camera_from_world * glm::dvec4(point_m, 1.0)))
        .value();
  };
  const auto view = OpenSite();
  view->PressEach("t t");
  std::string rows;
  glm::ivec2 at = middle_;
  for (const glm::dvec3& corner : {glm::dvec3(3.095, 4.672, 3.15),
                                   glm::dvec3(10.081, 5.136, 0.0),
                                   glm::dvec3(10.081, 5.136, 6.0),
                                   glm::dvec3(11.032, 4.827, 7.0),
                                   glm::dvec3(1.812, -5.426, 0.0)}) {
    const glm::ivec2 from(glm::round(pixel_of(shown, Nearest(corner))));
    const glm::ivec2 to(glm::round(pixel_of(real, Nearest(corner))));
    view->PressEach(Way(at, from) + "Return " + Way(from, to) + "Return");
    at = to;
    const glm::dvec3 point = Nearest(corner);
    rows += fmt::format("{},{},{},{},{}\n", to.x, to.y, point.x, point.y, point.z);
    // From four picks on the mesh follows.
    if (std::count(rows.begin(), rows.end(), '\n') >= 4) shown = real;
  }
  ASSERT_TRUE(WindowTest::Save(*view)) << Log();
  End(*view);
  const fs::path picks = folder_.Write("picks.csv", rows);
  Calibrate("pose " + copy.string() + " --points " + picks.string() + " --near-stated --out " +
            (copy / "sequence.json").string());
  const glm::dmat4 saved = ReadSequence(Site()).CameraOfFrame(0).camera_from_world;
  const glm::dmat4 commanded = ReadSequence(copy).CameraOfFrame(0).camera_from_world;
  EXPECT_LT(RotationBetweenRad(saved, commanded), 1e-6);
  EXPECT_LT(glm::distance(CentreOf(saved), CentreOf(commanded)), 1e-5);
  // Picks are whole pixels: off by up to 0.7 px, and a pixel is 0.15 deg. It was 0.8 deg off.
  EXPECT_LT(RotationBetweenRad(saved, real.camera_from_world), RadFromDeg(0.4));
}

// By keys alone: pictures of a board are taken as they are shown, one is left out, and one taken
// in.
TEST_F(ToolsWindow, ALensFromTheCamerasPicturesByKeysIsTheCommands) {
  std::vector<Rgb8Image> boards = DrawnBoards(480);
  boards.push_back(Blurred(boards[2], 3.0));
  boards.emplace_back(480, 360, glm::u8vec3(90));
  EditSiteFile(Site(), [&](nlohmann::ordered_json& json) {
    json["frames"] = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < boards.size(); ++i) {
      const std::string name = fmt::format("frames/board{}.png", i);
      WritePng(Site() / name, boards[i]);
      json["frames"].push_back(
          {{"image_ldr", name}, {"time_utc", fmt::format("2005-06-21T09:50:0{}Z", i)}});
    }
  });
  const auto commanded = [&](const fs::path& copy, std::size_t without, bool is_blurred_used) {
    std::string arguments = "lens --board 8x6 --site " + copy.string();
    for (std::size_t i = 0; i < boards.size(); ++i) {
      if (i == without) continue;
      arguments += " " + (copy / fmt::format("frames/board{}.png", i)).string();
    }
    if (is_blurred_used) arguments += " --always-use " + (copy / "frames/board6.png").string();
    Calibrate(arguments);
    return ContentOf(copy / "sequence.json");
  };
  const fs::path copy = Copy();
  const auto view = OpenSite(" --frames ldr");
  view->PressEach("t t t t t");
  for (std::size_t i = 0; i < boards.size(); ++i) {
    ASSERT_TRUE(view->AwaitTitle(fmt::format("frame {}", i)));
    view->PressEach("p Right");
  }
  // Once more, and taken back.
  ASSERT_TRUE(view->AwaitTitle("frame 0"));
  view->PressEach("p ctrl+z");
  ASSERT_TRUE(WindowTest::Save(*view)) << Log();
  constexpr std::size_t kNone = 99;
  const std::string of_all = ContentOf(SiteFile());
  EXPECT_EQ(of_all, commanded(copy, kNone, false));
  // The second one by hand: the camera's picture comes after the last.
  view->PressEach("Tab Tab x");
  ASSERT_TRUE(WindowTest::Save(*view)) << Log();
  EXPECT_EQ(ContentOf(SiteFile()), commanded(copy, 1, false));
  // The blurred one is always used; the second one comes back.
  view->PressEach("x Tab Tab Tab Tab Tab x");
  ASSERT_TRUE(WindowTest::Save(*view)) << Log();
  const std::string with_blurred = commanded(copy, kNone, true);
  EXPECT_TRUE(Await([&] { return ContentOf(SiteFile()) == with_blurred; }));
  EXPECT_NE(with_blurred, of_all);
  End(*view);
}

// Files of a real fish-eye, some of them spoiled, by a path that is typed; a corner is dragged off.
TEST_F(ToolsWindow, ALensFromFilesByThePointerIsTheCommands) {
  const fs::path real = fs::path(PLEINAIR_SHARED_DIR) / "data/lens_calibration/fisheye_board";
  if (!fs::is_directory(real)) GTEST_SKIP() << "no pictures in " << real;
  const fs::path boards = folder_ / "boards";
  fs::create_directories(boards);
  std::vector<std::string> names;
  for (const char* number : {"13", "14", "2", "3", "6", "8"}) {
    names.push_back(fmt::format("Fisheye1_{}.jpg", number));
    fs::copy(real / names.back(), boards / names.back());
  }
  names.emplace_back("blurred.png");
  WritePng(boards / names.back(), Blurred(ReadDisplayImage(real / "Fisheye1_3.jpg"), 6.0));
  names.emplace_back("grey.png");
  WritePng(boards / names.back(), Rgb8Image(1032, 778, glm::u8vec3(90)));
  const auto commanded = [&](std::size_t first) {
    const fs::path copy = folder_ / fmt::format("commanded{}", first);
    CopyCourtyard(copy);
    std::string arguments = "lens --board 8x6 --site " + copy.string();
    for (std::size_t i = first; i < names.size(); ++i) {
      arguments += " " + (boards / names[i]).string();
    }
    Calibrate(arguments);
    return ContentOf(copy / "fisheye.json");
  };
  const auto saved = [&] { return ContentOf(Site() / "fisheye.json"); };

  WriteState(R"(["Tools"])");
  const auto view = OpenSite();
  view->PressEach("t t t t t");
  // The path's field, in the panel at the right, which takes letters once the click is seen: until
  // then they go to the panels, and are lost. Enter comes at once after the last letter.
  ASSERT_TRUE(Await([&] {
    view->PressEach("F10");
    view->Move(680, 207);
    view->Do("click 1");
    view->PressEach("ctrl+a");
    view->Do("type --delay 20 '" + boards.string() + "'");
    view->PressEach("Return Escape Escape Tab");
    return Await([&] { return view->Title().starts_with("pleinair, lens:"); }, 1.0);
  }));
  view->PressEach("ctrl+s");
  const std::string of_all = commanded(0);
  ASSERT_TRUE(Await([&] { return saved() == of_all; })) << saved() << Log();
  // The site's own file is written after the lens's.
  const std::string sequence = ContentOf(folder_ / "commanded0/sequence.json");
  EXPECT_TRUE(Await([&] { return ContentOf(SiteFile()) == sequence; })) << ContentOf(SiteFile());

  // 560 points wide beside the panel, below the menu.
  const double scale = 560.0 / 1032.0;
  const Rgb8Image first = ReadDisplayImage(boards / names[0]);
  Gray8Image green(first.width, first.height);
  for (std::size_t i = 0; i < first.pixels.size(); ++i) green.pixels[i] = first.pixels[i].y;
  const glm::dvec2 corner = FindBoardCorners(green, {{8, 6}, {}}).value()[20].pixel;
  const glm::ivec2 at(scale * (corner + 0.5) + glm::dvec2(0.0, kMenuHeight));
  view->Do(
      fmt::format("mousemove --window {0} {1} {2} mousedown 1 mousemove --window {0} {3} {2} "
                  "mouseup 1",
                  view->Line("getwindowfocus"),
                  at.x,
                  at.y,
                  at.x + 20));
  view->PressEach("ctrl+s");
  const std::string without_first = commanded(1);
  EXPECT_TRUE(Await([&] { return saved() == without_first; })) << saved() << Log();
  EXPECT_NE(without_first, of_all);
  view->PressEach("ctrl+z ctrl+s");
  EXPECT_TRUE(Await([&] { return saved() == of_all; })) << saved() << Log();
  End(*view);
}

}  // namespace
}  // namespace pleinair::tools_window_test
