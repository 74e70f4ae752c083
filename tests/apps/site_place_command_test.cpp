// `pleinair site place` on a copy of the bundled courtyard.
#include "apps/site_place_command.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "datasets/sequence.h"
#include "objects/object_placement.h"
#include "scene/mesh_io.h"
#include "sunmodel/angles.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::site_place_command_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const fs::path kBundled = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard";

class SitePlace : public testing::Test {
 protected:
  // What the command reads: without frames and truth.
  void SetUp() override {
    for (const char* file : {"sequence.json",
                             "scene.obj",
                             "scene.mtl",
                             "object.obj",
                             "object.mtl",
                             "environment.exr"}) {
      fs::copy_file(kBundled / file, folder_ / file);
    }
    options_.folder = folder_.Path();
    options_.object = "0";
  }
  Sequence Read() const { return ReadSequence(folder_.Path()); }
  std::string Refusal() const {
    const std::string before = ContentOf(folder_ / "sequence.json");
    std::string text = MessageOf([&] { RunSitePlace(options_); });
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    EXPECT_EQ(ContentOf(folder_ / "sequence.json"), before);
    EXPECT_FALSE(fs::exists(folder_ / "objects"));
    return text;
  }

  TemporaryFolder folder_;
  SitePlaceOptions options_;
};

TEST_F(SitePlace, AnObjectRestsWhereThePixelShowsTheGround) {
  const Sequence before = Read();
  options_.pixel = {200.0, 300.0};
  const std::string report = RunSitePlace(options_);
  EXPECT_THAT(report, HasSubstr("on `paving`"));
  const Sequence after = Read();
  ASSERT_EQ(after.virtual_objects.size(), before.virtual_objects.size());
  const Mesh mesh = LoadMesh(folder_ / "scene.obj").mesh;
  const auto point = SurfaceAt(RayCaster(mesh), mesh, after.CameraOfFrame(0), {200.0, 300.0});
  ASSERT_TRUE(point);
  const PlaceableObject object(LoadMesh(folder_ / "object.obj").mesh);
  const glm::dmat4 pose = after.virtual_objects[0].world_from_object;
  EXPECT_LT(glm::distance(FootOf(object, pose), point->position_m), 2e-4);
  EXPECT_LT(glm::distance(AxisOf(pose), glm::dvec3(0, 0, 1)), 1e-9);
  // All else is as it was.
  auto old_json = nlohmann::ordered_json::parse(ContentOf(kBundled / "sequence.json"));
  auto new_json = nlohmann::ordered_json::parse(ContentOf(folder_ / "sequence.json"));
  for (auto* json : {&old_json, &new_json}) {
    json->erase("virtual_object");
    json->erase("virtual_objects");
  }
  EXPECT_EQ(new_json.dump(), old_json.dump());
}

// A pose half a degree down and to the right, which runs correct by the frames' edges.
TEST_F(SitePlace, AnObjectRestsWhereRunsWillHaveThePixel) {
  const Sequence before = Read();
  const glm::dvec2 pixel(200.0, 300.0);
  fs::copy(kBundled / "frames", folder_ / "frames");
  auto json = nlohmann::ordered_json::parse(ContentOf(folder_ / "sequence.json"));
  auto& rows = json["camera"]["camera_from_world"];
  const glm::dvec3 axis = glm::normalize(glm::dvec3(1.0, -1.0, 0.0));
  const glm::dmat4 stated =
      glm::rotate(glm::dmat4(1.0), RadFromDeg(0.7), axis) * before.camera_from_world.value();
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) rows[r][c] = stated[c][r];
  }
  folder_.Write("sequence.json", json.dump());
  options_.pixel = {pixel.x, pixel.y};
  EXPECT_THAT(RunSitePlace(options_), HasSubstr("camera_from_world: the mesh's edges are"));

  const Mesh mesh = LoadMesh(folder_ / "scene.obj").mesh;
  const RayCaster caster(mesh);
  const PlaceableObject object(LoadMesh(folder_ / "object.obj").mesh);
  const glm::dvec3 foot = FootOf(object, Read().virtual_objects[0].world_from_object);
  const auto seen = SurfaceAt(caster, mesh, before.CameraOfFrame(0), pixel);
  const auto as_stated = SurfaceAt(caster, mesh, Read().CameraOfFrame(0), pixel);
  ASSERT_TRUE(seen && as_stated);
  EXPECT_LT(glm::distance(foot, seen->position_m),
            glm::distance(as_stated->position_m, seen->position_m) / 3.0);
}

TEST_F(SitePlace, TurnsLiftsAndScalesInPlace) {
  const glm::dmat4 before = Read().virtual_objects[0].world_from_object;
  options_.turn_deg = 90.0;
  options_.lift_m = 0.5;
  options_.scale = 2.0;
  RunSitePlace(options_);
  const glm::dmat4 after = Read().virtual_objects[0].world_from_object;
  EXPECT_LT(glm::distance(glm::dvec3(after[0]), 2.0 * glm::dvec3(before[1])), 1e-9);
  const PlaceableObject object(LoadMesh(folder_ / "object.obj").mesh);
  EXPECT_LT(glm::distance(FootOf(object, after), FootOf(object, before) + glm::dvec3(0, 0, 0.5)),
            1e-9);
}

TEST_F(SitePlace, ANewObjectIsBroughtAndAnOldOneTakenOut) {
  const TemporaryFolder elsewhere;
  fs::copy_file(folder_ / "object.obj", elsewhere / "statue.obj");
  fs::copy_file(folder_ / "object.mtl", elsewhere / "object.mtl");
  options_.object = (elsewhere / "statue.obj").string();
  options_.at_m = {1.0, 1.0, 0.1};
  EXPECT_THAT(RunSitePlace(options_), HasSubstr("objects/statue/statue.obj"));
  ASSERT_EQ(Read().virtual_objects.size(), 2u);
  EXPECT_TRUE(fs::exists(folder_ / "objects/statue/object.mtl"));
  EXPECT_EQ(LoadMesh(folder_ / "objects/statue/statue.obj").mesh.triangles.size(),
            LoadMesh(folder_ / "object.obj").mesh.triangles.size());
  options_ = {};
  options_.folder = folder_.Path();
  options_.object = "0";
  options_.remove = true;
  RunSitePlace(options_);
  ASSERT_EQ(Read().virtual_objects.size(), 1u);
  EXPECT_EQ(Read().virtual_objects[0].mesh, "objects/statue/statue.obj");
  EXPECT_TRUE(fs::exists(folder_ / "object.obj"));
}

TEST_F(SitePlace, ASitesFileIsWrittenWhereThereIsOne) {
  auto site = nlohmann::ordered_json::parse(ContentOf(folder_ / "sequence.json"));
  site["format"] = "pleinair-site";
  site.erase("frames");
  folder_.Write("site.json", site.dump());
  const std::string sequence = ContentOf(folder_ / "sequence.json");
  options_.pixel = {200.0, 300.0};
  RunSitePlace(options_);
  EXPECT_EQ(ContentOf(folder_ / "sequence.json"), sequence);
  EXPECT_NE(ReadSite(folder_.Path(), UtcTime{}).virtual_objects[0].world_from_object,
            Read().virtual_objects[0].world_from_object);
}

TEST_F(SitePlace, SaysWhereAnObjectDoesNotFit) {
  // A ceiling 0.3 m over the floor.
  folder_.Write("scene.obj",
                "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nv -9 -9 .3\nv 9 -9 .3\nv 9 9 .3\n"
                "v -9 9 .3\ng floor\nf 1 2 3 4\ng ceiling\nf 5 6 7 8\n");
  options_.at_m = {0.0, 0.0, 0.0};
  EXPECT_THAT(Refusal(), testing::AllOf(HasSubstr("no room for"), HasSubstr("on `floor`")));
  options_.scale = 0.1;
  EXPECT_THAT(RunSitePlace(options_), HasSubstr("on `floor`"));
}

TEST_F(SitePlace, RefusalsAreOneLineAndWriteNothing) {
  options_.pixel = {240.0, 2.0};
  EXPECT_THAT(Refusal(), HasSubstr("--pixel 240,2: the mesh has no surface there"));
  options_.pixel = {-3.0, 2.0};
  EXPECT_THAT(Refusal(), HasSubstr("expected a place in a picture of"));
  options_.pixel = {200.0, 300.0};
  options_.frame = 99;
  EXPECT_THAT(Refusal(), HasSubstr("--frame 99"));
  options_.frame = 0;
  options_.object = "7";
  EXPECT_THAT(Refusal(), HasSubstr("--object 7: expected an index from 0 to"));
  options_.object = "no-such.obj";
  EXPECT_THAT(Refusal(), HasSubstr("no-such.obj"));
  options_.pixel.clear();
  EXPECT_THAT(Refusal(), HasSubstr("expected --pixel or --at"));
  options_.remove = true;
  EXPECT_THAT(Refusal(), HasSubstr("--remove"));
}

}  // namespace
}  // namespace pleinair::site_place_command_test
