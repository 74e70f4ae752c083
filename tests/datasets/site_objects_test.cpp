// Objects that are saved to a site: entries, their notes, their files.
#include "datasets/site_objects.h"

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "scene/mesh_io.h"
#include "tests/datasets/sequence_fixture.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::site_objects_test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using testing::HasSubstr;

glm::dmat4 At(double x) { return glm::translate(glm::dmat4(1.0), {x, 0.1, 0.2}); }

class SiteObjects : public SequenceFolder {
 protected:
  Json Document() const { return Json::parse(ContentOf(folder_ / "sequence.json")); }
  std::string RefusalToSave(const std::vector<VirtualObjectEntry>& objects) const {
    const std::string before = ContentOf(folder_ / "sequence.json");
    std::string text = MessageOf([&] { SaveObjects(folder_, objects); });
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    EXPECT_EQ(ContentOf(folder_ / "sequence.json"), before);
    return text;
  }
};

TEST_F(SiteObjects, ComeBackAsTheyWereSavedAndNothingElseChanges) {
  WriteDocument(Everything());
  Json expected = Document();
  const std::vector<VirtualObjectEntry> objects{{"object.obj", At(1.0 / 3.0)},
                                                {"scene.obj", glm::scale(At(-2.0), {2, 2, 2})}};
  SaveObjects(folder_, objects);
  const Sequence read = ReadSequence(folder_);
  ASSERT_EQ(read.virtual_objects.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read.virtual_objects[i].mesh, objects[i].mesh);
    EXPECT_EQ(read.virtual_objects[i].world_from_object, objects[i].world_from_object);
  }
  Json document = Document();
  for (Json* json : {&expected, &document}) {
    json->erase("virtual_object");
    json->erase("virtual_objects");
  }
  EXPECT_EQ(document.dump(), expected.dump());
  SaveObjects(folder_, {});
  EXPECT_TRUE(ReadSequence(folder_).virtual_objects.empty());
  EXPECT_FALSE(Document().contains("virtual_objects"));
}

TEST_F(SiteObjects, KeepTheirNotesAndHowTheirPathIsWritten) {
  Json document = Json::parse(Everything().dump());
  document.erase("virtual_object");
  const Json identity = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  Json there = identity;
  there[0][3] = 5;
  document["virtual_objects"] = {
      {{"name", "left"}, {"mesh", "./object.obj"}, {"world_from_object", identity}},
      {{"name", "right"}, {"mesh", "object.obj"}, {"world_from_object", there}}};
  Write(folder_ / "sequence.json", document.dump());
  // The left one is removed, the right one stays, one is new.
  glm::dmat4 right(1.0);
  right[3][0] = 5.0;
  SaveObjects(folder_,
              std::vector<VirtualObjectEntry>{{"scene.obj", At(3.0)}, {"object.obj", right}});
  Json saved = Document()["virtual_objects"];
  ASSERT_EQ(saved.size(), 2u);
  EXPECT_FALSE(saved[0].contains("name"));
  EXPECT_EQ(saved[1].dump(), document["virtual_objects"][1].dump());
  // Moved.
  SaveObjects(folder_, std::vector<VirtualObjectEntry>{{"object.obj", At(4.0)}});
  saved = Document()["virtual_objects"];
  EXPECT_EQ(saved[0]["name"], "right");
  EXPECT_EQ(saved[0]["world_from_object"][0][3], 4.0);
}

TEST_F(SiteObjects, RefusesWhatCouldNotBeReadAgain) {
  WriteDocument(Everything());
  EXPECT_THAT(RefusalToSave({{"../outside.obj", At(0)}}),
              HasSubstr("virtual_objects[0].mesh: expected a file in the site's folder"));
  EXPECT_THAT(RefusalToSave({{"nothing.obj", At(0)}}), HasSubstr("found nothing.obj"));
  EXPECT_THAT(RefusalToSave({{"object.obj", At(std::numeric_limits<double>::infinity())}}),
              HasSubstr("finite"));
  EXPECT_THAT(RefusalToSave({{"object.obj", glm::dmat4(0.0)}}), HasSubstr("invertible"));
  EXPECT_THAT(RefusalToSave({{"object.obj", At(1)}, {"object.obj", At(1)}}),
              HasSubstr("virtual_objects[1]: expected another mesh or place"));
}

TEST_F(SiteObjects, ANewObjectsFilesAreCopiedAndAnOldOnesAreNot) {
  const TemporaryFolder elsewhere;
  fs::create_directories(elsewhere / "maps");
  const std::string obj = "mtllib my crate.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
  elsewhere.Write("crate.obj", obj);
  elsewhere.Write("my crate.mtl", "newmtl a\nKd 1 1 1\nmap_Kd -s 1 1 1 maps/wood.png\n");
  elsewhere.Write("maps/wood.png", "x");
  elsewhere.Write("unrelated.txt", "x");
  const fs::path brought = BringObjectFile(folder_, elsewhere / "crate.obj");
  EXPECT_EQ(brought, "objects/crate/crate.obj");
  EXPECT_EQ(ContentOf(folder_ / brought), obj);
  EXPECT_TRUE(fs::exists(folder_ / "objects/crate/my crate.mtl"));
  EXPECT_TRUE(fs::exists(folder_ / "objects/crate/maps/wood.png"));
  EXPECT_FALSE(fs::exists(folder_ / "objects/crate/unrelated.txt"));
  // The same again, and another of that name.
  EXPECT_EQ(BringObjectFile(folder_, elsewhere / "crate.obj"), brought);
  elsewhere.Write("crate.obj", obj + "# another\n");
  EXPECT_EQ(BringObjectFile(folder_, elsewhere / "crate.obj"), "objects/crate-2/crate.obj");
  // One that lies in the folder stays where it is.
  EXPECT_EQ(BringObjectFile(folder_, folder_ / "frames/../object.obj"), "object.obj");
  EXPECT_THAT(MessageOf([&] { BringObjectFile(folder_, elsewhere / "no.obj"); }),
              HasSubstr("no such file"));
}

TEST_F(SiteObjects, AGltfsBuffersAndImagesAreCopied) {
  const TemporaryFolder elsewhere;
  elsewhere.Write("a.gltf",
                  R"({"buffers": [{"uri": "the%20bytes.bin"}, {"uri": "data:,x"}],
                      "images": [{"uri": "wood.png"}, {"bufferView": 0}, {"uri": "../up.png"}]})");
  elsewhere.Write("the bytes.bin", "x");
  elsewhere.Write("wood.png", "x");
  const fs::path brought = BringObjectFile(folder_, elsewhere / "a.gltf");
  EXPECT_EQ(brought, "objects/a/a.gltf");
  EXPECT_TRUE(fs::exists(folder_ / "objects/a/the bytes.bin"));
  EXPECT_TRUE(fs::exists(folder_ / "objects/a/wood.png"));
}

}  // namespace
}  // namespace pleinair::site_objects_test
