#include "scene/mesh_io.h"

#include <cmath>
#include <filesystem>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/scene/gltf_file.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::mesh_io_hard_cases_test {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

constexpr const char* kCube =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n"
    "f 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\nf 1 3 4 2\nf 5 6 8 7\n";

LoadedMesh Load(const TemporaryFolder& folder, const std::string& obj) {
  return LoadMesh(folder.Write("a.obj", obj));
}

std::string LoadingMessage(const std::filesystem::path& file) {
  return MessageOf([&] { LoadMesh(file); });
}

double Area(const Mesh& mesh) {
  double twice = 0.0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a(mesh.positions_m[t.x]);
    twice += glm::length(
        glm::cross(glm::dvec3(mesh.positions_m[t.y]) - a, glm::dvec3(mesh.positions_m[t.z]) - a));
  }
  return twice / 2.0;
}

void ExpectConsistent(const Mesh& mesh) {
  ASSERT_EQ(mesh.normals.size(), mesh.positions_m.size());
  ASSERT_EQ(mesh.triangle_material.size(), mesh.triangles.size());
  ASSERT_EQ(mesh.triangle_group.size(), mesh.triangles.size());
  for (std::size_t v = 0; v < mesh.normals.size(); ++v) {
    ASSERT_NEAR(glm::length(mesh.normals[v]), 1.0f, 1e-6f);
    ASSERT_TRUE(std::isfinite(glm::length(mesh.positions_m[v])));
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int c = 0; c < 3; ++c) ASSERT_LT(mesh.triangles[t][c], mesh.positions_m.size());
    ASSERT_LT(mesh.triangle_material[t], mesh.materials.size());
    ASSERT_LT(mesh.triangle_group[t], mesh.group_names.size());
    ASSERT_NE(TriangleNormal(mesh, static_cast<std::uint32_t>(t)), glm::vec3(0.0f));
  }
}

TEST(MeshIoHardCases, CleanCubeIsClean) {
  const TemporaryFolder folder;
  const LoadedMesh loaded = Load(folder, kCube);
  ExpectConsistent(loaded.mesh);
  EXPECT_TRUE(loaded.report.IsClosedManifold());
  EXPECT_EQ(loaded.report.misoriented_edges, 0);
  EXPECT_EQ(loaded.mesh.triangles.size(), 12u);
  // A cube keeps its edges: three normals a corner.
  EXPECT_EQ(loaded.mesh.positions_m.size(), 24u);
  EXPECT_EQ(loaded.report.normals_computed, 24);
  EXPECT_EQ(loaded.report.Summary(), "24 normals computed");
}

TEST(MeshIoHardCases, RemovesTrianglesWithoutArea) {
  const TemporaryFolder folder;
  // A point, a doubled corner, and three collinear corners that rounding to float pulls apart.
  const LoadedMesh loaded = Load(folder,
                                 std::string(kCube) +
                                     "v 0.1 0.1 0.7\nv 0.2 0.2 0.7\nv 0.3 0.3 0.7\n"
                                     "f 1 1 1\nf 1 2 2\nf 9 10 11\n");
  EXPECT_EQ(loaded.report.degenerate_triangles_removed, 3);
  EXPECT_EQ(loaded.mesh.triangles.size(), 12u);
  EXPECT_TRUE(loaded.report.IsClosedManifold());
}

TEST(MeshIoHardCases, KeepsSliversThatHaveAnArea) {
  const TemporaryFolder folder;
  const LoadedMesh loaded = Load(folder, "v 0 0 0\nv 10 0 0\nv 5 0.001 0\nf 1 2 3\n");
  EXPECT_EQ(loaded.mesh.triangles.size(), 1u);
  EXPECT_NEAR(Area(loaded.mesh), 0.005, 1e-8);
}

TEST(MeshIoHardCases, RemovesDuplicatesButNotTheOtherSide) {
  const TemporaryFolder folder;
  const LoadedMesh loaded = Load(folder,
                                 "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\n"
                                 "f 1 2 3\nf 2 3 1\nf 4 2 3\nf 1 3 2\n");
  EXPECT_EQ(loaded.report.duplicate_triangles_removed, 2);
  EXPECT_EQ(loaded.mesh.triangles.size(), 2u);
  EXPECT_EQ(TriangleNormal(loaded.mesh, 0), -TriangleNormal(loaded.mesh, 1));
  // Both sides have shading normals of their own.
  EXPECT_EQ(loaded.mesh.positions_m.size(), 6u);
}

TEST(MeshIoHardCases, RemovesTrianglesThatAreNotFinite) {
  const TemporaryFolder folder;
  const LoadedMesh loaded =
      Load(folder, std::string(kCube) + "v nan 0 0\nv 0 inf 0\nf 1 2 9\nf 10 2 3\nf 9 10 1 2\n");
  ExpectConsistent(loaded.mesh);
  EXPECT_GE(loaded.report.non_finite_triangles_removed, 3);
  EXPECT_EQ(loaded.mesh.triangles.size(), 12u);
}

TEST(MeshIoHardCases, ReportsEdgesThatAreOpenOrSharedByThree) {
  const TemporaryFolder folder;
  const LoadedMesh fin =
      Load(folder, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 1 2 4\nf 1 2 5\n");
  EXPECT_EQ(fin.report.open_edges, 6);
  EXPECT_EQ(fin.report.non_manifold_edges, 1);
  EXPECT_FALSE(fin.report.IsClosedManifold());
}

TEST(MeshIoHardCases, ReportsFlippedTriangles) {
  const TemporaryFolder folder;
  // One face of the cube turned round: it disagrees with its four neighbours.
  std::string flipped = kCube;
  flipped.replace(flipped.find("f 5 6 8 7"), 9, "f 5 7 8 6");
  const LoadedMesh loaded = Load(folder, flipped);
  EXPECT_TRUE(loaded.report.IsClosedManifold());
  EXPECT_EQ(loaded.report.misoriented_edges, 4);
}

TEST(MeshIoHardCases, NotesAMeshThatIsInsideOut) {
  const TemporaryFolder folder;
  const LoadedMesh loaded = Load(folder,
                                 "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                 "f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n");
  EXPECT_TRUE(loaded.report.IsClosedManifold());
  EXPECT_THAT(loaded.report.notes, Contains(HasSubstr("inside out")));
}

TEST(MeshIoHardCases, ComputesNormalsThatAreMissingOrZero) {
  const TemporaryFolder folder;
  const LoadedMesh loaded = Load(folder,
                                 "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nvn nan 0 0\nvn 0 0 1\n"
                                 "f 1//1 2//2 3//3\n");
  ExpectConsistent(loaded.mesh);
  EXPECT_EQ(loaded.report.normals_computed, 2);
  for (const glm::vec3& normal : loaded.mesh.normals) {
    EXPECT_EQ(normal, glm::vec3(0.0f, 0.0f, 1.0f));
  }
}

// A sphere without normals: smooth, so close to the radius. 13 faces a quarter give 4 degrees.
TEST(MeshIoHardCases, SmoothsWhatIsRound) {
  std::string sphere;
  constexpr int kRings = 40;
  constexpr int kSegments = 80;
  for (int ring = 1; ring < kRings; ++ring) {
    for (int segment = 0; segment < kSegments; ++segment) {
      const double polar = M_PI * ring / kRings;
      const double azimuth = 2.0 * M_PI * segment / kSegments;
      sphere += std::string("v ") + std::to_string(std::sin(polar) * std::cos(azimuth)) + " " +
                std::to_string(std::sin(polar) * std::sin(azimuth)) + " " +
                std::to_string(std::cos(polar)) + "\n";
    }
  }
  const auto vertex = [](int ring, int segment) {
    return std::to_string((ring - 1) * kSegments + segment % kSegments + 1);
  };
  for (int ring = 1; ring + 1 < kRings; ++ring) {
    for (int segment = 0; segment < kSegments; ++segment) {
      sphere += std::string("f ") + vertex(ring, segment) + " " + vertex(ring + 1, segment) + " " +
                vertex(ring + 1, segment + 1) + " " + vertex(ring, segment + 1) + "\n";
    }
  }
  const TemporaryFolder folder;
  const LoadedMesh loaded = Load(folder, sphere);
  ASSERT_EQ(loaded.mesh.positions_m.size(), static_cast<std::size_t>((kRings - 1) * kSegments));
  for (std::size_t v = 0; v < loaded.mesh.positions_m.size(); ++v) {
    const double cosine = glm::dot(glm::dvec3(glm::normalize(loaded.mesh.positions_m[v])),
                                   glm::dvec3(loaded.mesh.normals[v]));
    EXPECT_GT(cosine, std::cos(0.07));
  }
}

// Random star-shaped polygons, most of them concave: the triangles cover the polygon's area, all
// facing the same way.
TEST(MeshIoHardCases, CutsConcavePolygonsWithoutOverlap) {
  constexpr unsigned kSeed = 21;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> radius(0.2, 1.0);
  const TemporaryFolder folder;
  int concave = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const int corners = 5 + trial % 20;
    std::string obj;
    std::string face = "f";
    std::vector<glm::dvec2> points;
    for (int i = 0; i < corners; ++i) {
      const double angle = 2.0 * M_PI * i / corners;
      const double r = radius(random);
      points.push_back({r * std::cos(angle), r * std::sin(angle)});
      obj += std::string("v ") + std::to_string(points.back().x) + " " +
             std::to_string(points.back().y) + " 0.25\n";
      face += std::string(" ") + std::to_string(i + 1);
    }
    double area = 0.0;
    bool is_concave = false;
    const auto cross = [](const glm::dvec2& a, const glm::dvec2& b) {
      return a.x * b.y - a.y * b.x;
    };
    for (std::size_t i = 0; i < points.size(); ++i) {
      const glm::dvec2& next = points[(i + 1) % points.size()];
      const glm::dvec2& after = points[(i + 2) % points.size()];
      area += cross(points[i], next) / 2.0;
      is_concave = is_concave || cross(next - points[i], after - next) < 0.0;
    }
    if (is_concave) ++concave;
    const Mesh mesh = Load(folder, obj + face + "\n").mesh;
    EXPECT_EQ(mesh.triangles.size(), static_cast<std::size_t>(corners - 2)) << "seed " << kSeed;
    EXPECT_NEAR(Area(mesh), area, 1e-5) << "seed " << kSeed << " trial " << trial;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      EXPECT_EQ(TriangleNormal(mesh, t), glm::vec3(0.0f, 0.0f, 1.0f));
    }
  }
  EXPECT_GT(concave, 30);
}

TEST(MeshIoHardCases, RefusesCoordinatesFarFromTheOrigin) {
  const TemporaryFolder folder;
  const std::filesystem::path file =
      folder.Write("far.obj", "v 10000000 0 0\nv 10000001 0 0\nv 10000000 1 0\nf 1 2 3\n");
  EXPECT_THAT(LoadingMessage(file), StartsWith(file.string() + ": coordinate 10000000"));
  EXPECT_THAT(LoadingMessage(file), HasSubstr("local origin"));
}

TEST(MeshIoHardCases, NamesTheFileThatCannotBeRead) {
  const TemporaryFolder folder;
  for (const char* name : {"a.obj", "a.ply", "a.stl", "a.glb", "a.gltf"}) {
    EXPECT_EQ(LoadingMessage(folder / name), (folder / name).string() + ": no such file");
    EXPECT_THAT(LoadingMessage(folder.Write(name, "")), HasSubstr("empty"));
    for (const char* content : {"some text that is no mesh\n", "\x01\x02\x03", "ply\n", "glTF"}) {
      const std::string message = LoadingMessage(folder.Write(name, content));
      EXPECT_THAT(message, StartsWith((folder / name).string() + ": ")) << content;
      EXPECT_THAT(message, Not(HasSubstr("\n")));
    }
  }
  EXPECT_THAT(LoadingMessage(folder.Write("a.txt", "x")), HasSubstr("expected a .obj"));
  EXPECT_THAT(LoadingMessage(folder.Write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n")),
              StartsWith((folder / "a.obj").string() + ": "));
  EXPECT_THAT(LoadingMessage(folder.Write("a.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n")),
              HasSubstr("no triangle"));
  EXPECT_THAT(LoadingMessage(folder.Write("a.obj", "v 0 0 0\nv 1 0 0\nf 1 2 99\n")),
              StartsWith((folder / "a.obj").string() + ": "));
}

TEST(MeshIoHardCases, NamesTheMaterialThatIsWrong) {
  const TemporaryFolder folder;
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl stone\nf 1 2 3\n";
  const std::filesystem::path obj = folder.Write("a.obj", "mtllib a.mtl\n" + triangle);
  const auto message_for = [&](const std::string& library) {
    folder.Write("a.mtl", library);
    return LoadingMessage(obj);
  };
  EXPECT_EQ(message_for("newmtl stone\nKd 0.5 0.5 0.5\n"), "");
  EXPECT_THAT(message_for("newmtl brick\nKd 0.5 0.5 0.5\n"), HasSubstr("usemtl 'stone'"));
  for (const char* line : {"Kd 0.5 x 0.5",
                           "Kd 0.5 0.5",
                           "Kd nan 0 0",
                           "Kd -1 0 0",
                           "Pr 1.5",
                           "Ns -3",
                           "Ks inf 0 0",
                           "Kd"}) {
    EXPECT_THAT(message_for(std::string("newmtl stone\n") + line + "\n"),
                StartsWith((folder / "a.mtl").string() + ":2: "))
        << line;
  }
  EXPECT_THAT(message_for("Kd 0.5 0.5 0.5\n"), HasSubstr("before the first newmtl"));
}

TEST(MeshIoHardCases, AMissingLibraryIsNoted) {
  const TemporaryFolder folder;
  const LoadedMesh loaded =
      Load(folder, "mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl stone\nf 1 2 3\n");
  EXPECT_EQ(loaded.mesh.materials[0].diffuse_albedo, glm::vec3(0.5f));
  EXPECT_EQ(loaded.mesh.materials[0].name, "stone");
  EXPECT_THAT(loaded.report.notes, Contains(HasSubstr("gone.mtl")));
}

TEST(MeshIoHardCases, ReadsFilesOfTheCurrentFolder) {
  const TemporaryFolder folder;
  folder.Write("a.mtl", "newmtl stone\nKd 0.1 0.2 0.3\n");
  folder.Write("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl stone\nf 1 2 3\n");
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.Path());
  const std::string message = LoadingMessage("a.obj");
  const std::string also = LoadingMessage("./a.obj");
  std::filesystem::current_path(before);
  EXPECT_EQ(message, "");
  EXPECT_EQ(also, "");
}

TEST(MeshIoHardCases, ReadsNothingOutsideTheFolder) {
  const TemporaryFolder folder;
  folder.Write("secret.mtl", "newmtl stone\nKd 0.1 0.1 0.1\n");
  std::filesystem::create_directory(folder / "inner");
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl stone\nf 1 2 3\n";
  for (const std::string& name : {std::string("../secret.mtl"), (folder / "secret.mtl").string()}) {
    std::string text = "mtllib ";
    text.append(name).append("\n").append(triangle);
    const std::filesystem::path obj = folder.Write("inner/a.obj", text);
    EXPECT_THAT(LoadingMessage(obj), StartsWith(obj.string() + ":1: mtllib")) << name;
  }
  folder.Write("secret.bin", std::string(36, '\0'));
  const std::filesystem::path gltf = folder.Write(
      "inner/a.gltf",
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
"bufferViews":[{"buffer":0,"byteLength":36}],
"buffers":[{"byteLength":36,"uri":"../secret.bin"}]})");
  EXPECT_THAT(LoadingMessage(gltf), HasSubstr("not a readable mesh"));
}

TEST(MeshIoHardCases, DamagedFilesNeverCrash) {
  const TemporaryFolder folder;
  constexpr unsigned kSeed = 22;
  std::mt19937 random(kSeed);
  for (int trial = 0; trial < 80; ++trial) {
    std::string damaged = kCube;
    for (int i = 0; i < 4; ++i) damaged[random() % damaged.size()] = static_cast<char>(random());
    const std::filesystem::path file = folder.Write("a.obj", damaged);
    try {
      ExpectConsistent(LoadMesh(file).mesh);
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), StartsWith(file.string())) << "seed " << kSeed;
      EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
    }
  }
}

constexpr const char* kPly =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n1 1 .5\n0 1 0\n4 0 1 2 3\n";

// `text` with its first `from` replaced.
std::string Changed(std::string text, std::string_view from, std::string_view to) {
  return text.replace(text.find(from), from.size(), to);
}

// assimp crashes on the first three, and reads the last two without end.
TEST(MeshIoHardCases, RefusesDamagedPly) {
  const TemporaryFolder folder;
  EXPECT_EQ(LoadingMessage(folder.Write("a.ply", kPly)), "");
  const std::string cut_off = std::string(kPly).substr(0, std::string(kPly).find("4 0 1 2 3"));
  for (const std::string& text : {Changed(kPly, "4 0 1 2 3", "4 0 1 99999999 3"),
                                  Changed(kPly, "ascii", "binary_little_endian"),
                                  Changed(cut_off, "face 1", "face 2")}) {
    EXPECT_THAT(LoadingMessage(folder.Write("a.ply", text)),
                StartsWith((folder / "a.ply").string() + ": not a readable mesh ("))
        << text;
  }
  const std::string no_end = std::string(kPly).substr(0, std::string(kPly).find("end_header"));
  EXPECT_THAT(LoadingMessage(folder.Write("a.ply", no_end)), HasSubstr("expected `end_header`"));
  // The lines end in one way, whichever.
  std::string of_cr = kPly;
  std::replace(of_cr.begin(), of_cr.end(), '\n', '\r');
  EXPECT_EQ(LoadingMessage(folder.Write("a.ply", of_cr)), "");
  EXPECT_THAT(
      LoadingMessage(folder.Write("a.ply", Changed(kPly, "end_header\n", "\rend_header\r"))),
      HasSubstr(": line 9: expected `comment`"));
  EXPECT_THAT(LoadingMessage(folder.Write("a.ply", Changed(kPly, "ascii 1.0\n", "ascii 1.0\r"))),
              HasSubstr(": line 2: expected `comment`"));
  EXPECT_THAT(LoadingMessage(folder.Write("a.ply", Changed(kPly, "format", "formal"))),
              HasSubstr(": line 2: expected `comment`"));
  for (const char* count : {"100000000", "-1", "99999999999999999999", ""}) {
    EXPECT_THAT(LoadingMessage(
                    folder.Write("a.ply", Changed(kPly, "face 1", std::string("face ") + count))),
                HasSubstr("expected no more elements than the file has bytes"))
        << count;
  }
}

// A file of these nodes around one triangle.
std::string GltfOfNodes(const nlohmann::json& nodes, const nlohmann::json& extras = nullptr) {
  GltfFile file;
  file.AddMesh(Square());
  file.document["nodes"] = nodes;
  if (!extras.is_null()) file.document["extras"] = extras;
  return file.Text();
}

TEST(MeshIoHardCases, RefusesGltfNestedTooDeeply) {
  const TemporaryFolder folder;
  const std::string text = GltfOfNodes({{{"mesh", 0}}});
  EXPECT_EQ(LoadingMessage(folder.Write("a.gltf", text)), "");
  for (const std::size_t levels : {100u, 1'000'000u}) {
    const std::string deep = text.substr(0, text.size() - 1) +
                             ",\"extras\":" + std::string(levels, '[') + std::string(levels, ']') +
                             "}";
    EXPECT_THAT(LoadingMessage(folder.Write("a.gltf", deep)),
                HasSubstr("expected at most 64 levels of nesting"));
  }
  const std::string quoted =
      text.substr(0, text.size() - 1) + ",\"extras\":\"" + std::string(1000, '[') + "\\\"[\"}";
  EXPECT_EQ(LoadingMessage(folder.Write("a.gltf", quoted)), "");
}

TEST(MeshIoHardCases, RefusesGltfNodesThatAreNoTrees) {
  const TemporaryFolder folder;
  const auto chain = [](int length, int children) {
    nlohmann::json nodes = nlohmann::json::array();
    for (int i = 1; i < length; ++i) {
      nodes.push_back({{"children", std::vector<int>(static_cast<std::size_t>(children), i)}});
    }
    nodes.push_back({{"mesh", 0}});
    return GltfOfNodes(nodes);
  };
  EXPECT_EQ(LoadingMessage(folder.Write("a.gltf", chain(255, 1))), "");
  for (const int length : {256, 200'000}) {
    EXPECT_THAT(LoadingMessage(folder.Write("a.gltf", chain(length, 1))),
                HasSubstr("nodes[255]: expected at most 255 levels of nodes"));
  }
  EXPECT_THAT(LoadingMessage(folder.Write("a.gltf", chain(31, 2))),
              HasSubstr("nodes[1]: expected one parent at most"));
  EXPECT_THAT(LoadingMessage(folder.Write("a.gltf", GltfOfNodes({{{"children", {0}}}}))),
              HasSubstr("nodes[0]: expected one parent at most"));
}

// Nodes that use one mesh again and again are counted before their triangles are built.
TEST(MeshIoHardCases, RefusesMoreTrianglesThanMemoryHolds) {
  GltfFile file;
  Mesh many = Square();
  many.triangles.assign(17'000, {0, 1, 2});
  file.AddMesh(many);
  for (int i = 0; i < 1000; ++i) {
    file.document["nodes"].push_back({{"mesh", 0}});
    file.document["scenes"][0]["nodes"][static_cast<std::size_t>(i)] = i;
  }
  const TemporaryFolder folder;
  EXPECT_THAT(LoadingMessage(folder.Write("a.glb", file.Binary())),
              HasSubstr("17000000 triangles: expected at most 16777216"));
}

// Counts as published with the files; duplicates here are those of the same winding only.
TEST(MeshIoHardCases, AgreesWithWhatIsKnownOfTheTestMeshes) {
  const std::filesystem::path meshes = std::filesystem::path(PLEINAIR_SHARED_DIR) / "data/meshes";
  if (!std::filesystem::exists(meshes)) GTEST_SKIP() << "the test meshes are not here";
  struct Known {
    const char* name;
    std::size_t triangles;  // Before duplicates are removed.
    std::int64_t open_edges;
    std::int64_t non_manifold_edges;
  };
  for (const Known& known : {Known{"teapot.obj", 6320, 160, 0},
                             Known{"bunny_16k_hard.ply", 16301, 123, 150},
                             Known{"bunny_10k.obj", 9999, 109, 0},
                             Known{"suzanne.obj", 968, 42, 1},
                             Known{"spot.obj", 5856, 0, 0},
                             Known{"soup.stl", 100, 300, 0},
                             Known{"joined_tetrahedra.obj", 8, 0, 3},
                             Known{"negative_indices.obj", 12, 0, 0},
                             Known{"polygonfaces.obj", 3, 5, 0},
                             Known{"Duck.glb", 4212, 0, 0},
                             Known{"BoxTextured.glb", 12, 0, 0}}) {
    const LoadedMesh loaded = LoadMesh(meshes / known.name);
    ExpectConsistent(loaded.mesh);
    const MeshReport& report = loaded.report;
    EXPECT_EQ(
        loaded.mesh.triangles.size() + static_cast<std::size_t>(report.duplicate_triangles_removed),
        known.triangles)
        << known.name;
    EXPECT_EQ(report.degenerate_triangles_removed, 0) << known.name;
    EXPECT_EQ(report.open_edges, known.open_edges) << known.name;
    EXPECT_EQ(report.non_manifold_edges, known.non_manifold_edges) << known.name;
  }
  const LoadedMesh chair = LoadMesh(meshes / "chair_doubled.obj");
  ExpectConsistent(chair.mesh);
  EXPECT_GT(chair.report.non_manifold_edges, 9000);
}

}  // namespace
}  // namespace pleinair::mesh_io_hard_cases_test
