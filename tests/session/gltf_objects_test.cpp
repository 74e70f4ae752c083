// Virtual objects from glTF files, end to end: as an OBJ's, and where their animation has them.
#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "scene/mesh_io.h"
#include "session/sequence_site.h"
#include "tests/pipeline/ground_stage.h"
#include "tests/render/textured_meshes.h"
#include "tests/scene/gltf_file.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::gltf_objects_test {
namespace {

// A box on the ground, in numbers that text keeps.
Mesh Box() {
  Mesh mesh;
  AddBox(mesh, {-0.5f, -0.25f, 0.0f}, {0.25f, 0.5f, 0.75f});
  return mesh;
}

std::string ObjOf(const Mesh& mesh) {
  std::string text = "mtllib a.mtl\nusemtl clay\n";
  const auto line = [&](const char* key, const glm::vec3& v) {
    text += std::string(key) + " " + std::to_string(v.x) + " " + std::to_string(v.y) + " " +
            std::to_string(v.z) + "\n";
  };
  for (const glm::vec3& position : mesh.positions_m) line("v", position);
  for (const glm::vec3& normal : mesh.normals) line("vn", normal);
  for (const glm::uvec3& triangle : mesh.triangles) {
    text += "f";
    for (int c = 0; c < 3; ++c) {
      const std::string index = std::to_string(triangle[c] + 1);
      text += " " + index;
      text += "//" + index;
    }
    text += "\n";
  }
  return text;
}

// +Y up, the front towards +Z.
Mesh InGltfAxes(Mesh mesh) {
  for (glm::vec3& p : mesh.positions_m) p = {p.x, p.z, -p.y};
  for (glm::vec3& n : mesh.normals) n = {n.x, n.z, -n.y};
  return mesh;
}

GltfFile BoxFile(float metallic) {
  GltfFile file;
  file.document["materials"] = {{{"name", "clay"},
                                 {"pbrMetallicRoughness",
                                  {{"baseColorFactor", {0.5, 0.25, 0.125, 1.0}},
                                   {"metallicFactor", metallic},
                                   {"roughnessFactor", 0.5}}}}};
  file.AddMesh(InGltfAxes(Box()), 0);
  file.document["nodes"] = {{{"mesh", 0}}};
  return file;
}

class GltfObjects : public testing::Test {
 protected:
  static void SetUpTestSuite() { stage_ = std::make_unique<GroundStage>(); }
  static void TearDownTestSuite() { stage_.reset(); }
  static std::unique_ptr<GroundStage> stage_;
};

std::unique_ptr<GroundStage> GltfObjects::stage_;

// A dielectric and a metal, against OBJ materials with the values that the specification gives.
TEST_F(GltfObjects, AreLitAsTheSameObj) {
  const TemporaryFolder folder;
  for (const bool metal : {false, true}) {
    folder.Write("a.mtl",
                 metal ? "newmtl clay\nKd 0 0 0\nKs 0.5 0.25 0.125\nPr 0.5\n"
                       : "newmtl clay\nKd 0.5 0.25 0.125\nKs 0.04 0.04 0.04\nPr 0.5\n");
    const LoadedParts obj =
        LoadMeshParts(folder.Write("a.obj", ObjOf(Box())), MeshColours::kByPlace);
    const LoadedParts gltf = LoadMeshParts(
        folder.Write("a.glb", BoxFile(metal ? 1.0f : 0.0f).Binary()), MeshColours::kByPlace);
    ASSERT_EQ(gltf.parts.size(), 1u);
    const FramePipelineOptions options = GroundStage::QuickOptions();
    const Composite expected =
        std::move(stage_->Run({{obj.parts[0].mesh}}, options).front().composite);
    const Composite found =
        std::move(stage_->Run({{gltf.parts[0].mesh}}, options).front().composite);
    EXPECT_EQ(found.change.pixels, expected.change.pixels);
    for (std::size_t i = 0; i < found.radiance.pixels.size(); ++i) {
      // Half float's step, relative: the rounding of 0.04 and of (1 - metallic).
      ASSERT_NEAR(found.radiance.pixels[i].r,
                  expected.radiance.pixels[i].r,
                  1e-3 * expected.radiance.pixels[i].r)
          << "metal " << metal << ", pixel " << i;
    }
  }
}

constexpr const char* kSequence = R"({"format": "pleinair-sequence", "version": 1,
"site": {"latitude_deg": 45, "longitude_deg": 0, "height_m": 0},
"camera": {"width": 96, "height": 72, "fx": 100, "fy": 100, "cx": 47.5, "cy": 35.5,
 "camera_from_world": [[1,0,0,0],[0,0,-1,1.5],[0,1,0,6],[0,0,0,1]]},
"scene": {"mesh": "ground.obj", "albedos_known": true},
"virtual_objects": [
 {"mesh": "box.glb", "world_from_object": [[0,-1,0,2],[1,0,0,0],[0,0,1,0],[0,0,0,1]]},
 {"mesh": "still.obj", "world_from_object": [[1,0,0,-3],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}],
"frames": [{"image": "0.exr", "time_utc": "2026-06-21T12:00:00Z"},
 {"image": "1.exr", "time_utc": "2026-06-21T12:00:00.500Z"},
 {"image": "2.exr", "time_utc": "2026-06-21T12:00:04.250Z"}]})";

// The box goes 4 m along the file's x in 2 s, which the sequence turns to the north; after 4.25 s
// it is on its third way.
TEST_F(GltfObjects, AreWhereTheirAnimationHasThemAtAFramesTime) {
  const TemporaryFolder folder;
  GltfFile box = BoxFile(0.0f);
  box.AddTrack(0, "translation", {0.0f, 2.0f}, {0.0f, 0.0f, 0.0f, 4.0f, 0.0f, 0.0f});
  folder.Write("box.glb", box.Binary());
  folder.Write("a.mtl", "newmtl clay\n");
  folder.Write("still.obj", ObjOf(Box()));
  folder.Write("ground.obj", "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n");
  folder.Write("sequence.json", kSequence);
  const Sequence sequence = ReadSequence(folder.Path());
  const SequenceSite site = LoadSequenceSite(sequence);
  ASSERT_EQ(site.objects.size(), 2u);
  EXPECT_TRUE(site.motions[0].of_part.Moves());
  EXPECT_FALSE(site.motions[1].of_part.Moves());
  const auto poses = [&](std::size_t frame) {
    return ObjectPosesAt(site.motions,
                         SecondsSinceFirstFrame(sequence, sequence.frames[frame].time));
  };
  EXPECT_EQ(poses(0), std::vector<glm::dmat4>(2, glm::dmat4(1.0)));
  for (const auto& [frame, north_m] : {std::pair{1, 1.0}, std::pair{2, 0.5}}) {
    const glm::dvec4 moved =
        poses(static_cast<std::size_t>(frame))[0] * glm::dvec4(2.0, 0.0, 0.3, 1.0);
    EXPECT_NEAR(glm::distance(moved, glm::dvec4(2.0, north_m, 0.3, 1.0)), 0.0, 1e-6);
    EXPECT_EQ(poses(static_cast<std::size_t>(frame))[1], glm::dmat4(1.0));
  }
  // Around both objects wherever they get in these frames: 1 m to the north at most.
  EXPECT_NEAR(site.probe_box.lower_m.x, -3.5f, 1e-4f);
  EXPECT_NEAR(site.probe_box.upper_m.y, 1.25f, 1e-4f);

  // Lit there as a box that stands there.
  const FramePipelineOptions options = GroundStage::QuickOptions();
  std::vector<VirtualObject> there = site.objects;
  there[0].mesh = TransformMesh(poses(1)[0], there[0].mesh);
  EXPECT_EQ(stage_->Run(site.objects, options, {{}, poses(1)})[1].composite.radiance.pixels,
            stage_->Run(there, options)[0].composite.radiance.pixels);
}

// A board over the ground of which a texture leaves the eastern half: its soft shadow is that of
// half a board.
TEST_F(GltfObjects, WhatATextureCutsOutCastsNoShadow) {
  const auto board = [](float from_x_m) {
    Mesh mesh;
    mesh.positions_m = {
        {from_x_m, -0.6f, 0.8f}, {1.0f, -0.6f, 0.8f}, {1.0f, 0.6f, 0.8f}, {from_x_m, 0.6f, 0.8f}};
    mesh.normals.assign(4, {0, 0, 1});
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.triangle_material = mesh.triangle_group = {0, 0};
    mesh.materials.resize(1);
    mesh.group_names = {"board"};
    return mesh;
  };
  Texture::Codes codes(64, 1, glm::u8vec4(188, 188, 188, 255));
  for (int x = 0; x < 32; ++x) codes.At(x, 0).a = 0;
  const auto painted = test::Painted(std::move(codes));
  painted->base_colour = glm::vec3(1.0f);
  painted->alpha_cutoff = 0.5f;
  painted->wraps = {TextureWrap::kClamp, TextureWrap::kClamp};
  const Mesh cut = test::Textured(board(-1.0f), painted, [](const glm::vec3& p) {
    return glm::vec2(0.5f * (p.x + 1.0f), 0.5f);
  });
  Mesh half = board(0.0f);
  half.materials[0] = painted->Mean();
  const FramePipelineOptions options = GroundStage::QuickOptions();
  const Composite found = std::move(stage_->Run({{cut}}, options).front().composite);
  const Composite expected = std::move(stage_->Run({{half}}, options).front().composite);
  const Composite whole = std::move(stage_->Run({{board(-1.0f)}}, options).front().composite);
  const float sunlit = stage_->MakeFrame().radiance.pixels.front().r;
  const auto shadow_of = [&](const Composite& composite) {
    std::vector<bool> in_shadow;
    for (std::size_t i = 0; i < composite.radiance.pixels.size(); ++i) {
      in_shadow.push_back(composite.change.pixels[i] ==
                              static_cast<std::uint8_t>(PixelChange::kScaled) &&
                          composite.radiance.pixels[i].r < 0.6f * sunlit);
    }
    return in_shadow;
  };
  const std::vector<bool> of_half = shadow_of(expected);
  const std::vector<bool> of_cut = shadow_of(found);
  const auto count = std::count(of_half.begin(), of_half.end(), true);
  std::ptrdiff_t otherwise = 0;
  for (std::size_t i = 0; i < of_half.size(); ++i) otherwise += of_half[i] != of_cut[i] ? 1 : 0;
  EXPECT_GT(count, 100);
  // Pixels along its edge, where rays and rounding decide.
  EXPECT_LE(otherwise, count / 20);
  const std::vector<bool> of_whole = shadow_of(whole);
  EXPECT_GT(std::count(of_whole.begin(), of_whole.end(), true), 3 * count / 2);
}

TEST_F(GltfObjects, NothingThatMovesNeedsNoPoses) {
  SequenceSite site;
  site.motions.resize(2);
  EXPECT_TRUE(ObjectPosesAt(site.motions, 3.0).empty());
}

}  // namespace
}  // namespace pleinair::gltf_objects_test
