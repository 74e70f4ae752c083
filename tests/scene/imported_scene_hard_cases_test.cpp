#include "scene/internal/imported_scene.h"

#include <random>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scene/temporary_folder.h"

namespace pleinair::imported_scene_hard_cases_test {
namespace {

using testing::HasSubstr;

ImportedScene Small() {
  ImportedScene scene;
  ImportedMesh mesh;
  mesh.name = "square";
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.normals.assign(4, {0, 0, 1});
  mesh.texture_uv = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  scene.meshes = {mesh};
  ImportedMaterial material;
  material.name = "stone";
  material.base_texture.name = "*0";
  material.base_texture.embedded = 0;
  material.emits = true;
  scene.materials = {material};
  scene.pictures = {{std::byte{1}, std::byte{2}}};
  scene.root.name = "root";
  scene.root.children.resize(2);
  scene.root.children[1].meshes = {0};
  scene.root.children[1].parent_from_node[3] = {1.0, 2.0, 3.0, 1.0};
  return scene;
}

TEST(ImportedSceneHardCases, ComesBackFromItsBytes) {
  const std::string bytes = BytesOf(Small());
  const ImportedScene back = SceneFromBytes(bytes);
  EXPECT_EQ(BytesOf(back), bytes);
  EXPECT_EQ(back.meshes.at(0).triangles.at(1), glm::uvec3(0, 2, 3));
  EXPECT_EQ(back.meshes[0].texture_uv.at(0).at(2), glm::vec2(1, 1));
  EXPECT_EQ(back.root.children.at(1).parent_from_node[3].z, 3.0);
  EXPECT_TRUE(back.materials.at(0).emits);
  EXPECT_EQ(back.pictures.at(0).size(), 2u);
}

TEST(ImportedSceneHardCases, RefusesWhatIsCutOff) {
  const std::string bytes = BytesOf(Small());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_THROW(SceneFromBytes(std::string_view(bytes).substr(0, length)), std::runtime_error);
  }
  EXPECT_THROW(SceneFromBytes(bytes + "x"), std::runtime_error);
}

TEST(ImportedSceneHardCases, RefusesWhatIsNotThere) {
  const auto message = [](const auto& change) {
    ImportedScene scene = Small();
    change(scene);
    return MessageOf([&] { SceneFromBytes(BytesOf(scene)); });
  };
  EXPECT_EQ(message([](auto&) {}), "");
  EXPECT_THAT(message([](auto& scene) { scene.meshes[0].triangles[1].z = 4; }),
              HasSubstr("corner 4 of a mesh with 4 vertices"));
  EXPECT_THAT(message([](auto& scene) { scene.root.children[0].meshes = {1}; }),
              HasSubstr("a mesh that is not there"));
  EXPECT_THAT(message([](auto& scene) { scene.meshes[0].normals.pop_back(); }),
              HasSubstr("without their normals"));
}

// Whatever the bytes are: a refusal, or a scene that can be walked.
TEST(ImportedSceneHardCases, DamagedBytesNeverCrash) {
  constexpr unsigned kSeed = 5;
  std::mt19937 random(kSeed);
  const std::string bytes = BytesOf(Small());
  int accepted = 0;
  int refused = 0;
  for (int trial = 0; trial < 5000; ++trial) {
    std::string damaged = bytes;
    for (int i = 0; i < 3; ++i) damaged[random() % damaged.size()] = static_cast<char>(random());
    try {
      const ImportedScene scene = SceneFromBytes(damaged);
      for (const ImportedMesh& mesh : scene.meshes) {
        for (const glm::uvec3& triangle : mesh.triangles) {
          for (int c = 0; c < 3; ++c) ASSERT_LT(triangle[c], mesh.positions.size());
        }
      }
      ++accepted;
    } catch (const std::runtime_error&) {
      ++refused;
    }
  }
  EXPECT_GT(accepted, 100);
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace pleinair::imported_scene_hard_cases_test
