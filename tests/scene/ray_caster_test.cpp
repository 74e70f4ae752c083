#include "scene/ray_caster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/textured_material.h"
#include "tests/scene/box_mesh.h"

namespace pleinair::ray_caster_test {
namespace {

Mesh UnitTriangle() {
  Mesh mesh;
  mesh.positions_m = {{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}};
  mesh.normals.assign(3, {0.0f, 0.0f, 1.0f});
  mesh.triangles = {{0, 1, 2}};
  mesh.triangle_material = {0};
  mesh.triangle_group = {0};
  return mesh;
}

TEST(RayCaster, SaysWhereARayHits) {
  const RayCaster caster(UnitTriangle());
  const auto hit = caster.Intersect({0.25f, 0.5f, 2.0f}, {0.0f, 0.0f, -1.0f});
  ASSERT_TRUE(hit.has_value());
  EXPECT_EQ(hit->triangle, 0u);
  EXPECT_FLOAT_EQ(hit->distance_m, 2.0f);
  EXPECT_NEAR(hit->barycentric.x, 0.25f, 1e-6f);
  EXPECT_NEAR(hit->barycentric.y, 0.5f, 1e-6f);
  EXPECT_NEAR(glm::distance(hit->position_m, {0.25f, 0.5f, 0.0f}), 0.0f, 1e-6f);
  EXPECT_EQ(hit->geometric_normal, glm::vec3(0.0f, 0.0f, 1.0f));
}

TEST(RayCaster, NormalsFollowTheWindingFromEitherSide) {
  const RayCaster caster(UnitTriangle());
  const auto below = caster.Intersect({0.2f, 0.2f, -1.0f}, {0.0f, 0.0f, 1.0f});
  ASSERT_TRUE(below.has_value());
  EXPECT_EQ(below->geometric_normal, glm::vec3(0.0f, 0.0f, 1.0f));
}

TEST(RayCaster, DistanceLimitsExcludeTheirEnds) {
  const RayCaster caster(UnitTriangle());
  const glm::vec3 down(0.0f, 0.0f, -1.0f);
  for (const float distance : {1e-3f, 1.0f, 1000.0f}) {
    const glm::vec3 origin(0.25f, 0.25f, distance);
    EXPECT_FALSE(caster.Intersect(origin, down, distance).has_value());
    EXPECT_FALSE(caster.Occluded(origin, down, distance));
    EXPECT_TRUE(caster.Intersect(origin, down, 1.0001f * distance).has_value());
    EXPECT_TRUE(caster.Occluded(origin, down, 1.0001f * distance));
  }
  for (const glm::vec3& direction : {down, -down}) {
    EXPECT_FALSE(caster.Intersect({0.25f, 0.25f, 0.0f}, direction).has_value());
    EXPECT_FALSE(caster.Occluded({0.25f, 0.25f, 0.0f}, direction));
  }
  EXPECT_FALSE(caster.Occluded({0.25f, 0.25f, 1.0f}, down, 0.0f));
  EXPECT_FALSE(caster.Occluded({0.25f, 0.25f, 1.0f}, down, -1.0f));
}

TEST(RayCaster, FindsTheNearest) {
  Mesh mesh = UnitTriangle();
  for (const float height : {-1.0f, 3.0f, 1.0f}) {
    const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
    for (int corner = 0; corner < 3; ++corner) {
      mesh.positions_m.push_back(mesh.positions_m[static_cast<std::size_t>(corner)] +
                                 glm::vec3(0.0f, 0.0f, height));
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  const RayCaster caster(mesh);
  const auto hit = caster.Intersect({0.25f, 0.25f, 2.0f}, {0.0f, 0.0f, -1.0f});
  ASSERT_TRUE(hit.has_value());
  EXPECT_EQ(hit->triangle, 3u);
}

TEST(RayCaster, AnEmptyMeshIsMissed) {
  const RayCaster caster{Mesh{}};
  EXPECT_FALSE(caster.Intersect(glm::vec3(0.0f), {1.0f, 0.0f, 0.0f}).has_value());
  EXPECT_FALSE(caster.Occluded(glm::vec3(0.0f), {1.0f, 0.0f, 0.0f}));
}

TEST(RayCaster, OutlivesItsMeshAndMoves) {
  auto mesh = std::make_unique<Mesh>(BoxMesh(glm::vec3(-1.0f), glm::vec3(1.0f)));
  RayCaster made(*mesh);
  mesh.reset();
  RayCaster moved(std::move(made));
  EXPECT_TRUE(moved.Occluded(glm::vec3(0.0f), {1.0f, 0.0f, 0.0f}));
  moved = RayCaster(Mesh{});
  EXPECT_FALSE(moved.Occluded(glm::vec3(0.0f), {1.0f, 0.0f, 0.0f}));
}

TEST(RayCaster, ManyRaysAtOnceSayTheSame) {
  const RayCaster caster(BoxMesh({-1.0f, -1.0f, 0.0f}, {1.0f, 1.0f, 1.0f}));
  std::mt19937 random(31);
  std::normal_distribution<float> normal;
  for (const std::size_t count :
       {std::size_t{0}, std::size_t{1}, std::size_t{8}, std::size_t{1003}}) {
    std::vector<glm::vec3> origins(count);
    std::vector<glm::vec3> directions(count);
    for (std::size_t i = 0; i < count; ++i) {
      origins[i] = 3.0f * glm::vec3(normal(random), normal(random), normal(random));
      directions[i] = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
    }
    const auto occluded = std::make_unique<bool[]>(count);
    caster.Occluded(origins.data(), directions.data(), count, occluded.get());
    std::vector<std::optional<RayHit>> hits(count);
    caster.Intersect(origins.data(), directions.data(), count, hits.data());
    std::vector<FaceHit> face_hits(count);
    caster.Intersect(origins.data(), directions.data(), count, face_hits.data());
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(occluded[i], caster.Occluded(origins[i], directions[i]));
      const auto hit = caster.Intersect(origins[i], directions[i]);
      EXPECT_EQ(occluded[i], hit.has_value());
      ASSERT_EQ(hits[i].has_value(), hit.has_value());
      ASSERT_EQ(face_hits[i].triangle != FaceHit::kNone, hit.has_value());
      if (!hit) continue;
      EXPECT_EQ(hits[i]->triangle, hit->triangle);
      EXPECT_EQ(face_hits[i].triangle, hit->triangle);
      EXPECT_EQ(face_hits[i].is_front, glm::dot(hit->geometric_normal, directions[i]) <= 0.0f);
      EXPECT_NEAR(face_hits[i].distance_m, hit->distance_m, 1e-5f);
      // A few roundings of the distance, in packets' own order.
      EXPECT_LT(glm::distance(hits[i]->position_m, hit->position_m), 1e-5f);
      EXPECT_NEAR(hits[i]->distance_m, hit->distance_m, 1e-5f);
    }
  }
}

TEST(RayCaster, ManyRaysFromOnePointSayTheSame) {
  const RayCaster caster(BoxMesh({-1.0f, -1.0f, 0.0f}, {1.0f, 1.0f, 1.0f}));
  std::mt19937 random(32);
  std::normal_distribution<float> normal;
  std::vector<glm::vec3> directions(203);
  for (glm::vec3& direction : directions) {
    direction = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
  }
  // Outside, and inside where sides are the other ones.
  for (const glm::vec3& origin_m : {glm::vec3(1.5f, -0.2f, 0.6f), glm::vec3(0.1f, 0.2f, 0.4f)}) {
    for (const RayCaster::Origin where :
         {RayCaster::Origin::kMayBeOnMesh, RayCaster::Origin::kOffMesh}) {
      std::vector<FaceHit> hits(directions.size());
      caster.IntersectFrom(origin_m, where, directions.data(), directions.size(), hits.data());
      int met = 0;
      for (std::size_t i = 0; i < directions.size(); ++i) {
        const auto hit = caster.Intersect(origin_m, directions[i]);
        ASSERT_EQ(hits[i].triangle != FaceHit::kNone, hit.has_value());
        if (!hit) continue;
        ++met;
        EXPECT_EQ(hits[i].triangle, hit->triangle);
        EXPECT_EQ(hits[i].is_front, glm::dot(hit->geometric_normal, directions[i]) <= 0.0f);
        // A few roundings of the distance.
        EXPECT_NEAR(hits[i].distance_m, hit->distance_m, 1e-5f);
      }
      EXPECT_GT(met, 20);
    }
  }
  FaceHit none;
  const glm::vec3 nowhere(std::numeric_limits<float>::quiet_NaN());
  caster.IntersectFrom(nowhere, RayCaster::Origin::kOffMesh, directions.data(), 1, &none);
  EXPECT_EQ(none.triangle, FaceHit::kNone);
}

// To faces, edges and corners of a box, from both sides.
// Rays that go no farther than what another mesh stopped: as the nearer one of two hits.
TEST(RayCaster, RaysThatEndSomewhereMeetWhatIsNearer) {
  const RayCaster caster(BoxMesh({-1.0f, -1.0f, -1.0f}, {1.0f, 1.0f, 1.0f}));
  std::vector<glm::vec3> origins_m;
  std::vector<glm::vec3> directions;
  std::vector<FaceHit> limited;
  for (int i = 0; i < 37; ++i) {
    const float angle = 0.17f * static_cast<float>(i);
    origins_m.emplace_back(3.0f * std::cos(angle), 3.0f * std::sin(angle), 0.1f);
    directions.push_back(glm::normalize(glm::vec3(0.02f * static_cast<float>(i % 7), 0.0f, 0.3f) -
                                        origins_m.back()));
    FaceHit hit;
    hit.triangle = 7;  // Of the other mesh.
    if (i % 3 != 0) hit.distance_m = i % 3 == 1 ? 1.2f : 10.0f;
    limited.push_back(hit);
  }
  std::vector<FaceHit> nearest(origins_m.size());
  caster.Intersect(origins_m.data(), directions.data(), origins_m.size(), nearest.data());
  const std::vector<FaceHit> before = limited;
  caster.IntersectNearer(origins_m.data(), directions.data(), origins_m.size(), limited.data());
  int nearer = 0;
  for (std::size_t i = 0; i < limited.size(); ++i) {
    ASSERT_NE(nearest[i].triangle, FaceHit::kNone);
    const bool is_nearer = nearest[i].distance_m < before[i].distance_m;
    nearer += is_nearer ? 1 : 0;
    EXPECT_EQ(limited[i].triangle, is_nearer ? nearest[i].triangle : FaceHit::kNone) << i;
    EXPECT_EQ(limited[i].distance_m, is_nearer ? nearest[i].distance_m : before[i].distance_m);
  }
  EXPECT_GT(nearer, 10);
  EXPECT_LT(nearer, 30);
}

TEST(RayCaster, ReturnsTheDistanceToTheNearestTriangle) {
  const glm::vec3 lower_m(-1.0f, -2.0f, 0.0f);
  const glm::vec3 upper_m(1.0f, 1.0f, 0.5f);
  const RayCaster caster(BoxMesh(lower_m, upper_m));
  std::mt19937 random(33);
  std::uniform_real_distribution<float> at(-3.0f, 3.0f);
  int inside = 0;
  for (int i = 0; i < 500; ++i) {
    const glm::vec3 point_m(at(random), at(random), 0.3f * at(random));
    const glm::vec3 out_m = glm::max(lower_m - point_m, point_m - upper_m);
    float expected_m = glm::length(glm::max(out_m, glm::vec3(0.0f)));
    if (expected_m == 0.0f) {
      expected_m = -std::max({out_m.x, out_m.y, out_m.z});
      ++inside;
    }
    // Roundings of coordinates of a few metres.
    EXPECT_NEAR(caster.DistanceTo(point_m, 100.0f), expected_m, 2e-6f);
    EXPECT_FLOAT_EQ(caster.DistanceTo(point_m, 0.5f * expected_m), 0.5f * expected_m);
  }
  EXPECT_GT(inside, 10);
  EXPECT_EQ(RayCaster(Mesh{}).DistanceTo(glm::vec3(0.0f), 7.0f), 7.0f);
}

TEST(RayCaster, RefusesTrianglesWithMissingVertices) {
  Mesh mesh = UnitTriangle();
  mesh.triangles.push_back({0, 1, 3});
  EXPECT_THROW(RayCaster{mesh}, std::invalid_argument);
}

TEST(RayCaster, OffsetMovesToTheSideAskedFor) {
  for (const float scale : {1e-3f, 1.0f, 1e3f, 1e6f}) {
    const glm::vec3 position = scale * glm::vec3(0.3f, -0.7f, 0.5f);
    const glm::vec3 normal = glm::normalize(glm::vec3(1.0f, 2.0f, -2.0f));
    const glm::dvec3 up = glm::dvec3(OffsetFromSurface(position, normal)) - glm::dvec3(position);
    const glm::dvec3 down = glm::dvec3(OffsetFromSurface(position, -normal)) - glm::dvec3(position);
    EXPECT_GT(glm::dot(up, glm::dvec3(normal)), 0.0);
    EXPECT_LT(glm::dot(down, glm::dvec3(normal)), 0.0);
    EXPECT_LT(glm::length(up), 1e-6 * scale);
  }
}

// A square of 2 m whose left half is cut out, by each of the ways to ask.
TEST(RayCaster, SeesThroughWhatATextureCutsOut) {
  Texture::Codes codes(8, 1, glm::u8vec4(255));
  for (int x = 0; x < 4; ++x) codes.At(x, 0).a = 0;
  const auto material = std::make_shared<TexturedMaterial>();
  material->texture = std::make_shared<const Texture>(std::move(codes));
  material->wraps = {TextureWrap::kClamp, TextureWrap::kClamp};
  material->alpha_cutoff = 0.5f;
  Mesh mesh;
  mesh.positions_m = {
      {-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {-9, -9, -5}, {9, -9, -5}, {0, 9, -5}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}};
  mesh.triangle_material = {0, 0, 1};
  mesh.materials.resize(2);
  mesh.materials[0].by_place = material;
  mesh.triangle_colours.resize(3);
  mesh.triangle_colours[0].texture_uv = {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1)};
  mesh.triangle_colours[1].texture_uv = {glm::vec2(0, 0), glm::vec2(1, 1), glm::vec2(0, 1)};
  const RayCaster caster(mesh);
  std::vector<glm::vec3> origins;
  const std::vector<glm::vec3> down(8, {0.0f, 0.0f, -1.0f});
  for (int i = 0; i < 8; ++i) {
    const float x = -0.9f + 0.25f * static_cast<float>(i);
    origins.emplace_back(x, i % 2 == 0 ? 0.4f : -0.3f, 2.0f);
  }
  std::vector<std::optional<RayHit>> hits(8);
  caster.Intersect(origins.data(), down.data(), 8, hits.data());
  for (std::size_t i = 0; i < 8; ++i) {
    const bool is_there = origins[i].x > 0.0f;
    const auto hit = caster.Intersect(origins[i], down[i]);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->triangle == 2, !is_there) << origins[i].x;
    ASSERT_TRUE(hits[i]);
    EXPECT_EQ(hits[i]->triangle, hit->triangle);
    for (const RayCaster::Origin where :
         {RayCaster::Origin::kMayBeOnMesh, RayCaster::Origin::kOffMesh}) {
      FaceHit in_short;
      caster.IntersectFrom(origins[i], where, &down[i], 1, &in_short);
      EXPECT_EQ(in_short.triangle, hit->triangle);
    }
    EXPECT_EQ(caster.Occluded(origins[i], down[i], 3.0f), is_there);
  }
}

}  // namespace
}  // namespace pleinair::ray_caster_test
