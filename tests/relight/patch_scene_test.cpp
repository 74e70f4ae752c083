#include "relight/transport/patch_scene.h"

#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <tuple>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "relight/transport/patch_refinement.h"
#include "scene/low_discrepancy.h"
#include "tests/relight/probe_test_scenes.h"

namespace pleinair::patch_scene_test {
namespace {

Mesh WithNames(Mesh mesh) {
  mesh.materials.resize(1);
  mesh.group_names = {"scene"};
  return mesh;
}

Mesh Box() {
  Mesh mesh;
  AddBox(mesh, {-1.0f, -2.0f, 0.0f}, {3.0f, 1.0f, 2.5f});
  return WithNames(std::move(mesh));
}

PatchOptions Flat(double patch_size_m) {
  return {.patch_size_m = patch_size_m, .growth_per_m = 0.0, .extend_ground = false};
}

double Area(const PatchScene& scene) {
  double area = 0.0;
  for (std::size_t i = 0; i < scene.PatchCount(); ++i) area += scene.PatchAreaM2(i);
  return area;
}

double LongestEdge(const PatchScene& scene, std::size_t patch) {
  double longest = 0.0;
  const glm::uvec3& v = scene.mesh.triangles[patch];
  for (int i = 0; i < 3; ++i) {
    longest = std::max(longest,
                       static_cast<double>(glm::distance(scene.mesh.positions_m[v[i]],
                                                         scene.mesh.positions_m[v[(i + 1) % 3]])));
  }
  return longest;
}

TEST(PatchScene, NoEdgeIsLongerThanAskedFor) {
  for (const double size_m : {5.0, 1.0, 0.3}) {
    const PatchScene scene = BuildPatchScene(Box(), Flat(size_m));
    for (std::size_t i = 0; i < scene.mesh.triangles.size(); ++i) {
      EXPECT_LE(LongestEdge(scene, i), size_m * (1.0 + 1e-6));
    }
  }
}

// 2 (4*3 + 4*2.5 + 3*2.5) = 59 m^2; float positions are good to 1e-7 each.
TEST(PatchScene, CuttingKeepsAreaAndNormals) {
  const PatchScene scene = BuildPatchScene(Box(), Flat(0.4));
  EXPECT_NEAR(Area(scene), 59.0, 59.0 * 1e-5);
  const Mesh source = Box();
  for (std::size_t i = 0; i < scene.mesh.triangles.size(); ++i) {
    EXPECT_GT(glm::dot(scene.FaceNormal(2 * i), TriangleNormal(source, scene.source_triangle[i])),
              0.999f);
    EXPECT_EQ(scene.FaceNormal(2 * i), -scene.FaceNormal(2 * i + 1));
  }
}

// The box stores every side's corners apart, and the patch size changes over it. Still each edge
// has its twin, at the very same positions: no crack, no vertex within another's edge.
TEST(PatchScene, NeighboursStayJoinedAcrossDoubledEdges) {
  PatchOptions options{.focus_m = {3.0, 1.0, 2.5}, .patch_size_m = 0.1, .growth_per_m = 0.3};
  options.extend_ground = false;
  const PatchScene scene = BuildPatchScene(Box(), options);
  EXPECT_GT(scene.mesh.triangles.size(), 500u);
  using Point = std::tuple<float, float, float>;
  std::map<std::pair<Point, Point>, int> edges;
  for (const glm::uvec3& v : scene.mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const glm::vec3& a = scene.mesh.positions_m[v[i]];
      const glm::vec3& b = scene.mesh.positions_m[v[(i + 1) % 3]];
      const Point from{a.x, a.y, a.z};
      const Point to{b.x, b.y, b.z};
      ++edges[from < to ? std::pair{from, to} : std::pair{to, from}];
    }
  }
  for (const auto& [edge, count] : edges) EXPECT_EQ(count, 2);
}

TEST(PatchScene, PatchesGrowWithDistanceFromTheFocus) {
  Mesh mesh;
  AddGround(mesh, 40.0f);
  const PatchScene scene = BuildPatchScene(WithNames(std::move(mesh)),
                                           {.focus_m = {0.0, 0.0, 0.0},
                                            .patch_size_m = 0.5,
                                            .growth_per_m = 0.1,
                                            .extend_ground = false});
  const PatchScene even = BuildPatchScene(
      [] {
        Mesh flat;
        AddGround(flat, 40.0f);
        return WithNames(std::move(flat));
      }(),
      Flat(0.5));
  EXPECT_LT(scene.mesh.triangles.size(), even.mesh.triangles.size() / 10);
}

TEST(PatchScene, AHitKnowsItsPatchAndSide) {
  const PatchScene scene = BuildPatchScene(Box(), Flat(0.5));
  const glm::vec3 down(0.0f, 0.0f, -1.0f);
  const auto outside = scene.caster.Intersect({0.3f, 0.2f, 5.0f}, down);
  ASSERT_TRUE(outside);
  const std::int32_t face = PatchScene::SideOfHit(*outside, down);
  EXPECT_EQ(face % 2, 0);
  EXPECT_GT(scene.FaceNormal(static_cast<std::size_t>(face)).z, 0.999f);
  const auto inside = scene.caster.Intersect({0.3f, 0.2f, 1.0f}, down);
  ASSERT_TRUE(inside);
  EXPECT_EQ(PatchScene::SideOfHit(*inside, down) % 2, 1);
}

TEST(PatchScene, FacesStartWithTheirMaterialsAlbedo) {
  Mesh mesh = Box();
  mesh.materials[0].diffuse_albedo = {0.1f, 0.2f, 0.3f};
  const PatchScene scene = BuildPatchScene(mesh, Flat(1.0));
  ASSERT_EQ(scene.face_albedo_rgb.size(), scene.FaceCount());
  for (const glm::vec3& albedo : scene.face_albedo_rgb) {
    EXPECT_EQ(albedo, glm::vec3(0.1f, 0.2f, 0.3f));
  }
}

// A turned yard: its bounding box would leave its corners open. Every ray down from 1.5 m to within
// 0.1 deg of the horizon meets ground.
TEST(PatchScene, TheGroundGoesOnToTheHorizonAllAround) {
  Mesh mesh;
  AddQuad(
      mesh, {-20.0f, -7.0f, 0.0f}, {7.0f, -20.0f, 0.0f}, {20.0f, 7.0f, 0.0f}, {-7.0f, 20.0f, 0.0f});
  AddBox(mesh, {2.0f, 2.0f, 0.0f}, {4.0f, 4.0f, 3.0f});
  const PatchScene scene = BuildPatchScene(WithNames(std::move(mesh)), {});
  EXPECT_TRUE(scene.ground_extended);
  EXPECT_EQ(scene.mesh.group_names.back(), "ground_extension");
  EXPECT_EQ(scene.source_triangle.back(), PatchScene::kExtension);
  for (int azimuth_deg = 0; azimuth_deg < 360; azimuth_deg += 3) {
    for (const double down_deg : {0.1, 1.0, 5.0, 30.0}) {
      const double azimuth = azimuth_deg * std::numbers::pi / 180.0;
      const double down = down_deg * std::numbers::pi / 180.0;
      const glm::vec3 direction(
          std::cos(azimuth) * std::cos(down), std::sin(azimuth) * std::cos(down), -std::sin(down));
      EXPECT_TRUE(scene.caster.Intersect({0.0f, 0.0f, 1.5f}, direction))
          << azimuth_deg << " deg, " << down_deg << " deg down";
    }
  }
}

// Under a room, whose own floor is not carried on.
TEST(PatchScene, AGroundOfGivenAlbedoIsLaidAroundTheFoot) {
  Mesh mesh;
  AddBox(mesh, {2.0f, 2.0f, 0.5f}, {6.0f, 4.0f, 3.0f});
  PatchOptions options;
  options.ground_albedo = 0.2;
  const PatchScene scene = BuildPatchScene(WithNames(std::move(mesh)), options);
  EXPECT_TRUE(scene.ground_laid);
  EXPECT_FALSE(scene.ground_extended);
  EXPECT_EQ(scene.face_albedo_rgb.back(), glm::vec3(0.2f));
  EXPECT_LT(scene.mesh.triangles.size(), 5000u);
  std::size_t laid = 0;
  for (const std::uint32_t source : scene.source_triangle) laid += source >= 12 ? 1 : 0;
  EXPECT_GT(laid, 200u);
  for (int azimuth_deg = 0; azimuth_deg < 360; azimuth_deg += 15) {
    const double azimuth = azimuth_deg * std::numbers::pi / 180.0;
    const glm::vec3 direction(std::cos(azimuth), std::sin(azimuth), -0.002f);
    const auto hit = scene.caster.Intersect({4.0f, 5.0f, 2.0f}, glm::normalize(direction));
    EXPECT_TRUE(hit) << azimuth_deg;
  }
  options.ground_albedo = 1.0;
  EXPECT_THROW(BuildPatchScene(WithNames({}), options), std::invalid_argument);
}

// A ground of 4 m in squares of a few centimetres, its western half of another group, with a wall
// of two sides on it.
Mesh FineYard() {
  Mesh mesh;
  constexpr int kSteps = 64;
  const auto at = [](int step) { return -2.0f + 4.0f * static_cast<float>(step) / kSteps; };
  for (int x = 0; x < kSteps; ++x) {
    for (int y = 0; y < kSteps; ++y) {
      AddQuad(mesh,
              {at(x), at(y), 0.0f},
              {at(x + 1), at(y), 0.0f},
              {at(x + 1), at(y + 1), 0.0f},
              {at(x), at(y + 1), 0.0f});
      AddQuad(mesh,
              {0.0f, at(x), 2.0f + at(y)},
              {0.0f, at(x + 1), 2.0f + at(y)},
              {0.0f, at(x + 1), 2.0f + at(y + 1)},
              {0.0f, at(x), 2.0f + at(y + 1)});
      AddQuad(mesh,
              {0.02f, at(x), 2.0f + at(y + 1)},
              {0.02f, at(x + 1), 2.0f + at(y + 1)},
              {0.02f, at(x + 1), 2.0f + at(y)},
              {0.02f, at(x), 2.0f + at(y)});
    }
  }
  mesh = WithNames(std::move(mesh));
  mesh.group_names = {"east", "west"};
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.positions_m[mesh.triangles[t].y].x <= 0.0f) mesh.triangle_group[t] = 1;
  }
  return mesh;
}

TEST(PatchScene, SmallTrianglesOfOnePlaceAndDirectionShareAPatch) {
  const Mesh yard = FineYard();
  const PatchScene scene = BuildPatchScene(yard, Flat(0.5));
  ASSERT_EQ(scene.mesh.triangles.size(), yard.triangles.size());
  EXPECT_NEAR(Area(scene), 48.0, 48.0 * 1e-4);
  // Squares of 0.25 m, and parts of some at borders.
  EXPECT_GE(scene.PatchCount(), 48u * 16u);
  EXPECT_LE(scene.PatchCount(), 48u * 20u);
  for (std::size_t patch = 0; patch < scene.PatchCount(); ++patch) {
    const std::size_t first = scene.FirstTriangleOf(patch);
    const std::size_t last = scene.several.begin[patch + 1];
    ASSERT_LT(first, last);
    glm::vec3 lower(1e9f);
    glm::vec3 upper(-1e9f);
    for (std::size_t t = first; t < last; ++t) {
      EXPECT_EQ(scene.FaceOfSide(static_cast<std::int32_t>(2 * t)),
                static_cast<std::int32_t>(2 * patch));
      EXPECT_EQ(scene.FaceOfSide(static_cast<std::int32_t>(2 * t + 1)),
                static_cast<std::int32_t>(2 * patch + 1));
      EXPECT_EQ(scene.mesh.triangle_group[t], scene.GroupOf(patch));
      EXPECT_EQ(scene.mesh.triangle_material[t], scene.MaterialOf(patch));
      EXPECT_EQ(scene.mesh.triangles[t], yard.triangles[scene.source_triangle[t]]);
      EXPECT_GT(glm::dot(scene.SideNormal(2 * t), scene.FaceNormal(2 * patch)), 0.999f);
      for (int corner = 0; corner < 3; ++corner) {
        lower = glm::min(lower, scene.mesh.positions_m[scene.mesh.triangles[t][corner]]);
        upper = glm::max(upper, scene.mesh.positions_m[scene.mesh.triangles[t][corner]]);
      }
    }
    EXPECT_LE(glm::distance(lower, upper), 0.5f) << "longer than a patch's edge may be";
  }
}

// By the mean of low-discrepancy points: 1/50 of the patch's size.
TEST(PatchScene, PointsSpreadOverAllTrianglesOfAPatch) {
  const PatchScene scene = BuildPatchScene(FineYard(), Flat(0.5));
  constexpr int kPoints = 256;
  for (std::size_t patch = 0; patch < scene.PatchCount(); patch += 17) {
    glm::vec3 sum_m(0.0f);
    std::set<std::size_t> met;
    for (int i = 0; i < kPoints; ++i) {
      const auto [position_m, triangle] = scene.PointOn(patch, R2Point(i, {0.1, 0.7}));
      const glm::uvec3& v = scene.mesh.triangles[triangle];
      const glm::vec3 apart_m = position_m - scene.mesh.positions_m[v.x];
      EXPECT_LT(std::abs(glm::dot(apart_m, scene.SideNormal(2 * triangle))), 1e-5f);
      EXPECT_LE(glm::length(apart_m), 0.09f);
      met.insert(triangle);
      sum_m += position_m / static_cast<float>(kPoints);
    }
    EXPECT_EQ(met.size(), scene.several.begin[patch + 1] - scene.FirstTriangleOf(patch));
    EXPECT_LT(glm::distance(sum_m, scene.PatchMiddleM(patch)), 0.01f);
  }
}

// Ten times the triangles are not ten times the patches; nor is a mesh torn into slivers, with
// noise in all its vertices.
TEST(PatchScene, ThePatchesOfAFineMeshAreAsManyAsThePlaceAsksFor) {
  Mesh coarse;
  AddGround(coarse, 2.0f);
  const auto patches_of = [&](double edge_m, float noise_m) {
    Mesh fine = RefineMesh(
                    WithNames(coarse), [&](auto&) { return edge_m; }, 1u << 20u)
                    .mesh;
    std::mt19937 random(1);
    std::normal_distribution<float> noise(0.0f, 1.0f);
    for (glm::vec3& at : fine.positions_m) {
      at += noise_m * glm::vec3(3.0f * noise(random), noise(random), noise(random));
    }
    return BuildPatchScene(fine, Flat(0.5)).PatchCount();
  };
  const std::size_t of_few = patches_of(10.0, 0.0f);
  const std::size_t of_many = patches_of(0.06, 0.0f);
  EXPECT_LT(of_many, 2 * of_few);
  EXPECT_GT(2 * of_many, of_few);
  EXPECT_LT(patches_of(0.03, 0.0f), 5 * of_many / 4);
  EXPECT_LT(patches_of(0.06, 0.006f), 2 * of_many);
}

TEST(PatchScene, PatchesThatAreCutHaveATriangleEach) {
  const PatchScene scene = BuildPatchScene(Box(), Flat(0.4));
  EXPECT_TRUE(scene.several.Empty());
  EXPECT_EQ(scene.PatchCount(), scene.mesh.triangles.size());
  PatchOptions options = Flat(0.5);
  options.join_small = false;
  EXPECT_TRUE(BuildPatchScene(FineYard(), options).several.Empty());
}

TEST(PatchScene, AGroundThatReachesFarIsLeftAsItIs) {
  Mesh mesh;
  AddGround(mesh, 1500.0f);
  EXPECT_FALSE(BuildPatchScene(WithNames(std::move(mesh)), {}).ground_extended);
}

// Seven halvings of 100 m; a sliver has two long edges, so that each gives three pieces: 3^7 a
// triangle.
TEST(PatchSceneHardCases, SliversOfTenThousandToOneAreCutToo) {
  Mesh mesh;
  AddQuad(
      mesh, {0.0f, 0.0f, 0.0f}, {100.0f, 0.0f, 0.0f}, {100.0f, 0.01f, 0.0f}, {0.0f, 0.01f, 0.0f});
  const PatchScene scene = BuildPatchScene(WithNames(std::move(mesh)), Flat(1.0));
  EXPECT_NEAR(Area(scene), 1.0, 1e-4);
  EXPECT_LE(scene.mesh.triangles.size(), 2u * 2187u);
}

TEST(PatchSceneHardCases, AnEmptyMeshAndTrianglesWithoutAreaLeaveNoPatch) {
  EXPECT_EQ(BuildPatchScene(Mesh{}, {}).FaceCount(), 0u);
  Mesh mesh = Box();
  const std::size_t whole = BuildPatchScene(mesh, Flat(10.0)).mesh.triangles.size();
  mesh.triangles.emplace_back(0, 0, 1);
  mesh.triangle_group.push_back(0);
  mesh.triangle_material.push_back(0);
  EXPECT_EQ(BuildPatchScene(mesh, Flat(10.0)).mesh.triangles.size(), whole);
}

TEST(PatchSceneHardCases, RefusesWhatMakesNoSense) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(BuildPatchScene(Box(), {.patch_size_m = 0.0}), std::invalid_argument);
  EXPECT_THROW(BuildPatchScene(Box(), {.patch_size_m = nan}), std::invalid_argument);
  EXPECT_THROW(BuildPatchScene(Box(), {.growth_per_m = -0.1}), std::invalid_argument);
  EXPECT_THROW(BuildPatchScene(Box(), {.focus_m = {0.0, nan, 0.0}}), std::invalid_argument);
  Mesh broken = Box();
  broken.positions_m[3].y = static_cast<float>(nan);
  EXPECT_THROW(BuildPatchScene(broken, {}), std::invalid_argument);
  Mesh dangling = Box();
  dangling.triangles[0].x = 4000;
  EXPECT_THROW(BuildPatchScene(dangling, {}), std::invalid_argument);
  const auto fine = [](const glm::vec3&) { return 0.01; };
  EXPECT_THROW(RefineMesh(Box(), fine, 1000), std::invalid_argument) << "too many patches";
}

}  // namespace
}  // namespace pleinair::patch_scene_test
