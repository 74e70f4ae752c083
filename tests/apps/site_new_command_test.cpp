#include "apps/site_new_command.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "datasets/new_site.h"
#include "datasets/sequence.h"
#include "scene/mesh_io.h"
#include "session/check/site_check.h"
#include "sunmodel/time_text.h"
#include "tests/datasets/exif_picture.h"
#include "tests/datasets/made_pictures.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::site_new_command_test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const fs::path kCourtyard = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard";
const UtcTime kNoon = ParseUtcTime("2005-06-21T12:00:00Z");

class SiteNew : public testing::Test {
 protected:
  SiteNewOptions Options() const {
    SiteNewOptions options;
    options.folder = site_;
    return options;
  }
  std::string Photograph(const char* name, int width, int height, unsigned orientation) {
    const std::vector<std::byte> jpeg = made_pictures::Jpeg(made_pictures::Noise(width, height, 1));
    const std::vector<ExifValue> tags = {
        ExifShort(EXIF_IFD_0, EXIF_TAG_ORIENTATION, orientation),
        ExifShort(EXIF_IFD_EXIF, EXIF_TAG_FOCAL_LENGTH_IN_35MM_FILM, 27)};
    return folder_.Write(name, WithExif(jpeg, tags)).string();
  }
  // Gives `answers` one after the other; then there are none.
  Ask Answers(std::vector<std::string> answers) {
    return [this, answers = std::move(answers), next = std::size_t{0}](
               const std::string& question) mutable -> std::optional<std::string> {
      asked_ += question;
      if (next == answers.size()) return std::nullopt;
      return answers[next++];
    };
  }
  nlohmann::json Written() const { return nlohmann::json::parse(ContentOf(site_ / "site.json")); }
  std::string RefusalOf(const SiteNewOptions& options) const {
    return MessageOf([&] { RunSiteNew(options, {}); });
  }

  TemporaryFolder folder_;
  fs::path site_ = folder_ / "mysite";
  std::string asked_;
};

TEST_F(SiteNew, SaysWhatIsMissingAndHowToGetIt) {
  const std::string state = RunSiteNew(Options(), {});
  EXPECT_THAT(state, HasSubstr("place    MISSING: latitude and longitude"));
  EXPECT_THAT(state, HasSubstr("objects  none, not required"));
  EXPECT_THAT(state, HasSubstr("next: pleinair site new " + site_.string() + " --place"));
  EXPECT_EQ(Written(), (nlohmann::json{{"format", "pleinair-site"}, {"version", 1}}));
}

// In two runs, and with a mesh in centimetres and Y up: the courtyard comes out.
TEST_F(SiteNew, MakesASiteByOptions) {
  SiteNewOptions first = Options();
  first.place = "57.0488,9.9217,15";
  std::string plan = "mtllib scene.mtl\n";
  const Mesh good = LoadMesh(kCourtyard / "scene.obj").mesh;
  for (const glm::vec3& p : good.positions_m) {
    plan += "v " + std::to_string(100.0f * p.x) + " " + std::to_string(100.0f * p.z) + " " +
            std::to_string(-100.0f * p.y) + "\n";
  }
  for (std::size_t i = 0; i < good.triangles.size(); ++i) {
    plan += "g " + good.group_names[good.triangle_group[i]] + "\nf";
    for (int c = 0; c < 3; ++c) plan += " " + std::to_string(good.triangles[i][c] + 1);
    plan += "\n";
  }
  first.mesh = folder_.Write("plan.obj", plan);
  first.mesh_units = "cm";
  first.mesh_up = "y";
  EXPECT_THAT(RunSiteNew(first, {}), HasSubstr("lens     MISSING"));

  SiteNewOptions second = Options();
  second.lens = kCourtyard;
  second.pose = kCourtyard / "sequence.json";
  second.environment = kCourtyard / "environment.exr";
  second.environment_at = "-1.15776,-1.6216,1.6";
  second.environment_time = "2005-06-21T11:50:00+02:00";
  second.object = kCourtyard / "object.obj";
  second.object_at = "-1.916,-1.69,0";
  second.object_turn_deg = 17.0;
  second.diffuse_regions = {"paving", "north_building"};
  EXPECT_THAT(RunSiteNew(second, {}), HasSubstr("next: pleinair site check"));

  const Sequence made = ReadSite(site_, kNoon);
  const Sequence courtyard = ReadSite(kCourtyard, kNoon);
  EXPECT_NEAR(made.site->latitude_rad, courtyard.site->latitude_rad, 1e-12);
  EXPECT_EQ(made.intrinsics, courtyard.intrinsics);
  EXPECT_EQ(made.camera_from_world, courtyard.camera_from_world);
  EXPECT_EQ(made.environment->time, courtyard.environment->time);
  EXPECT_EQ(made.diffuse_regions.size(), 2u);
  const BoundingBox box = BoundingBoxOf(LoadMesh(site_ / made.scene_mesh).mesh);
  const BoundingBox expected = BoundingBoxOf(good);
  EXPECT_NEAR(glm::distance(box.lower_m, expected.lower_m), 0.0f, 1e-4f);
  EXPECT_NEAR(glm::distance(box.upper_m, expected.upper_m), 0.0f, 1e-4f);
  const glm::dmat4& object = made.virtual_objects.at(0).world_from_object;
  const glm::dmat4& stated = courtyard.virtual_objects.at(0).world_from_object;
  for (int c = 0; c < 4; ++c) EXPECT_NEAR(glm::distance(object[c], stated[c]), 0.0, 1e-3);
  EXPECT_THAT(CheckSite(made, FrameKind::kLinear), testing::IsEmpty());
}

TEST_F(SiteNew, AsksForWhatIsMissingAlone) {
  SiteNewOptions options = Options();
  options.place = "57,10";
  const std::string state = RunSiteNew(options,
                                       Answers({(kCourtyard / "scene.obj").string(),
                                                "",
                                                "",
                                                "",
                                                kCourtyard.string(),
                                                "0,-8,1.7",
                                                "0,0,1.5",
                                                "",
                                                ""}));
  EXPECT_THAT(asked_,
              AllOf(HasSubstr("missing: mesh"),
                    HasSubstr("missing (not required): camera"),
                    Not(HasSubstr("missing: place"))));
  EXPECT_THAT(state, HasSubstr("next: pleinair site check"));
  const Sequence site = ReadSite(site_, kNoon);
  const glm::dvec3 centre = site.CameraOfFrame(0).CentreWorldM();
  EXPECT_NEAR(glm::distance(centre, glm::dvec3(0.0, -8.0, 1.7)), 0.0, 1e-12);
  // The target is in front, on the picture's middle column.
  const glm::dvec4 target = *site.camera_from_world * glm::dvec4(0.0, 0.0, 1.5, 1.0);
  EXPECT_NEAR(target.x, 0.0, 1e-12);
  EXPECT_NEAR(target.z, std::hypot(8.0, 0.2), 1e-12);
}

TEST_F(SiteNew, AsksAgainAfterAnAnswerThatWillNotDo) {
  RunSiteNew(Options(), Answers({"91,10", "50,10"}));
  EXPECT_THAT(asked_, HasSubstr("latitude"));
  EXPECT_EQ(Written()["site"]["latitude_deg"], 50.0);
}

TEST_F(SiteNew, AsksForAMissingFileAgainBeforeItsUnit) {
  RunSiteNew(Options(), Answers({"57.0488, 9.9217", "/no/such.obj"}));
  const std::size_t refused = asked_.find("/no/such.obj: no such file");
  ASSERT_NE(refused, std::string::npos) << asked_;
  EXPECT_NE(asked_.find("mesh file", refused), std::string::npos) << asked_;
  EXPECT_EQ(asked_.find("its unit"), std::string::npos) << asked_;
}

TEST_F(SiteNew, KeepsWhatPeopleHaveWritten) {
  RunSiteNew(Options(), {});
  std::ofstream(site_ / "site.json")
      << R"({"version": 1, "format": "pleinair-site", "note": "by hand", "name": "yard"})";
  SiteNewOptions options = Options();
  options.place = "57,10";
  RunSiteNew(options, {});
  EXPECT_THAT(ContentOf(site_ / "site.json"),
              testing::ContainsRegex("version.*\n.*format.*\n.*note.*\n.*name.*\n.*site"));
}

TEST_F(SiteNew, ReplacesTheMeshAndTheMapThatItHasMade) {
  SiteNewOptions options = Options();
  options.mesh = kCourtyard / "scene.obj";
  options.diffuse_regions = {"paving", "north_building"};
  options.environment = kCourtyard / "environment.exr";
  options.environment_at = "0,0,1.6";
  options.environment_time = "2005-06-21T11:50:00Z";
  RunSiteNew(options, {});
  const auto files = [&] {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(site_)) names.insert(entry.path().filename());
    return names;
  };
  const std::size_t count = files().size();
  SiteNewOptions again = options;
  again.diffuse_regions.clear();
  again.mesh = folder_.Write("other.obj",
                             "v 0 0 0\nv 5 0 0\nv 0 5 0\nv 0 0 5\ng paving\nf 1 2 3\ng wall\n"
                             "f 1 2 4\n");
  EXPECT_THAT(RunSiteNew(again, {}), HasSubstr("note: diffuse region 'north_building' is dropped"));
  EXPECT_EQ(files().size(), count);
  EXPECT_EQ(Written()["diffuse_regions"], nlohmann::json({"paving"}));
  EXPECT_THAT(LoadMesh(site_ / Written()["scene"]["mesh"].get<std::string>()).mesh.group_names,
              testing::Contains("wall"));
  EXPECT_TRUE(fs::exists(site_ / Written()["environment"]["image"].get<std::string>()));

  // What somebody else has put there stays, and so does what is read.
  nlohmann::json own = Written();
  own["scene"]["mesh"] = "own.obj";
  fs::copy(kCourtyard / "scene.obj", site_ / "own.obj");
  std::ofstream(site_ / "site.json") << own.dump();
  RunSiteNew(again, {});
  EXPECT_TRUE(fs::exists(site_ / "own.obj"));
  again.mesh = site_ / Written()["scene"]["mesh"].get<std::string>();
  RunSiteNew(again, {});
  EXPECT_TRUE(fs::exists(again.mesh));
}

TEST_F(SiteNew, ALensInPlaceOfTheFirstOneIsNoGuess) {
  RunSiteNew(Options(), {});
  std::ofstream(site_ / "site.json")
      << R"({"format": "pleinair-site", "version": 1, "note_lens": "from EXIF data",
             "camera": {"width": 6, "height": 4, "fx": 5, "fy": 5, "cx": 3, "cy": 2}})";
  EXPECT_THAT(RunSiteNew(Options(), {}), HasSubstr("better calibrate it"));
  SiteNewOptions options = Options();
  options.lens = kCourtyard;
  EXPECT_THAT(RunSiteNew(options, {}), Not(HasSubstr("better calibrate it")));
}

// The lens of a first photograph is no better than that of a second one; a calibrated one is.
TEST_F(SiteNew, TakesTheLensOfAnotherPhotographButNotInPlaceOfACalibratedOne) {
  SiteNewOptions options = Options();
  options.camera = Photograph("wide.jpg", 64, 48, 1);
  EXPECT_THAT(RunSiteNew(options, {}), Not(HasSubstr("note:")));
  EXPECT_EQ(Written()["camera"]["width"], 64);
  options.camera = Photograph("high.jpg", 48, 64, 1);
  EXPECT_THAT(RunSiteNew(options, {}), HasSubstr("note: its EXIF lens replaces"));
  EXPECT_EQ(Written()["camera"]["width"], 48);
  options.lens = kCourtyard;
  EXPECT_THAT(RunSiteNew(options, {}), HasSubstr("note: its EXIF lens is not used"));
  EXPECT_EQ(Written()["camera"]["width"], 480);
}

// Given together, or asked for one after the other.
TEST_F(SiteNew, PosesTheCameraAsItsPhotographWasHeld) {
  const std::string photo = Photograph("turned.jpg", 64, 48, 6);
  SiteNewOptions options = Options();
  options.camera = photo;
  options.camera_at = "0,0,1.6";
  options.camera_to = "0,10,1.6";
  RunSiteNew(options, {});
  const nlohmann::json pose = Written()["camera"]["camera_from_world"];
  // The world's up is to the left of the stored picture.
  EXPECT_NEAR(pose[0][2].get<double>(), -1.0, 1e-12);
  EXPECT_NEAR(pose[2][1].get<double>(), 1.0, 1e-12);

  fs::remove_all(site_);
  RunSiteNew(Options(), Answers({"57,10", "", photo, "0,0,1.6", "0,10,1.6"}));
  EXPECT_EQ(Written()["camera"]["camera_from_world"], pose);
}

TEST_F(SiteNew, RefusesInOneLineAndKeepsTheFileWhole) {
  SiteNewOptions options = Options();
  options.place = "57,10";
  RunSiteNew(options, {});
  const std::string before = ContentOf(site_ / "site.json");

  SiteNewOptions mesh = Options();
  mesh.mesh = folder_.Write("bad.obj", "v 0 0 0\n");
  SiteNewOptions pose = Options();
  pose.pose = folder_.Write("pose.json", "[[2,0,0,0],[0,2,0,0],[0,0,2,0],[0,0,0,1]]");
  SiteNewOptions above = Options();
  above.camera_at = "0,0,5";
  above.camera_to = "0,0,0";
  SiteNewOptions map = Options();
  map.environment = kCourtyard / "frames/000000.exr";
  map.environment_at = "0,0,1";
  map.environment_time = "2005-06-21T11:50:00Z";
  SiteNewOptions half = Options();
  half.object = kCourtyard / "object.obj";
  SiteNewOptions regions = Options();
  regions.diffuse_regions = {"walls"};
  SiteNewOptions photo = Options();
  photo.camera = (PLEINAIR_SOURCE_DIR "/docs/images/courtyard_input.png");
  const std::pair<SiteNewOptions, const char*> cases[] = {{mesh, "bad.obj"},
                                                          {pose, "a rigid transform"},
                                                          {above, "above, below"},
                                                          {map, "twice as wide"},
                                                          {half, "--object-at"},
                                                          {regions, "the mesh first"},
                                                          {photo, "EXIF"}};
  for (const auto& [refused, reason] : cases) {
    const std::string message = RefusalOf(refused);
    EXPECT_THAT(message, AllOf(HasSubstr(reason), Not(HasSubstr("\n"))));
    EXPECT_EQ(ContentOf(site_ / "site.json"), before) << reason;
  }
  EXPECT_THAT(MessageOf([] { MetresOfUnit("yd"); }), HasSubstr("m, cm, mm, ft or in"));
}

}  // namespace
}  // namespace pleinair::site_new_command_test
