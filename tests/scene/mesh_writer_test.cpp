#include "scene/mesh_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/mesh_io.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::mesh_writer_test {
namespace {

const std::filesystem::path kScene = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard/scene.obj";

TEST(WriteObj, ReadsBackAsTheSameMesh) {
  const TemporaryFolder folder;
  const Mesh mesh = LoadMesh(kScene).mesh;
  WriteObj(mesh, folder / "copy.obj");
  const Mesh copy = LoadMesh(folder / "copy.obj").mesh;
  ASSERT_EQ(copy.triangles.size(), mesh.triangles.size());
  EXPECT_EQ(copy.group_names, mesh.group_names);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int corner = 0; corner < 3; ++corner) {
      const auto at = [&](const Mesh& of) { return of.positions_m[of.triangles[i][corner]]; };
      const auto normal = [&](const Mesh& of) { return of.normals[of.triangles[i][corner]]; };
      EXPECT_EQ(at(copy), at(mesh)) << i;  // To the last bit.
      EXPECT_NEAR(glm::distance(normal(copy), normal(mesh)), 0.0f, 1e-6f) << i;
    }
    const Material& written = mesh.materials[mesh.triangle_material[i]];
    const Material& read = copy.materials[copy.triangle_material[i]];
    EXPECT_EQ(read.name, written.name);
    EXPECT_EQ(read.diffuse_albedo, written.diffuse_albedo);
    EXPECT_EQ(copy.group_names[copy.triangle_group[i]], mesh.group_names[mesh.triangle_group[i]]);
  }
}

TEST(WriteObj, MakesOneWordOfANameWithBlanks) {
  const TemporaryFolder folder;
  Mesh mesh = LoadMesh(kScene).mesh;
  mesh.group_names.front() = "north wall";
  WriteObj(mesh, folder / "copy.obj");
  EXPECT_THAT(LoadMesh(folder / "copy.obj").mesh.group_names, testing::Contains("north_wall"));
}

TEST(WriteObj, RefusesAnEmptyMesh) {
  const TemporaryFolder folder;
  EXPECT_THROW(WriteObj({}, folder / "empty.obj"), std::invalid_argument);
  EXPECT_EQ(folder.FileCount(), 0u);
}

}  // namespace
}  // namespace pleinair::mesh_writer_test
