// Pictures and colours of vertices that glTF files show by place.
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "gltf_file.h"
#include "scene/image_io.h"
#include "scene/mesh_io.h"
#include "scene/textured_material.h"
#include "temporary_folder.h"

namespace pleinair::gltf_textures_test {
namespace {

using nlohmann::json;
using testing::Contains;
using testing::HasSubstr;

// glTF's v goes down.
const std::vector<float> kSquareUv{0, 1, 1, 1, 1, 0, 0, 0};

// Red and green above, blue and white below.
Rgb8Image FourColours() {
  Rgb8Image image(16, 16);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; ++x) {
      const bool left = x < 8;
      image.At(x, y) = y < 8 ? (left ? glm::u8vec3(255, 0, 0) : glm::u8vec3(0, 255, 0))
                             : (left ? glm::u8vec3(0, 0, 255) : glm::u8vec3(255));
    }
  }
  return image;
}

struct Shown {
  glm::vec3 at_place{0.0f};
  glm::vec3 of_triangle{0.0f};
};

// The albedo at a point of the square, which stands with its y up: our z.
Shown AlbedoAt(const Mesh& mesh, float x, float z) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::vec3 a = mesh.positions_m[mesh.triangles[t].x];
    const glm::vec3 b = mesh.positions_m[mesh.triangles[t].y];
    const glm::vec3 c = mesh.positions_m[mesh.triangles[t].z];
    const glm::vec3 p(x, a.y, z);
    const auto side = [&](const glm::vec3& from, const glm::vec3& to) {
      return (to.x - from.x) * (p.z - from.z) - (to.z - from.z) * (p.x - from.x);
    };
    const glm::vec3 inside(side(b, c), side(c, a), side(a, b));
    if (inside.x < 0.0f || inside.y < 0.0f || inside.z < 0.0f) continue;
    const Material& material = mesh.materials[mesh.triangle_material[t]];
    Shown shown{material.diffuse_albedo, material.diffuse_albedo};
    if (!material.by_place) return shown;
    const glm::vec3 weight = inside / (inside.x + inside.y + inside.z);
    const TriangleColours& colours = mesh.triangle_colours[t];
    glm::vec2 uv(0.0f);
    glm::vec4 vertex(0.0f);
    for (int k = 0; k < 3; ++k) {
      uv += weight[k] * colours.texture_uv[static_cast<std::size_t>(k)];
      vertex += weight[k] * colours.vertex_colour[static_cast<std::size_t>(k)];
    }
    shown.at_place = material.by_place->Of(glm::vec3(material.by_place->ColourAt(uv, 0.0f, vertex)))
                         .diffuse_albedo;
    return shown;
  }
  ADD_FAILURE() << "no triangle at " << x << ", " << z;
  return {};
}

void AddTexturedSquare(GltfFile& file, int image_view) {
  file.document["images"] = {{{"bufferView", image_view}, {"mimeType", "image/png"}}};
  file.document["textures"] = {{{"source", 0}}};
  file.document["materials"] = {{{"name", "painted"},
                                 {"pbrMetallicRoughness",
                                  {{"baseColorFactor", {0.5, 0.5, 0.5, 1.0}},
                                   {"baseColorTexture", {{"index", 0}}},
                                   {"metallicFactor", 0.0}}}}};
  const int uv = file.AddFloats(kSquareUv, 2);
  file.AddMesh(Square(), 0, {{"TEXCOORD_0", uv}});
  file.document["nodes"] = {{{"mesh", 0}}};
}

void ExpectFourColours(const Mesh& mesh) {
  const auto expect = [&](float x, float z, const glm::vec3& expected) {
    EXPECT_NEAR(glm::distance(AlbedoAt(mesh, x, z).at_place, 0.5f * expected), 0.0, 1e-5);
  };
  for (const float near : {0.05f, 0.45f}) {
    expect(near, 1.0f - near, {1, 0, 0});
    expect(1.0f - near, 1.0f - near, {0, 1, 0});
    expect(near, near, {0, 0, 1});
    expect(1.0f - near, near, {1, 1, 1});
  }
}

// Uncut; what light goes from is the mean over each triangle: the lower right one of the square has
// half of blue and of green, and all of white.
TEST(GltfTextures, ATextureInAGlbIsShownByPlace) {
  const TemporaryFolder folder;
  GltfFile file;
  const std::string png = PngOf(FourColours());
  AddTexturedSquare(file, file.AddBytes(png.data(), png.size()));
  const auto path = folder.Write("a.glb", file.Binary());
  const LoadedMesh loaded = LoadMesh(path, MeshColours::kByPlace);
  EXPECT_EQ(loaded.mesh.triangles.size(), 2u);
  EXPECT_EQ(loaded.mesh.positions_m.size(), 4u);
  EXPECT_TRUE(loaded.report.notes.empty()) << loaded.report.Summary();
  ExpectFourColours(loaded.mesh);
  const glm::vec3 lower = 0.5f * glm::vec3(0.5f, 0.75f, 0.75f);
  // 128 texels of a triangle are looked at, those of its long side with both colours.
  EXPECT_LT(glm::distance(AlbedoAt(loaded.mesh, 0.9f, 0.1f).of_triangle, lower), 0.02f);
  for (const Material& material : loaded.mesh.materials) EXPECT_EQ(material.name, "painted");

  const LoadedMesh mean = LoadMesh(path);
  EXPECT_EQ(mean.mesh.triangles.size(), 2u);
  EXPECT_TRUE(mean.mesh.triangle_colours.empty());
  ASSERT_EQ(mean.mesh.materials.size(), 1u);
  EXPECT_EQ(mean.mesh.materials[0].by_place, nullptr);
  EXPECT_NEAR(glm::distance(mean.mesh.materials[0].diffuse_albedo, glm::vec3(0.25f)), 0.0, 1e-6);
  EXPECT_THAT(mean.report.notes, Contains(HasSubstr("mean colour")));
}

// Mirroring turns triangles over, and what they are looked up in along with them.
TEST(GltfTextures, ATextureStaysInPlaceOnAMirroredNode) {
  const TemporaryFolder folder;
  GltfFile file;
  const std::string png = PngOf(FourColours());
  AddTexturedSquare(file, file.AddBytes(png.data(), png.size()));
  file.document["nodes"][0]["scale"] = {1, 1, -1};
  const Mesh mesh = LoadMesh(folder.Write("a.glb", file.Binary()), MeshColours::kByPlace).mesh;
  const Mesh back = TransformMesh(glm::dmat4(glm::dvec4(1, 0, 0, 0),
                                             glm::dvec4(0, -1, 0, 0),
                                             glm::dvec4(0, 0, 1, 0),
                                             glm::dvec4(0, 0, 0, 1)),
                                  mesh);
  ExpectFourColours(back);
}

// OBJ's v goes up, and the square of the same picture shows the same.
TEST(GltfTextures, AnObjShowsTheSameTextureTheSameWay) {
  const TemporaryFolder folder;
  WritePng(folder / "texture.png", FourColours());
  folder.Write("a.mtl", "newmtl painted\nKd 0.5 0.5 0.5\nmap_Kd texture.png\n");
  ExpectFourColours(
      LoadMesh(folder.Write("a.obj",
                            "mtllib a.mtl\nusemtl painted\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\n"
                            "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"),
               MeshColours::kByPlace)
          .mesh);
}

// A picture in a data URI; its edge repeats, is mirrored or goes on, as the sampler says.
TEST(GltfTextures, SamplersSayWhatIsBeyondTheEdge) {
  const TemporaryFolder folder;
  // A PNG of one row: black, white.
  const std::string uri =
      "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAAAAADRSSBWAAAAC0lEQVR4nGNg+A8AAQIB"
      "AEK+vGgAAAAASUVORK5CYII=";
  const auto at = [&](int wrap, float beyond) {
    GltfFile file;
    AddTexturedSquare(file, 0);
    file.document["images"] = {{{"uri", uri}}};
    file.document["samplers"] = {{{"wrapS", wrap}, {"wrapT", 33071}}};
    file.document["textures"] = {{{"source", 0}, {"sampler", 0}}};
    const Mesh mesh = LoadMesh(folder.Write("a.gltf", file.Text()), MeshColours::kByPlace).mesh;
    const auto& material = mesh.materials[0].by_place;
    if (!material) return -1.0f;
    EXPECT_EQ(material->wraps.v, TextureWrap::kClamp);
    return material->ColourAt({1.0f + beyond, 0.5f}, 0.0f, glm::vec4(1.0f)).r;
  };
  EXPECT_NEAR(at(10497, 0.25f), 0.0f, 1e-5f);
  EXPECT_NEAR(at(33648, 0.25f), 1.0f, 1e-5f);
  EXPECT_NEAR(at(33648, 0.75f), 0.0f, 1e-5f);
  EXPECT_NEAR(at(33071, 0.75f), 1.0f, 1e-5f);
}

// The extension's own example takes the lower left quarter of the picture, turned clockwise.
TEST(GltfTextures, CoordinatesAreTransformedAsTheExtensionSays) {
  const TemporaryFolder folder;
  const std::string png = PngOf(FourColours());
  const auto load = [&](const json& transform) {
    GltfFile file;
    AddTexturedSquare(file, file.AddBytes(png.data(), png.size()));
    file.document["extensionsUsed"] = {"KHR_texture_transform"};
    file.document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = {
        {"KHR_texture_transform", transform}};
    return LoadMesh(folder.Write("a.glb", file.Binary()), MeshColours::kByPlace).mesh;
  };
  const Mesh quarter =
      load({{"offset", {0, 1}}, {"rotation", std::acos(0.0)}, {"scale", {0.5, 0.5}}});
  for (const float x : {0.1f, 0.5f, 0.9f}) {
    for (const float z : {0.1f, 0.4f, 0.9f}) {
      EXPECT_LT(glm::distance(AlbedoAt(quarter, x, z).at_place, glm::vec3(0, 0, 0.5f)), 1e-5f);
    }
  }
  const Mesh turned = load({{"offset", {0.25, -0.5}}, {"rotation", 0.3}, {"scale", {0.5, 2}}});
  for (std::size_t t = 0; t < turned.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::vec3 p = turned.positions_m[turned.triangles[t][static_cast<int>(k)]];
      const glm::dvec2 scaled(0.5 * p.x, 2.0 * (1.0 - p.z));
      const glm::dvec2 expected(0.25 + std::cos(0.3) * scaled.x + std::sin(0.3) * scaled.y,
                                -0.5 - std::sin(0.3) * scaled.x + std::cos(0.3) * scaled.y);
      // assimp keeps its own transform in floats.
      EXPECT_LT(glm::distance(turned.triangle_colours[t].texture_uv[k], glm::vec2(expected)),
                1e-5f);
    }
  }
}

TEST(GltfTextures, TrianglesWithoutUsableCoordinatesHaveTheTexturesMean) {
  const TemporaryFolder folder;
  const std::string png = PngOf(FourColours());
  const float nan = std::nanf("");
  for (const std::vector<float>& uv :
       {std::vector<float>{}, {0, 1, 1, 1, 1, nan, 0, 0}, {0, 1, 1, 1, 1, 1e9f, 0, 0}}) {
    GltfFile file;
    AddTexturedSquare(file, file.AddBytes(png.data(), png.size()));
    if (uv.empty()) {
      file.document["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_0");
    } else {
      const int accessor = file.AddFloats(uv, 2);
      file.document["accessors"][accessor].erase("min");
      file.document["accessors"][accessor].erase("max");
      file.document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = accessor;
    }
    const LoadedMesh loaded = LoadMesh(folder.Write("a.glb", file.Binary()), MeshColours::kByPlace);
    const Shown shown = AlbedoAt(loaded.mesh, 0.9f, 0.2f);
    EXPECT_LT(glm::distance(shown.at_place, glm::vec3(0.25f)), 1e-5f);
    EXPECT_EQ(shown.at_place, shown.of_triangle);
    EXPECT_THAT(loaded.report.notes, Contains(HasSubstr("2 triangles without texture")));
  }
}

TEST(GltfTextures, APictureThatCannotBeReadIsAnErrorWhereItWouldBeSeen) {
  const TemporaryFolder folder;
  GltfFile file;
  AddTexturedSquare(file, 0);
  for (const char* image : {"none.png", "no_picture.png", "../outside.png"}) {
    folder.Write("no_picture.png", "\x89PNG\r\n\x1a\nrubbish");
    file.document["images"] = {{{"uri", image}}};
    const auto path = folder.Write("a.gltf", file.Text());
    const std::string message = MessageOf([&] { LoadMesh(path, MeshColours::kByPlace); });
    EXPECT_THAT(message, HasSubstr("a.gltf"));
    EXPECT_THAT(message, HasSubstr(image));
    EXPECT_THAT(message, HasSubstr("painted"));
    EXPECT_EQ(message.find('\n'), std::string::npos);
    EXPECT_THAT(LoadMesh(path).report.notes, Contains(HasSubstr("cannot be read, left out")));
  }
}

TEST(GltfTextures, AMaskCutsOut) {
  const TemporaryFolder folder;
  GltfFile file;
  const std::string png = PngOf(FourColours());
  AddTexturedSquare(file, file.AddBytes(png.data(), png.size()));
  json& material = file.document["materials"][0];
  material["alphaMode"] = "MASK";
  material["pbrMetallicRoughness"]["baseColorFactor"] = {0.5, 0.5, 0.5, 0.7};
  const auto load = [&] {
    return LoadMesh(folder.Write("a.glb", file.Binary()), MeshColours::kByPlace);
  };
  LoadedMesh loaded = load();
  ASSERT_TRUE(loaded.mesh.materials[0].by_place);
  EXPECT_EQ(loaded.mesh.materials[0].by_place->alpha_cutoff, 0.5f);
  EXPECT_FLOAT_EQ(loaded.mesh.materials[0].by_place->base_alpha, 0.7f);
  EXPECT_THAT(loaded.report.notes, Contains(HasSubstr("shadows")));
  material["alphaCutoff"] = 0.25;
  EXPECT_EQ(load().mesh.materials[0].by_place->alpha_cutoff, 0.25f);
}

TEST(GltfTextures, ColoursOfVerticesAreShownByPlace) {
  const TemporaryFolder folder;
  GltfFile file;
  // Black on the left, (1, 0.5, 0) on the right.
  const int colours = file.AddFloats({0, 0, 0, 1, 0.5f, 0, 1, 0.5f, 0, 0, 0, 0}, 3);
  file.document["materials"] = {
      {{"pbrMetallicRoughness", {{"baseColorFactor", {0.8, 0.8, 0.8, 1}}, {"metallicFactor", 0}}}}};
  file.AddMesh(Square(), 0, {{"COLOR_0", colours}});
  file.document["nodes"] = {{{"mesh", 0}}};
  const auto path = folder.Write("a.gltf", file.Text());
  const Mesh shown = LoadMesh(path, MeshColours::kByPlace).mesh;
  EXPECT_EQ(shown.triangles.size(), 2u);
  for (const float x : {0.1f, 0.5f, 0.9f}) {
    EXPECT_NEAR(AlbedoAt(shown, x, 0.45f).at_place.r, 0.8f * x, 1e-5f) << x;
    EXPECT_NEAR(AlbedoAt(shown, x, 0.45f).at_place.g, 0.4f * x, 1e-5f) << x;
  }
  const Mesh mean = LoadMesh(path).mesh;
  ASSERT_EQ(mean.materials.size(), 1u);
  EXPECT_NEAR(mean.materials[0].diffuse_albedo.r, 0.4f, 0.01f);
}

}  // namespace
}  // namespace pleinair::gltf_textures_test
