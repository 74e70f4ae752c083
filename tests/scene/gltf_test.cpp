// glTF files: geometry, materials, and what moves.
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "box_mesh.h"
#include "gltf_file.h"
#include "scene/image_io.h"
#include "scene/mesh_io.h"
#include "temporary_folder.h"

namespace pleinair::gltf_test {
namespace {

using nlohmann::json;
using testing::Contains;
using testing::HasSubstr;

// A metal mirrors its colour and has no diffuse part, everything else mirrors 4 %; the texture's
// green is roughness, its blue metalness.
TEST(Gltf, MaterialsAreMetallicRoughness) {
  const TemporaryFolder folder;
  GltfFile file;
  const std::string png = PngOf(Rgb8Image(2, 2, glm::u8vec3(0, 51, 255)));
  file.document["images"] = {
      {{"bufferView", file.AddBytes(png.data(), png.size())}, {"mimeType", "image/png"}}};
  file.document["textures"] = {{{"source", 0}}};
  file.document["materials"] = {
      {{"name", "gold"},
       {"pbrMetallicRoughness",
        {{"baseColorFactor", {0.9, 0.7, 0.3, 1}}, {"metallicRoughnessTexture", {{"index", 0}}}}}},
      {{"name", "plastic"},
       {"alphaMode", "BLEND"},
       {"emissiveFactor", {1, 0, 0}},
       {"pbrMetallicRoughness",
        {{"baseColorFactor", {0.9, 0.7, 0.3, 1}},
         {"metallicFactor", 0},
         {"roughnessFactor", 0.4}}}}};
  file.AddMesh(Square(), 0);
  file.AddMesh(BoxMesh({0, 0, 2}, {1, 1, 3}), 1);
  file.document["nodes"] = {{{"mesh", 0}}, {{"mesh", 1}}};
  file.document["scenes"][0]["nodes"] = {0, 1};
  const LoadedMesh loaded = LoadMesh(folder.Write("a.glb", file.Binary()));
  ASSERT_EQ(loaded.mesh.materials.size(), 2u);
  const Material& gold = loaded.mesh.materials[0];
  EXPECT_EQ(gold.diffuse_albedo, glm::vec3(0.0f));
  EXPECT_NEAR(gold.specular_reflectance.g, 0.7f, 1e-6f);
  EXPECT_NEAR(gold.roughness, 0.2f, 1e-6f);
  const Material& plastic = loaded.mesh.materials[1];
  EXPECT_NEAR(plastic.diffuse_albedo.g, 0.7f, 1e-6f);
  EXPECT_NEAR(plastic.specular_reflectance.g, 0.04f, 1e-6f);
  EXPECT_NEAR(plastic.roughness, 0.4f, 1e-6f);
  EXPECT_THAT(loaded.report.notes, Contains(HasSubstr("alphaMode BLEND left out")));
  EXPECT_THAT(loaded.report.notes, Contains(HasSubstr("emitted light left out")));
}

// A car that drives along +X (glTF) with a wheel that turns about Z, beside a still kerb.
GltfFile Car() {
  GltfFile file;
  file.AddMesh(BoxMesh({-1, 0.5f, -0.5f}, {1, 1, 0.5f}));
  file.AddMesh(BoxMesh({-0.3f, -0.3f, -0.1f}, {0.3f, 0.3f, 0.1f}));
  file.AddMesh(BoxMesh({-5, 0, -1}, {5, 0.1f, -0.8f}));
  file.document["nodes"] = {{{"name", "car"}, {"mesh", 0}, {"children", {1}}},
                            {{"name", "axle"}, {"translation", {0.5, 0.3, 0}}, {"children", {2}}},
                            {{"name", "wheel"}, {"mesh", 1}},
                            {{"name", "kerb"}, {"mesh", 2}}};
  file.document["scenes"][0]["nodes"] = {0, 3};
  file.AddTrack(0, "translation", {0, 2}, {1, 0, 0, 5, 0, 0});
  const float half = std::sqrt(0.5f);
  file.AddTrack(2, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, half, half});
  return file;
}

TEST(Gltf, MovingNodesBecomePartsAndTakeTheirChildrenAlong) {
  const TemporaryFolder folder;
  const LoadedParts loaded =
      LoadMeshParts(folder.Write("car.gltf", Car().Text()), MeshColours::kByPlace);
  ASSERT_EQ(loaded.parts.size(), 3u);
  EXPECT_FALSE(loaded.parts[0].motion.Moves());
  EXPECT_EQ(BoundingBoxOf(loaded.parts[0].mesh).lower_m, glm::vec3(-5.0f, 0.8f, 0.0f)) << "kerb";
  // At the beginning the car is at x = 1, not where its node rests.
  const BoundingBox car = BoundingBoxOf(loaded.parts[1].mesh);
  EXPECT_EQ(car.lower_m, glm::vec3(0.0f, -0.5f, 0.5f));
  const BoundingBox wheel = BoundingBoxOf(loaded.parts[2].mesh);
  EXPECT_NEAR(glm::distance(wheel.lower_m, glm::vec3(1.2f, -0.1f, 0.0f)), 0.0, 1e-6);

  // After half a second the car is 1 m on and the wheel has turned by 45 deg, about glTF's Z, our
  // -Y: its middle has only moved on.
  const glm::dmat4 of_wheel = loaded.parts[2].motion.FileFromStart(0.5);
  const glm::dvec4 middle = of_wheel * glm::dvec4(1.5, 0.0, 0.3, 1.0);
  EXPECT_NEAR(glm::distance(glm::dvec3(middle), glm::dvec3(2.5, 0.0, 0.3)), 0.0, 1e-6);
  EXPECT_EQ(loaded.parts[1].motion.FileFromStart(2.5), loaded.parts[1].motion.FileFromStart(0.5))
      << "repeats after 2 s";
  const glm::dvec4 spoke = of_wheel * glm::dvec4(1.0, 0.0, 0.0, 0.0);
  EXPECT_NEAR(
      glm::distance(glm::dvec3(spoke), glm::dvec3(std::sqrt(0.5), 0.0, std::sqrt(0.5))), 0.0, 1e-6);
  const Mesh moved = TransformMesh(loaded.parts[1].motion.FileFromStart(0.5), loaded.parts[1].mesh);
  EXPECT_NEAR(BoundingBoxOf(moved).lower_m.x, 1.0f, 1e-5f);

  // Without its animation it rests, in one mesh.
  const Mesh still = LoadMesh(folder / "car.gltf").mesh;
  EXPECT_EQ(still.triangles.size(), 36u);
  EXPECT_EQ(still.group_names, (std::vector<std::string>{"car", "wheel", "kerb"}));
}

TEST(Gltf, ReadsBuffersOfItsFolderAlone) {
  const TemporaryFolder folder;
  const GltfFile car = Car();
  folder.Write("car.bin", car.Buffer());
  EXPECT_EQ(LoadMeshParts(folder.Write("car.gltf", car.Text("car.bin")), MeshColours::kByPlace)
                .parts.size(),
            3u);
  EXPECT_EQ(
      LoadMeshParts(folder.Write("car.glb", car.Binary()), MeshColours::kByPlace).parts.size(), 3u);
  EXPECT_THAT(MessageOf([&] {
                LoadMeshParts(folder.Write("b.gltf", car.Text("../car.bin")),
                              MeshColours::kByPlace);
              }),
              HasSubstr("b.gltf"));
}

struct BadAnimation {
  const char* name;
  void (*spoil)(json&);
  const char* message;
};

class GltfHardCase : public testing::TestWithParam<BadAnimation> {};

TEST_P(GltfHardCase, NamesWhatIsWrongInOneLine) {
  const TemporaryFolder folder;
  GltfFile car = Car();
  GetParam().spoil(car.document);
  const std::string message = MessageOf(
      [&] { LoadMeshParts(folder.Write("car.gltf", car.Text()), MeshColours::kByPlace); });
  EXPECT_THAT(message, HasSubstr("car.gltf"));
  EXPECT_THAT(message, HasSubstr(GetParam().message));
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

json& Sampler(json& document) { return document["animations"][0]["samplers"][0]; }
json& TimesOf(json& document) {
  return document["accessors"][Sampler(document)["input"].get<int>()];
}

INSTANTIATE_TEST_SUITE_P(
    Animations,
    GltfHardCase,
    testing::Values(BadAnimation{"Interpolation",
                                 [](json& d) { Sampler(d)["interpolation"] = "BOUNCE"; },
                                 "samplers[0].interpolation: expected STEP"},
                    BadAnimation{"Spline",
                                 [](json& d) { Sampler(d)["interpolation"] = "CUBICSPLINE"; },
                                 "samplers[0].output: expected 3 values"},
                    BadAnimation{"Sparse",
                                 [](json& d) {
                                   TimesOf(d)["sparse"] = {{"count", 0}};
                                 },
                                 ".sparse: expected an object with indices and values"},
                    BadAnimation{"TooMany",
                                 [](json& d) {
                                   d["accessors"][Sampler(d)["output"].get<int>()]["count"] = 1;
                                 },
                                 "samplers[0].output: expected 1 values"},
                    BadAnimation{"Standstill",
                                 [](json& d) {
                                   // A stride that an element does not fill is refused; this one
                                   // reads one time twice.
                                   json& track = d["accessors"][Sampler(d)["input"].get<int>()];
                                   track["componentType"] = 5121;
                                 },
                                 "samplers[0].input: expected ascending times"},
                    BadAnimation{"Path",
                                 [](json& d) {
                                   d["animations"][0]["channels"][0]["target"]["path"] = "colour";
                                 },
                                 "target.path: expected translation"}),
    [](const auto& test) { return std::string(test.param.name); });

// Bytes changed at random, or missing: an error or a mesh, never a crash.
TEST(GltfHardCases, DamagedFilesNeverCrash) {
  const TemporaryFolder folder;
  const std::string sound = Car().Binary();
  std::mt19937 random(7);
  int loaded = 0;
  int refused = 0;
  for (int trial = 0; trial < 90; ++trial) {
    std::string damaged = sound;
    if (trial % 3 == 0) damaged.resize(random() % damaged.size());
    for (int i = 0; i < 3 && !damaged.empty(); ++i) {
      damaged[random() % damaged.size()] = static_cast<char>(random());
    }
    try {
      for (const MeshPart& part :
           LoadMeshParts(folder.Write("a.glb", damaged), MeshColours::kByPlace).parts) {
        for (const glm::vec3& p : part.mesh.positions_m)
          ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
      }
      ++loaded;
    } catch (const std::exception&) {
      ++refused;
    }
  }
  EXPECT_GT(loaded, 0);
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace pleinair::gltf_test
