#include "scene/mesh_io.h"

#include <cmath>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "scene/image_io.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::mesh_io_test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kTwoSquares =
    "mtllib scene.mtl\n"
    "o floor\ng floor\nusemtl stone\n"
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"
    "o wall\ng wall\nusemtl gold\n"
    "v 0 1 0\nv 1 1 0\nv 1 1 1\nv 0 1 1\nf 5 6 7 8\n";

constexpr const char* kTwoMaterials =
    "newmtl stone\nKd 0.1 0.2 0.3\n"
    "newmtl gold\nKd 0 0 0\nKs 0.9 0.8 0.7\nPr 0.25\nNs 5\n";

TEST(MeshIo, ReadsGroupsAndMaterialsByName) {
  const TemporaryFolder folder;
  folder.Write("scene.mtl", kTwoMaterials);
  const LoadedMesh loaded = LoadMesh(folder.Write("scene.obj", kTwoSquares));
  const Mesh& mesh = loaded.mesh;
  EXPECT_THAT(mesh.group_names, ElementsAre("floor", "wall"));
  EXPECT_THAT(mesh.triangle_group, ElementsAre(0u, 0u, 1u, 1u));
  ASSERT_EQ(mesh.materials.size(), 2u);
  const Material& stone = mesh.materials[mesh.triangle_material[0]];
  EXPECT_EQ(stone.name, "stone");
  EXPECT_EQ(stone.diffuse_albedo, glm::vec3(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(stone.specular_reflectance, glm::vec3(0.0f));
  const Material& gold = mesh.materials[mesh.triangle_material[2]];
  EXPECT_EQ(gold.name, "gold");
  EXPECT_EQ(gold.specular_reflectance, glm::vec3(0.9f, 0.8f, 0.7f));
  EXPECT_EQ(gold.roughness, 0.25f);  // Pr wins over Ns.
  EXPECT_THAT(loaded.report.notes, IsEmpty());
}

TEST(MeshIo, SaysThatAnObjsTransparencyIsLeftOut) {
  const TemporaryFolder folder;
  folder.Write("a.mtl", "newmtl glass\nKd 0.1 0.1 0.1\nd 0.25\nnewmtl wall\nKd 0.5 0.5 0.5\nd 1\n");
  const LoadedMesh loaded =
      LoadMesh(folder.Write("a.obj",
                            "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\n"
                            "usemtl glass\nf 1 2 3\nusemtl wall\nf 2 3 4\n"));
  EXPECT_THAT(loaded.report.notes,
              ElementsAre("material 'glass': d 0.25 left out, treated as opaque"));
}

TEST(MeshIo, NamesTheLibrariesThatLackAMaterial) {
  const TemporaryFolder folder;
  folder.Write("a.mtl", "newmtl wall\nKd 0.5 0.5 0.5\n");
  const auto obj =
      folder.Write("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl glass\nf 1 2 3\n");
  EXPECT_THAT(MessageOf([&] { LoadMesh(obj); }),
              testing::HasSubstr("usemtl 'glass': no material library defines it (a.mtl)"));
}

// As some programs write them; "usemtl .5" is a name.
TEST(MeshIo, ReadsNumbersWithoutALeadingZero) {
  const TemporaryFolder folder;
  folder.Write("scene.mtl", "newmtl .5\nKd .1 .2 .3\n");
  const Mesh mesh = LoadMesh(folder.Write("scene.obj",
                                          "mtllib scene.mtl\nusemtl .5\n"
                                          "v 0 0 -.5\nv .25 0 0\nv\t1 +.75 0.5\nv 1.5 1. .5\n"
                                          "vn .0 0 1\nf 1//1 2//1 3//1\nf 2//1 4//1 3//1\n"))
                        .mesh;
  EXPECT_THAT(mesh.positions_m,
              ElementsAre(glm::vec3(0.0f, 0.0f, -0.5f),
                          glm::vec3(0.25f, 0.0f, 0.0f),
                          glm::vec3(1.0f, 0.75f, 0.5f),
                          glm::vec3(1.5f, 1.0f, 0.5f)));
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.materials[mesh.triangle_material[0]].name, ".5");
  EXPECT_EQ(mesh.materials[mesh.triangle_material[0]].diffuse_albedo, glm::vec3(0.1f, 0.2f, 0.3f));
}

TEST(MeshIo, MaterialDefaultsAreThoseOfTheFormat) {
  const TemporaryFolder folder;
  folder.Write("scene.mtl", "newmtl stone\nnewmtl gold\nKs 1 1 1\nNs 30\n");
  const Mesh mesh = LoadMesh(folder.Write("scene.obj", kTwoSquares)).mesh;
  const Material& stone = mesh.materials[mesh.triangle_material[0]];
  EXPECT_EQ(stone.diffuse_albedo, glm::vec3(0.5f));
  EXPECT_EQ(stone.specular_reflectance, glm::vec3(0.0f));
  const Material& gold = mesh.materials[mesh.triangle_material[2]];
  // alpha^2 = 2 / (30 + 2) and alpha = roughness^2.
  EXPECT_NEAR(gold.roughness, std::sqrt(0.25), 1e-6);
}

TEST(MeshIo, LimitsAlbedoThatWouldNeverConverge) {
  const TemporaryFolder folder;
  folder.Write("scene.mtl", "newmtl stone\nKd 1 0.5 2\nnewmtl gold\n");
  const LoadedMesh loaded = LoadMesh(folder.Write("scene.obj", kTwoSquares));
  EXPECT_EQ(loaded.mesh.materials[0].diffuse_albedo, glm::vec3(0.98f, 0.5f, 0.98f));
  EXPECT_THAT(loaded.report.notes, Contains(HasSubstr("'stone'")));
}

// Parts of one name are one group, in whatever order they come.
TEST(MeshIo, MergesPartsOfOneName) {
  const TemporaryFolder folder;
  const Mesh mesh = LoadMesh(folder.Write("a.obj",
                                          "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                          "o left\ng left\nf 1 2 3\n"
                                          "o right\ng right\nf 1 3 4\n"
                                          "o left\ng left\nf 1 4 2\n"))
                        .mesh;
  EXPECT_THAT(mesh.group_names, ElementsAre("left", "right"));
  EXPECT_THAT(mesh.triangle_group, testing::UnorderedElementsAre(0u, 0u, 1u));
}

// The colour of a texture in the linear scale: half of the texels at code 188, linear 0.5029.
TEST(MeshIo, ReplacesATextureByItsMeanColour) {
  const TemporaryFolder folder;
  Rgb8Image texture(2, 2, glm::u8vec3(0));
  texture.At(0, 0) = glm::u8vec3(188, 255, 0);
  texture.At(1, 1) = glm::u8vec3(188, 255, 0);
  WritePng(folder / "texture.png", texture);
  folder.Write("scene.mtl", "newmtl stone\nKd 0.8 0.8 0.8\nmap_Kd texture.png\nnewmtl gold\n");
  const LoadedMesh loaded = LoadMesh(folder.Write("scene.obj", kTwoSquares));
  const glm::vec3 albedo = loaded.mesh.materials[0].diffuse_albedo;
  EXPECT_NEAR(albedo.r, 0.8 * 0.5 * 0.50289, 1e-4);
  EXPECT_NEAR(albedo.g, 0.8 * 0.5, 1e-6);
  EXPECT_EQ(albedo.b, 0.0f);
  EXPECT_THAT(loaded.report.notes, Contains(HasSubstr("mean colour")));

  folder.Write("scene.mtl", "newmtl stone\nmap_Kd texture.png\nnewmtl gold\n");
  const glm::vec3 alone = LoadMesh(folder / "scene.obj").mesh.materials[0].diffuse_albedo;
  EXPECT_NEAR(alone.g, 0.5, 1e-6);
}

// glTF 2.0 with one node that scales by (1, 2, 3), mirrors x and moves up by 10: +Y is our +Z, +Z
// our -Y. The triangle faces +Z (front) before the mirror, and still does.
TEST(MeshIo, TurnsGltfUpright) {
  const TemporaryFolder folder;
  const LoadedMesh loaded =
      LoadMesh(folder.Write("a.gltf",
                            R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"name":"sail","mesh":0,"scale":[-1,2,3],"translation":[0,10,0]}],
"materials":[{"name":"cloth","pbrMetallicRoughness":
{"baseColorFactor":[0.4,0.2,0.1,1],"metallicFactor":0.5,"roughnessFactor":0.3}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,1],"max":[1,1,1]}],
"bufferViews":[{"buffer":0,"byteLength":36}],
"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,)"
                            // (0 0 1), (1 0 1), (0 1 1)
                            R"(AAAAAAAAAAAAAIA/AACAPwAAAAAAAIA/AAAAAAAAgD8AAIA/"}]})"));
  const Mesh& mesh = loaded.mesh;
  EXPECT_THAT(mesh.group_names, ElementsAre("sail"));
  const BoundingBox box = BoundingBoxOf(mesh);
  EXPECT_EQ(box.lower_m, glm::vec3(-1.0f, -3.0f, 10.0f));
  EXPECT_EQ(box.upper_m, glm::vec3(0.0f, -3.0f, 12.0f));
  EXPECT_NEAR(glm::distance(TriangleNormal(mesh, 0), glm::vec3(0.0f, -1.0f, 0.0f)), 0.0, 1e-6);
  ASSERT_EQ(mesh.materials.size(), 1u);
  // Half metal: half the base colour diffuse; 4 % and the base colour mirrored, half each.
  EXPECT_NEAR(mesh.materials[0].diffuse_albedo.r, 0.2f, 1e-6f);
  EXPECT_NEAR(mesh.materials[0].specular_reflectance.r, 0.22f, 1e-6f);
  EXPECT_NEAR(mesh.materials[0].roughness, 0.3f, 1e-6f);
}

TEST(MeshIo, WeldsCornersAndKeepsTheFilesNormals) {
  const TemporaryFolder folder;
  const LoadedMesh loaded = LoadMesh(folder.Write("a.obj",
                                                  "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                                                  "vn 0 0 2\nvn 0.6 0 0.8\n"
                                                  "f 1//1 2//1 3//2\nf 1//1 3//2 4//1\n"));
  EXPECT_EQ(loaded.mesh.positions_m.size(), 4u);
  EXPECT_EQ(loaded.report.normals_computed, 0);
  for (std::size_t v = 0; v < 4; ++v) {
    const glm::vec3 expected = loaded.mesh.positions_m[v] == glm::vec3(1.0f, 1.0f, 0.0f)
                                   ? glm::vec3(0.6f, 0.0f, 0.8f)
                                   : glm::vec3(0.0f, 0.0f, 1.0f);
    EXPECT_NEAR(glm::distance(loaded.mesh.normals[v], expected), 0.0f, 1e-6f);
  }
}

// What lies about the recordings: names as in the file, nothing repaired, nothing noted.
TEST(MeshIo, ReadsTheRecordedScenes) {
  const std::filesystem::path shared = std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences";
  if (!std::filesystem::exists(shared / "courtyard-clouds/scene.obj")) {
    GTEST_SKIP() << "the recorded sequences are not here";
  }
  const LoadedMesh courtyard = LoadMesh(shared / "courtyard-clouds/scene.obj");
  EXPECT_THAT(
      courtyard.mesh.group_names,
      ElementsAre(
          "paving", "north_building", "east_building", "west_building", "porch", "garden_wall"));
  EXPECT_EQ(courtyard.mesh.triangles.size(), 62u);
  EXPECT_THAT(courtyard.report.notes, IsEmpty());

  const LoadedMesh object = LoadMesh(shared / "parking-shadow/object.obj");
  EXPECT_THAT(object.mesh.group_names, ElementsAre("figure", "ring", "plinth", "ball"));
  EXPECT_EQ(object.report.normals_computed, 0);
  const Material& chrome = object.mesh.materials[object.mesh.triangle_material.back()];
  EXPECT_EQ(chrome.name, "chrome");
  EXPECT_EQ(chrome.diffuse_albedo, glm::vec3(0.0f));
  EXPECT_EQ(chrome.specular_reflectance, glm::vec3(0.85f));
  EXPECT_EQ(chrome.roughness, 0.1f);
}

}  // namespace
}  // namespace pleinair::mesh_io_test
