// Traps of site set-up, each made from the bundled courtyard, which has none.
#include "session/check/site_check.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "datasets/degradation.h"
#include "pipeline/sun_state.h"
#include "scene/image_io.h"
#include "session/check/clock_check.h"
#include "session/check/geometry_check.h"
#include "session/check/map_check.h"
#include "session/sequence_site.h"
#include "sunmodel/angles.h"
#include "sunmodel/north.h"
#include "sunmodel/time_text.h"
#include "tests/datasets/exif_picture.h"
#include "tests/datasets/made_pictures.h"
#include "tests/objects/placement_stage.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair {

// For messages of tests.
inline void PrintTo(const SiteWarning& warning, std::ostream* out) {
  *out << warning.what << " | " << warning.where << " | " << warning.evidence << " | "
       << warning.remedy;
}

namespace site_check_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const glm::dvec3 kCameraDown(0.0, 1.0, 0.0);

const fs::path kGoodSite = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard";

// A copy of the courtyard, to be spoiled. Two of its six frames are enough to see edges and
// shadows.
class CourtyardCopy : public testing::Test {
 protected:
  void SetUp() override {
    fs::copy(kGoodSite, folder_.Path(), fs::copy_options::recursive);
    document_ = json::parse(ContentOf(kGoodSite / "sequence.json"));
    json& frames = document_["frames"];
    frames = json::array({frames[0], frames[3]});
  }

  SiteWarnings Check() {
    folder_.Write("sequence.json", document_.dump());
    return CheckSite(ReadSequence(folder_.Path()), FrameKind::kLinear);
  }

  // Each vertex line of an OBJ.
  void MoveVertices(const std::string& file, const std::function<glm::dvec3(glm::dvec3)>& move) {
    std::istringstream lines(ContentOf(folder_ / file));
    std::ostringstream moved;
    moved.precision(9);
    for (std::string line; std::getline(lines, line);) {
      glm::dvec3 at(0.0);
      if (std::sscanf(line.c_str(), "v %lf %lf %lf", &at.x, &at.y, &at.z) == 3) {
        at = move(at);
        moved << "v " << at.x << ' ' << at.y << ' ' << at.z << '\n';
      } else {
        moved << line << '\n';
      }
    }
    folder_.Write(file, moved.str());
  }

  void ChangePose(const std::function<glm::dmat4(const glm::dmat4&)>& change) {
    json& rows = document_["camera"]["camera_from_world"];
    glm::dmat4 pose(1.0);
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c) pose[c][r] = rows[r][c].get<double>();
    }
    pose = change(pose);
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c) rows[r][c] = pose[c][r];
    }
  }

  static std::string Later(const json& time, std::chrono::minutes by) {
    return FormatUtcTime(ParseUtcTime(time.get<std::string>()) + by);
  }
  void MoveTimes(std::chrono::minutes by) {
    for (json& frame : document_["frames"]) frame["time_utc"] = Later(frame["time_utc"], by);
  }

  void ChangeMap(const std::function<glm::ivec2(glm::ivec2 pixel, glm::ivec2 last)>& source) {
    const RgbImage map = ReadRadianceImage(folder_ / "environment.exr");
    RgbImage changed(map.width, map.height);
    const glm::ivec2 last(map.width - 1, map.height - 1);
    for (int y = 0; y < map.height; ++y) {
      for (int x = 0; x < map.width; ++x) {
        const glm::ivec2 from = source({x, y}, last);
        changed.At(x, y) = map.At(from.x, from.y);
      }
    }
    WriteExr(folder_ / "environment.exr", changed, ExrPrecision::kFloat);
  }

  TemporaryFolder folder_;
  json document_;
};

double LengthOf(const Mesh& mesh) {
  const BoundingBox box = BoundingBoxOf(mesh);
  const glm::vec3 size = box.upper_m - box.lower_m;
  return std::max({size.x, size.y, size.z});
}

testing::Matcher<const SiteWarning&> Says(const std::string& what) {
  return Field(&SiteWarning::what, HasSubstr(what));
}
testing::Matcher<const SiteWarning&> SaysAndAdvises(const std::string& what,
                                                    const std::string& remedy) {
  return AllOf(Says(what), Field(&SiteWarning::remedy, HasSubstr(remedy)));
}

TEST_F(CourtyardCopy, IsSilentOnAGoodSite) {
  document_ = json::parse(ContentOf(kGoodSite / "sequence.json"));
  EXPECT_THAT(Check(), IsEmpty());
}

TEST_F(CourtyardCopy, FindsAMeshInCentimetres) {
  MoveVertices("scene.obj", [](const glm::dvec3& at) { return 100.0 * at; });
  EXPECT_THAT(Check(), Contains(SaysAndAdvises("mesh seems not to be in metres", "centimetres")));
}

TEST_F(CourtyardCopy, FindsAMeshInKilometres) {
  MoveVertices("scene.obj", [](const glm::dvec3& at) { return 0.001 * at; });
  EXPECT_THAT(Check(), Contains(SaysAndAdvises("mesh seems not to be in metres", "kilometres")));
}

TEST_F(CourtyardCopy, FindsACameraInCentimetres) {
  ChangePose([](glm::dmat4 pose) {
    for (int i = 0; i < 3; ++i) pose[3][i] *= 100.0;
    return pose;
  });
  // Over the ground that goes on to the horizon, or beyond the mesh.
  EXPECT_THAT(Check(), Contains(testing::AnyOf(Says("camera's place"), Says("camera's pose"))));
}

TEST_F(CourtyardCopy, FindsAnObjectInMillimetres) {
  MoveVertices("object.obj", [](const glm::dvec3& at) { return 1000.0 * at; });
  EXPECT_THAT(Check(), Contains(SaysAndAdvises("object seems not to be in metres", "millimetres")));
}

// What a file animates is in parts, which may each be small.
TEST_F(CourtyardCopy, JudgesObjectsWithAllOfTheirParts) {
  Sequence sequence = ReadSequence(kGoodSite);
  SequenceSite site = LoadSequenceSite(sequence);
  const RayCaster caster(site.model.mesh);
  const auto part_of = [&](std::size_t entry, const glm::dvec3& at_m, double size) {
    VirtualObject part = site.objects.front();
    const Mesh unit = TransformMesh(
        glm::scale(glm::dmat4(1.0), glm::dvec3(1.0 / LengthOf(part.mesh))), part.mesh);
    part.mesh = TransformMesh(
        glm::translate(glm::dmat4(1.0), at_m) * glm::scale(glm::dmat4(1.0), glm::dvec3(size)),
        unit);
    ObjectMotion motion;
    motion.entry = entry;
    return std::pair(std::move(part), motion);
  };
  sequence.virtual_objects = {{"clock.gltf", glm::dmat4(1.0)}, {"tower.gltf", glm::dmat4(1.0)}};
  std::vector<VirtualObject> parts;
  std::vector<ObjectMotion> motions;
  for (const auto& [part, motion] : {part_of(0, {0.0, 0.0, 0.0}, 0.02),
                                     part_of(0, {0.0, 0.0, 0.4}, 0.02),
                                     part_of(1, {0.0, 0.0, 0.0}, 500.0)}) {
    parts.push_back(part);
    motions.push_back(motion);
  }
  EXPECT_THAT(CheckUnits(sequence, site.model.mesh, caster, parts, motions),
              testing::ElementsAre(AllOf(Says("object seems not to be in metres"),
                                         Field(&SiteWarning::where, testing::Eq("tower.gltf")))));
}

TEST_F(CourtyardCopy, FindsAMeshWithYUp) {
  MoveVertices("scene.obj", [](const glm::dvec3& at) { return glm::dvec3(at.x, at.z, -at.y); });
  EXPECT_THAT(Check(), Contains(SaysAndAdvises("mesh's up seems to be +Y", "--mesh-up y")));
}

TEST_F(CourtyardCopy, FindsAPoseThatIsTheInverse) {
  ChangePose([](const glm::dmat4& pose) { return glm::inverse(pose); });
  EXPECT_THAT(Check(),
              Contains(AllOf(Says("camera's pose"),
                             Field(&SiteWarning::evidence, HasSubstr("world_from_camera")))));
}

TEST_F(CourtyardCopy, FindsAPoseInOpenGlsAxes) {
  ChangePose([](const glm::dmat4& pose) {
    glm::dmat4 flip(1.0);
    flip[1][1] = flip[2][2] = -1.0;
    return flip * pose;
  });
  EXPECT_THAT(
      Check(),
      Contains(AllOf(Says("camera's pose"), Field(&SiteWarning::evidence, HasSubstr("OpenGL")))));
}

TEST_F(CourtyardCopy, FindsAMapFromBelowTheGroundOrFarAway) {
  json& place_m = document_["environment"]["position_m"];
  const json good = place_m;
  place_m[2] = -3.0;
  EXPECT_THAT(Check(), Contains(SaysAndAdvises("map was taken below the ground", "camera stood")));
  place_m = good;
  place_m[1] = 2000.0;
  EXPECT_THAT(Check(), Contains(SaysAndAdvises("hardly anything of the mesh", "camera stood")));
}

TEST_F(CourtyardCopy, FindsAFrameThatDoesNotLookAtTheMesh) {
  json& frames = document_["frames"];
  for (json& frame : frames) {
    frame["camera_from_world"] = document_["camera"]["camera_from_world"];
  }
  EXPECT_THAT(Check(), IsEmpty());
  frames[1]["camera_from_world"][2][3] = -5000.0;
  EXPECT_THAT(Check(),
              Contains(AllOf(
                  SaysAndAdvises("frames that do not show the mesh: 1", "leave these frames out"),
                  Field(&SiteWarning::where, "frames[1].camera_from_world"))));
}

TEST_F(CourtyardCopy, FindsAMapThatIsUpsideDown) {
  ChangeMap([](glm::ivec2 at, glm::ivec2 last) { return glm::ivec2(at.x, last.y - at.y); });
  EXPECT_THAT(Check(), Contains(Says("upside down (its rows")));
}

TEST_F(CourtyardCopy, FindsAMapThatIsTurnedUpsideDown) {
  ChangeMap([](glm::ivec2 at, glm::ivec2 last) { return last - at; });
  EXPECT_THAT(Check(), Contains(Says("turned upside down")));
}

TEST_F(CourtyardCopy, FindsAMapThatIsMirrored) {
  ChangeMap([](glm::ivec2 at, glm::ivec2 last) { return glm::ivec2(last.x - at.x, at.y); });
  EXPECT_THAT(Check(), Contains(Says("mirrored")));
}

TEST_F(CourtyardCopy, FindsAMapWithAnotherMiddle) {
  ChangeMap([](glm::ivec2 at, glm::ivec2 last) {
    return glm::ivec2((at.x + last.x / 4) % (last.x + 1), at.y);
  });
  EXPECT_THAT(Check(), Contains(Says("map is turned about the vertical")));
}

// Summer time written as UTC, in the frames.
TEST_F(CourtyardCopy, FindsLocalTimeInTheFrames) {
  MoveTimes(std::chrono::hours(2));
  EXPECT_THAT(Check(), Contains(SaysAndAdvises("sun in the pictures", "UTC+2")));
}

TEST_F(CourtyardCopy, FindsLocalTimeOfTheMap) {
  json& time = document_["environment"]["time_utc"];
  time = Later(time, std::chrono::hours(2));
  EXPECT_THAT(Check(), Contains(SaysAndAdvises("map's sun", "UTC+2")));
}

TEST_F(CourtyardCopy, FindsAClockThatIsFast) {
  MoveTimes(std::chrono::minutes(41));
  EXPECT_THAT(Check(), Contains(Says("sun in the pictures")));
}

TEST_F(CourtyardCopy, FindsALongitudeOfTheWrongSign) {
  json& longitude = document_["site"]["longitude_deg"];
  longitude = -longitude.get<double>();
  EXPECT_THAT(Check(), Contains(SaysAndAdvises("sun in the pictures", "wrong sign")));
}

TEST_F(CourtyardCopy, FindsAModelThatIsTurned) {
  folder_.Write("sequence.json", document_.dump());
  const Sequence good = ReadSequence(folder_.Path());
  const TemporaryFolder turned;
  Imperfections imperfections;
  imperfections.north_deg = 12.0;
  const std::array frames{0, 1};
  Degradation(imperfections, 1).Write(good, frames, turned.Path());
  EXPECT_THAT(CheckSite(ReadSequence(turned.Path()), FrameKind::kLdr),
              Contains(SaysAndAdvises("sun in the pictures", "true azimuth")));
}

// The sun's true place, or one turned about the vertical.
json StatedSun(const json& site, const json& time, double turned_deg) {
  const Site at{.latitude_rad = RadFromDeg(site["latitude_deg"].get<double>()),
                .longitude_rad = RadFromDeg(site["longitude_deg"].get<double>()),
                .height_m = site["height_m"].get<double>()};
  const glm::dvec3 sun = SunOverSite(at, ParseUtcTime(time.get<std::string>())).direction_enu;
  const double turned_rad = RadFromDeg(turned_deg);
  return {std::cos(turned_rad) * sun.x - std::sin(turned_rad) * sun.y,
          std::sin(turned_rad) * sun.x + std::cos(turned_rad) * sun.y,
          sun.z};
}

TEST_F(CourtyardCopy, FindsASunThatIsStatedWrongly) {
  for (const double turned_deg : {0.0, 15.0}) {
    for (json& frame : document_["frames"]) {
      frame["sun_direction_enu"] = StatedSun(document_["site"], frame["time_utc"], turned_deg);
    }
    json& map = document_["environment"];
    map["sun_direction_enu"] = StatedSun(document_["site"], map["time_utc"], turned_deg);
    const SiteWarnings warnings = Check();
    if (turned_deg == 0.0) {
      EXPECT_THAT(warnings, IsEmpty());
      continue;
    }
    EXPECT_THAT(warnings,
                Contains(AllOf(SaysAndAdvises("sun in the pictures is not where it is stated",
                                              "camera's pose"),
                               Field(&SiteWarning::where, "frames[0].sun_direction_enu"))));
    EXPECT_THAT(
        warnings,
        Contains(AllOf(SaysAndAdvises("map's sun is not where it is stated", "map's orientation"),
                       Field(&SiteWarning::where, "environment.sun_direction_enu"))));
  }
}

// As indoors with a fish-eye camera, which needs no place to be read.
TEST(SiteCheck, FindsFramesWhoseSunNothingStates) {
  Sequence sequence = ReadSequence(kGoodSite);
  sequence.frames.resize(2);
  sequence.site.reset();
  sequence.environment.reset();
  const auto is_found = Contains(AllOf(SaysAndAdvises("nothing says where the sun is", "latitude"),
                                       Field(&SiteWarning::evidence, HasSubstr("1 of 2 frames"))));
  sequence.frames[0].weather = Weather::kOvercast;
  EXPECT_THAT(CheckSite(sequence, FrameKind::kLinear), is_found);
  sequence.frames[1].sun_direction_enu = glm::dvec3(0.0, -0.6, 0.8);
  EXPECT_THAT(CheckSite(sequence, FrameKind::kLinear),
              Not(Contains(Says("nothing says where the sun is"))));
}

// Two hours are 30 degrees of sun.
TEST(SiteCheck, FindsASunThatFisheyePicturesShowElsewhere) {
  const fs::path room = fs::path(PLEINAIR_SHARED_DIR) / "sequences/room-window";
  if (!fs::is_directory(room)) GTEST_SKIP() << "no recording in " << room;
  Sequence sequence = ReadSequence(room);
  sequence.frames.resize(1);
  EXPECT_THAT(CheckSite(sequence, FrameKind::kLinear),
              Not(Contains(Says("fish-eye pictures show the sun elsewhere"))));
  sequence.frames[0].time += std::chrono::hours(2);
  EXPECT_THAT(CheckSite(sequence, FrameKind::kLinear),
              Contains(AllOf(SaysAndAdvises("fish-eye pictures show the sun elsewhere", "image_up"),
                             Field(&SiteWarning::evidence, HasSubstr("30.0 deg apart")))));
}

TEST_F(CourtyardCopy, FindsAPictureThatCannotBeUsed) {
  folder_.Write(document_["frames"][1]["image"].get<std::string>(), "cut");
  EXPECT_THAT(Check(),
              Contains(AllOf(Says("pictures cannot be used"),
                             Field(&SiteWarning::evidence, HasSubstr("1 of the 2")))));
}

TEST_F(CourtyardCopy, FindsAPoseThatIsThreeDegreesOff) {
  ChangePose([](const glm::dmat4& pose) {
    return glm::rotate(glm::dmat4(1.0), RadFromDeg(3.0), kCameraDown) * pose;
  });
  EXPECT_THAT(Check(), Contains(Says("mesh's edges are not where")));
}

// Runs correct it, and the same words are in their report.
TEST_F(CourtyardCopy, FindsAPoseThatIsHalfADegreeOff) {
  ChangePose([](const glm::dmat4& pose) {
    return glm::rotate(glm::dmat4(1.0), RadFromDeg(0.5), kCameraDown) * pose;
  });
  EXPECT_THAT(Check(),
              Contains(AllOf(SaysAndAdvises("pose is nearly right", "--near-stated"),
                             Field(&SiteWarning::evidence, HasSubstr("the mesh's edges are")))));
}

// Every second frame is seen from elsewhere: runs leave such poses as they are.
TEST_F(CourtyardCopy, SaysNothingOfThePoseOfACameraThatMoves) {
  const json true_pose = document_["camera"]["camera_from_world"];
  ChangePose([](const glm::dmat4& pose) {
    return glm::rotate(glm::dmat4(1.0), RadFromDeg(0.5), kCameraDown) * pose;
  });
  const json frame = document_["frames"][0];
  document_["frames"] = json::array();
  for (int i = 0; i < 12; ++i) {
    json next = frame;
    next["time_utc"] = Later(frame["time_utc"], std::chrono::minutes(i));
    if (i % 2 == 1) next["camera_from_world"] = true_pose;
    document_["frames"].push_back(next);
  }
  EXPECT_THAT(Check(), Not(Contains(Says("pose is nearly right"))));
}

// Walls half as high again: their shadows and roof lines are elsewhere.
TEST_F(CourtyardCopy, FindsAMeshThatIsNotThePlaces) {
  MoveVertices("scene.obj",
               [](const glm::dvec3& at) { return glm::dvec3(1.3 * at.x, 0.8 * at.y, 1.5 * at.z); });
  EXPECT_THAT(Check(), Contains(testing::AnyOf(Says("mesh's edges"), Says("sun in the pictures"))));
}

// --- Times that pictures state.

class FrameTimes : public CourtyardCopy {
 protected:
  // One frame at 10:00 UTC, whose picture says `tags`.
  SiteWarnings CheckTags(const ExifTags& tags) {
    const Rgb8Image picture = made_pictures::Noise(480, 360, 1);
    folder_.Write("picture.jpg", WithExif(made_pictures::Jpeg(picture), tags));
    document_["frames"] =
        json::array({{{"image_ldr", "picture.jpg"}, {"time_utc", "2005-06-21T10:00:00Z"}}});
    folder_.Write("sequence.json", document_.dump());
    return CheckFrameTimes(ReadSequence(folder_.Path()));
  }
};

TEST_F(FrameTimes, AreUtcWhereTheCameraSaysItsZone) {
  EXPECT_THAT(CheckTags({"2005:06:21 12:00:00", "", "+02:00"}), IsEmpty());
  EXPECT_THAT(CheckTags({"2005:06:21 12:03:00", "", "+02:00"}),
              Contains(Field(&SiteWarning::evidence, HasSubstr("3 min earlier (0.75 deg"))));
}

TEST_F(FrameTimes, AreNotTheCamerasLocalTime) {
  EXPECT_THAT(CheckTags({"2005:06:21 12:00:00", "", ""}), IsEmpty());
  EXPECT_THAT(CheckTags({"2005:06:21 11:00:00", "", ""}), IsEmpty());
  EXPECT_THAT(CheckTags({"2005:06:21 10:00:00", "", ""}),
              Contains(Field(&SiteWarning::evidence, HasSubstr("the same as EXIF's"))));
  // UTC+2 taken off on the wrong side.
  EXPECT_THAT(CheckTags({"2005:06:21 08:00:00", "", ""}),
              Contains(Field(&SiteWarning::evidence, HasSubstr("2 h before"))));
}

TEST_F(FrameTimes, AreByDayWhereTheExposureIs) {
  document_["frames"] = json::array({{{"image_ldr", "frames/none.png"},
                                      {"time_utc", "2005-03-21T23:30:00Z"},
                                      {"exposure_s", 0.004},
                                      {"iso", 100},
                                      {"f_number", 8}}});
  folder_.Write("sequence.json", document_.dump());
  EXPECT_THAT(CheckFrameTimes(ReadSequence(folder_.Path())), Contains(Says("time at night")));
  document_["frames"][0]["exposure_s"] = 2.0;
  folder_.Write("sequence.json", document_.dump());
  EXPECT_THAT(CheckFrameTimes(ReadSequence(folder_.Path())), IsEmpty());
}

// Nothing states the exposures: one frame by day shows that the others' times may be right.
TEST_F(FrameTimes, AreNotAllAtNight) {
  document_["frames"] =
      json::array({{{"image_ldr", "frames/a.png"}, {"time_utc", "2005-03-21T23:30:00Z"}},
                   {{"image_ldr", "frames/b.png"}, {"time_utc", "2005-03-22T00:30:00Z"}}});
  const auto check = [&] {
    folder_.Write("sequence.json", document_.dump());
    return CheckFrameTimes(ReadSequence(folder_.Path()));
  };
  EXPECT_THAT(check(), Contains(Says("all frames have times at night")));
  document_["frames"][1]["time_utc"] = "2005-03-22T12:30:00Z";
  EXPECT_THAT(check(), IsEmpty());
}

TEST(FrameOrder, TimesIncreaseAndShuttersClose) {
  Sequence sequence;
  for (const int seconds : {0, 10, 20}) {
    FrameEntry frame;
    frame.time = ParseUtcTime("2026-04-10T08:00:00Z") + std::chrono::seconds(seconds);
    frame.exposure_s = 0.01;
    sequence.frames.push_back(frame);
  }
  EXPECT_THAT(CheckFrameOrder(sequence), IsEmpty());
  std::swap(sequence.frames[1], sequence.frames[2]);
  EXPECT_THAT(CheckFrameOrder(sequence),
              ElementsAre(AllOf(Field(&SiteWarning::where, "frames[2].time_utc"),
                                Field(&SiteWarning::evidence, "it is 10 s before frames[1]"))));
  std::swap(sequence.frames[1], sequence.frames[2]);
  // A bracket's times are the exposures' begins.
  sequence.frames[1].time = sequence.frames[0].time + std::chrono::milliseconds(20);
  sequence.frames[1].exposure_s = 8.0;
  EXPECT_THAT(CheckFrameOrder(sequence), IsEmpty());
  sequence.frames[1].exposure_s = 40.0;  // Milliseconds.
  EXPECT_THAT(CheckFrameOrder(sequence),
              ElementsAre(AllOf(Says("open for longer"),
                                Field(&SiteWarning::where, "frames[1].exposure_s"))));
}

TEST(FramePoses, AllHaveThemOrNone) {
  Sequence sequence;
  sequence.frames.resize(4);
  EXPECT_THAT(CheckFramePoses(sequence), IsEmpty());
  for (FrameEntry& frame : sequence.frames) frame.camera_from_world = glm::dmat4(1.0);
  EXPECT_THAT(CheckFramePoses(sequence), IsEmpty());
  sequence.frames[2].camera_from_world.reset();
  EXPECT_THAT(
      CheckFramePoses(sequence),
      ElementsAre(AllOf(Field(&SiteWarning::where, "frames[2].camera_from_world"),
                        Field(&SiteWarning::evidence, HasSubstr("1 of 4 frames are taken")))));
}

// --- Whether light gets in.

// A room of 4 x 4 x 3 m whose southern wall has a window of 2 x 1 m, and the camera in its middle.
class Openings : public testing::Test {
 protected:
  Openings() {
    room_.Quad("floor", {-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0});
    room_.Quad("ceiling", {-2, -2, 3}, {2, -2, 3}, {2, 2, 3}, {-2, 2, 3});
    room_.Quad("wall", {-2, 2, 0}, {2, 2, 0}, {2, 2, 3}, {-2, 2, 3});
    room_.Quad("wall", {-2, -2, 0}, {-2, 2, 0}, {-2, 2, 3}, {-2, -2, 3});
    room_.Quad("wall", {2, -2, 0}, {2, 2, 0}, {2, 2, 3}, {2, -2, 3});
    room_.Quad("wall", {-2, -2, 0}, {2, -2, 0}, {2, -2, 1}, {-2, -2, 1});
    room_.Quad("wall", {-2, -2, 2}, {2, -2, 2}, {2, -2, 3}, {-2, -2, 3});
    room_.Quad("wall", {-2, -2, 1}, {-1, -2, 1}, {-1, -2, 2}, {-2, -2, 2});
    room_.Quad("wall", {1, -2, 1}, {2, -2, 1}, {2, -2, 2}, {1, -2, 2});
    sequence_.windows.push_back({"south", {{-1, -2, 1}, {1, -2, 1}, {1, -2, 2}, {-1, -2, 2}}});
    sequence_.fisheye.emplace();
    sequence_.scene_mesh = "room.obj";
    sequence_.frames.emplace_back().camera_from_world =
        glm::inverse(glm::translate(glm::dmat4(1.0), glm::dvec3(0.0, 0.0, 1.5)));
  }
  SiteWarnings Check() {
    const Mesh mesh = room_.Done();
    return CheckOpenings(sequence_, mesh, RayCaster(mesh));
  }

  placement_stage::Builder room_;
  Sequence sequence_;
};

TEST_F(Openings, AnOpenWindowIsFine) {
  EXPECT_THAT(Check(), IsEmpty());
  // A frame's bars.
  room_.Quad("bar", {-0.1f, -2, 1}, {0.1f, -2, 1}, {0.1f, -2, 2}, {-0.1f, -2, 2});
  EXPECT_THAT(Check(), IsEmpty());
}

TEST_F(Openings, APaneClosesAStatedWindow) {
  room_.Quad("pane", {-1, -2.05f, 1}, {1, -2.05f, 1}, {1, -2.05f, 2}, {-1, -2.05f, 2});
  EXPECT_THAT(Check(),
              ElementsAre(AllOf(Says("window \"south\" is closed"),
                                Field(&SiteWarning::where, "windows[0]"),
                                Field(&SiteWarning::evidence,
                                      "the mesh's \"pane\" stops light in 100 % of its area"))));
}

// Out of the window into a hall with a hole in its far wall.
TEST_F(Openings, ARoomMayGetItsLightThroughAnother) {
  room_.Quad("hall", {-2, -6, 0}, {2, -6, 0}, {2, -2, 0}, {-2, -2, 0});
  room_.Quad("hall", {-2, -6, 3}, {2, -6, 3}, {2, -2, 3}, {-2, -2, 3});
  room_.Quad("hall", {-2, -6, 0}, {-2, -2, 0}, {-2, -2, 3}, {-2, -6, 3});
  room_.Quad("hall", {2, -6, 0}, {2, -2, 0}, {2, -2, 3}, {2, -6, 3});
  room_.Quad("hall", {-2, -6, 0.8f}, {2, -6, 0.8f}, {2, -6, 3}, {-2, -6, 3});
  EXPECT_THAT(Check(), IsEmpty());
}

TEST_F(Openings, AClosedRoomIsDark) {
  room_.Quad("pane", {-1, -2.05f, 1}, {1, -2.05f, 1}, {1, -2.05f, 2}, {-1, -2.05f, 2});
  room_.Box("box", {-3.0f, -3.0f, -1.0f}, {3.0f, 3.0f, 4.0f});
  sequence_.windows.clear();
  EXPECT_THAT(Check(),
              ElementsAre(AllOf(Says("no light of the sky gets in"),
                                Field(&SiteWarning::where, "room.obj"))));
  sequence_.fisheye.reset();  // Light is measured in the pictures.
  EXPECT_THAT(Check(), IsEmpty());
}

// --- What explains a sun in the wrong place.

const Site kBerlin{RadFromDeg(52.5), RadFromDeg(13.4), 35.0};

std::vector<SeenSun> SunsSeen(std::chrono::minutes clock_ahead, double turned_deg) {
  std::vector<SeenSun> suns;
  for (const char* time : {"2026-04-10T08:00:00Z", "2026-04-10T13:00:00Z"}) {
    const UtcTime truth = ParseUtcTime(time);
    suns.push_back(
        {truth + clock_ahead,
         TurnedClockwise(SunOverSite(kBerlin, truth).direction_enu, RadFromDeg(turned_deg)),
         RadFromDeg(0.5)});
  }
  return suns;
}

TEST(ExplanationsOf, TwoFramesSeparateAClockFromANorth) {
  EXPECT_THAT(ExplanationsOf(SunsSeen(std::chrono::hours(2), 0.0), kBerlin).front(),
              HasSubstr("2 h too late, as local time of UTC+2"));
  EXPECT_THAT(ExplanationsOf(SunsSeen(std::chrono::minutes(-210), 0.0), kBerlin).front(),
              HasSubstr("UTC-3:30"));
  EXPECT_THAT(ExplanationsOf(SunsSeen(std::chrono::minutes(-330), 0.0), kBerlin).front(),
              HasSubstr("5 h 30 min slow"))
      << "no such zone";
  EXPECT_THAT(ExplanationsOf(SunsSeen(std::chrono::minutes(44), 0.0), kBerlin).front(),
              HasSubstr("44 min fast"));
  EXPECT_THAT(ExplanationsOf(SunsSeen(std::chrono::minutes(0), 25.0), kBerlin).front(),
              HasSubstr("true azimuth -25.0 deg"));
}

TEST(ExplanationsOf, NothingExplainsASunThatNeverStandsThere) {
  const std::vector<SeenSun> zenith{{ParseUtcTime("2026-04-10T08:00:00Z"), {0.0, 0.0, 1.0}, 0.01}};
  EXPECT_THAT(ExplanationsOf(zenith, kBerlin), IsEmpty());
}

}  // namespace
}  // namespace site_check_test
}  // namespace pleinair
