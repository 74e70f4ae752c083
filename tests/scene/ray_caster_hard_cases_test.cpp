#include "scene/ray_caster.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>

#include "tests/scene/box_mesh.h"

namespace pleinair::ray_caster_hard_cases_test {
namespace {

constexpr double kScales[] = {1e-3, 1.0, 1e3, 1e6};
constexpr unsigned kSeed = 41;

glm::vec3 RandomDirection(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return glm::vec3(glm::normalize(glm::dvec3(normal(random), normal(random), normal(random))));
}

// A random point of a triangle, as exact as a float position can be.
glm::vec3 RandomPoint(const Mesh& mesh, std::uint32_t triangle, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform;
  const double root = std::sqrt(uniform(random));
  const double v = uniform(random);
  const glm::uvec3 corners = mesh.triangles[triangle];
  return glm::vec3((1.0 - root) * glm::dvec3(mesh.positions_m[corners.x]) +
                   root * (1.0 - v) * glm::dvec3(mesh.positions_m[corners.y]) +
                   root * v * glm::dvec3(mesh.positions_m[corners.z]));
}

// A box that lies askew and off the origin, where nothing is exact in single precision.
Mesh SkewBox(double scale) {
  glm::dmat4 placed = glm::translate(glm::dmat4(1.0), scale * glm::dvec3(2.0, -3.0, 1.0));
  placed = glm::rotate(placed, 0.477, glm::normalize(glm::dvec3(0.3, 0.2, 1.0)));
  placed = glm::scale(placed, glm::dvec3(scale));
  return TransformMesh(placed, BoxMesh({-1.0f, -2.0f, 0.0f}, {2.0f, 3.0f, 1.5f}));
}

// Moeller and Trumbore's test in double precision. `doubtful` when the ray passes an edge or the
// plane's near side within what single precision resolves.
struct Reference {
  std::optional<double> distance_m;
  bool doubtful = false;
};

Reference BruteForce(const Mesh& mesh, const glm::vec3& origin, const glm::vec3& direction) {
  constexpr double kDoubt = 1e-4;
  Reference result;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a(mesh.positions_m[t.x]);
    const glm::dvec3 ab = glm::dvec3(mesh.positions_m[t.y]) - a;
    const glm::dvec3 ac = glm::dvec3(mesh.positions_m[t.z]) - a;
    const glm::dvec3 p = glm::cross(glm::dvec3(direction), ac);
    const double determinant = glm::dot(ab, p);
    if (determinant == 0.0) continue;  // Without area.
    const glm::dvec3 to_origin = glm::dvec3(origin) - a;
    const glm::dvec3 q = glm::cross(to_origin, ab);
    const double u = glm::dot(to_origin, p) / determinant;
    const double v = glm::dot(glm::dvec3(direction), q) / determinant;
    const double distance = glm::dot(ac, q) / determinant;
    const double inside = std::min({u, v, 1.0 - u - v});
    if (std::abs(inside) < kDoubt) result.doubtful = true;
    if (inside > 0.0 && std::abs(distance) < kDoubt) result.doubtful = true;
    if (inside > 0.0 && distance > 0.0 && !(distance >= result.distance_m.value_or(INFINITY))) {
      result.distance_m = distance;
    }
  }
  return result;
}

// Loose triangles of every kind: slivers, crossing ones, shared edges, without area.
Mesh TriangleSoup(std::mt19937& random) {
  std::normal_distribution<float> normal;
  Mesh mesh;
  for (int i = 0; i < 120; ++i) {
    const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
    const glm::vec3 at(normal(random), normal(random), normal(random));
    const float size = i % 3 == 0 ? 2.0f : 0.3f;
    const float thin = i % 4 == 0 ? 1e-3f : 1.0f;
    mesh.positions_m.push_back(at);
    mesh.positions_m.push_back(at + size * RandomDirection(random));
    mesh.positions_m.push_back(at + thin * size * RandomDirection(random));
    mesh.triangles.push_back({first, first + 1, first + 2});
    if (i > 0) mesh.triangles.push_back({first, first + 1, first - 1});
    if (i % 10 == 0) mesh.triangles.push_back({first, first, first + 1});
  }
  mesh.normals.assign(mesh.positions_m.size(), {0.0f, 0.0f, 1.0f});
  return mesh;
}

TEST(RayCasterHardCases, AgreesWithBruteForceInDoublePrecision) {
  std::mt19937 random(kSeed);
  std::normal_distribution<float> normal;
  const Mesh mesh = TriangleSoup(random);
  const RayCaster caster(mesh);
  int hits = 0;
  int misses = 0;
  for (int i = 0; i < 20000; ++i) {
    const glm::vec3 origin = 1.5f * glm::vec3(normal(random), normal(random), normal(random));
    const glm::vec3 direction = RandomDirection(random);
    const Reference expected = BruteForce(mesh, origin, direction);
    const auto hit = caster.Intersect(origin, direction);
    if (expected.doubtful) continue;
    ASSERT_EQ(hit.has_value(), expected.distance_m.has_value()) << "seed " << kSeed << " ray " << i;
    ASSERT_EQ(caster.Occluded(origin, direction), hit.has_value());
    if (!hit) {
      ++misses;
      continue;
    }
    ++hits;
    // The plane's distance is exact; two surfaces within 1e-5 may be treated as one another.
    ASSERT_NEAR(hit->distance_m, *expected.distance_m, 1e-5);
    // The point is on the ray but for the barycentric weights' rounding over the triangle's size.
    const glm::vec3 on_ray = origin + hit->distance_m * direction;
    ASSERT_LT(glm::distance(hit->position_m, on_ray), 1e-4f);
    ASSERT_NEAR(glm::length(hit->geometric_normal), 1.0f, 1e-6f);
  }
  EXPECT_GT(hits, 3000);
  EXPECT_GT(misses, 3000);
}

// 10^6 rays a scale, from random points of the walls into the box.
TEST(RayCasterHardCases, ClosedBoxNeitherLeaksNorHitsItself) {
  for (const double scale : kScales) {
    const Mesh box = SkewBox(scale);
    const RayCaster caster(box);
    std::mt19937 random(kSeed);
    int leaks = 0;
    int self_hits = 0;
    for (int i = 0; i < 1000000; ++i) {
      const auto triangle = static_cast<std::uint32_t>(random() % box.triangles.size());
      const glm::vec3 inward = -TriangleNormal(box, triangle);
      glm::vec3 direction = RandomDirection(random);
      // Every fourth ray grazes the wall, down to 1e-6 rad.
      if (i % 4 == 0) {
        const float lift = std::pow(10.0f, -static_cast<float>(i % 6) - 1.0f);
        direction = glm::normalize(glm::cross(inward, direction)) + lift * inward;
        direction = glm::normalize(direction);
      }
      if (glm::dot(direction, inward) <= 0.0f) direction = -direction;
      if (glm::dot(direction, inward) <= 0.0f) continue;
      const glm::vec3 origin = OffsetFromSurface(RandomPoint(box, triangle, random), inward);
      const auto hit = caster.Intersect(origin, direction);
      if (!hit) ++leaks;
      if (hit && hit->triangle == triangle) ++self_hits;
      if (i % 16 == 0 && !caster.Occluded(origin, direction)) ++leaks;
    }
    EXPECT_EQ(leaks, 0) << "scale " << scale << " seed " << kSeed;
    EXPECT_EQ(self_hits, 0) << "scale " << scale << " seed " << kSeed;
  }
}

// From outside, where a leak of the offset would be a false shadow: a convex body shades itself
// nowhere.
TEST(RayCasterHardCases, AConvexBodyNeverOccludesItself) {
  for (const double scale : kScales) {
    const Mesh box = SkewBox(scale);
    const RayCaster caster(box);
    std::mt19937 random(kSeed);
    int occluded = 0;
    for (int i = 0; i < 100000; ++i) {
      const auto triangle = static_cast<std::uint32_t>(random() % box.triangles.size());
      const glm::vec3 outward = TriangleNormal(box, triangle);
      glm::vec3 direction = RandomDirection(random);
      if (i % 4 == 0) {
        direction = glm::normalize(glm::cross(outward, direction)) + 1e-3f * outward;
        direction = glm::normalize(direction);
      }
      if (glm::dot(direction, outward) <= 0.0f) direction = -direction;
      if (glm::dot(direction, outward) <= 0.0f) continue;
      const glm::vec3 origin = OffsetFromSurface(RandomPoint(box, triangle, random), outward);
      if (caster.Occluded(origin, direction)) ++occluded;
    }
    EXPECT_EQ(occluded, 0) << "scale " << scale << " seed " << kSeed;
  }
}

// A ground of 200 m seen at its middle, tilted: positions are small, triangles large. Embree alone
// finds the ground again from there.
TEST(RayCasterHardCases, LargeTrianglesAreLeftNearTheOriginToo) {
  Mesh ground;
  ground.positions_m = {{-100.0f, -100.0f, 0.0f},
                        {100.0f, -100.0f, 0.0f},
                        {100.0f, 100.0f, 0.0f},
                        {-100.0f, 100.0f, 0.0f}};
  ground.normals.assign(4, {0.0f, 0.0f, 1.0f});
  ground.triangles = {{0, 1, 2}, {0, 2, 3}};
  const glm::dmat4 tilt =
      glm::rotate(glm::dmat4(1.0), 0.7, glm::normalize(glm::dvec3(1.0, 0.4, 0.2)));
  ground = TransformMesh(tilt, ground);
  const RayCaster caster(ground);
  const glm::vec3 up = TriangleNormal(ground, 0);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int occluded = 0;
  for (int i = 0; i < 50000; ++i) {
    const glm::vec3 point(tilt * glm::dvec4(uniform(random), uniform(random), 0.0, 1.0));
    // The plane through the rounded corners is the ground, so a ray finds the point on it.
    const auto hit = caster.Intersect(point + 2.0f * up, -up);
    ASSERT_TRUE(hit.has_value());
    glm::vec3 direction = RandomDirection(random);
    if (glm::dot(direction, up) < 0.0f) direction = -direction;
    // The two triangles' planes differ by the rounding of corners, 1e-7 rad.
    if (glm::dot(direction, up) < 1e-5f) continue;
    if (caster.Occluded(OffsetFromSurface(hit->position_m, up), direction)) ++occluded;
  }
  EXPECT_EQ(occluded, 0) << "seed " << kSeed;
}

// From inside, aimed at points of edges and at corners.
TEST(RayCasterHardCases, RaysDoNotSlipThroughEdgesAndVertices) {
  for (const double scale : kScales) {
    const Mesh box = SkewBox(scale);
    const RayCaster caster(box);
    std::mt19937 random(kSeed);
    std::uniform_real_distribution<double> uniform(0.05, 0.95);
    int leaks = 0;
    for (int i = 0; i < 50000; ++i) {
      glm::dvec3 origin(0.0);
      double total = 0.0;
      for (const glm::vec3& corner : box.positions_m) {  // A mean of corners is inside.
        const double weight = uniform(random);
        origin += weight * glm::dvec3(corner);
        total += weight;
      }
      origin /= total;
      const glm::uvec3 triangle = box.triangles[random() % box.triangles.size()];
      const int corner = static_cast<int>(random() % 3);
      const glm::dvec3 from(box.positions_m[triangle[corner]]);
      const glm::dvec3 to(box.positions_m[triangle[(corner + 1) % 3]]);
      const double share = i % 2 == 0 ? 0.0 : uniform(random);
      const glm::dvec3 aim = from + share * (to - from);
      const glm::vec3 start(origin);
      const glm::vec3 direction(glm::normalize(aim - glm::dvec3(start)));
      if (!caster.Intersect(start, direction)) ++leaks;
      if (!caster.Occluded(start, direction)) ++leaks;
    }
    EXPECT_EQ(leaks, 0) << "scale " << scale << " seed " << kSeed;
  }
}

TEST(RayCasterHardCases, RaysWithoutMeaningMiss) {
  const RayCaster caster(BoxMesh(glm::vec3(-1.0f), glm::vec3(1.0f)));
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const glm::vec3 sound_origin(0.0f);
  const glm::vec3 sound_direction(1.0f, 0.0f, 0.0f);
  for (const float bad : {kNaN, kInfinity, -kInfinity, 3e38f}) {
    for (const bool in_origin : {true, false}) {
      const glm::vec3 origin = in_origin ? glm::vec3(0.0f, bad, 0.0f) : sound_origin;
      const glm::vec3 direction = in_origin ? sound_direction : glm::vec3(bad, 0.0f, 0.0f);
      EXPECT_FALSE(caster.Intersect(origin, direction).has_value());
      EXPECT_FALSE(caster.Occluded(origin, direction));
      const glm::vec3 origins[2] = {origin, sound_origin};
      const glm::vec3 directions[2] = {direction, sound_direction};
      bool occluded[2] = {true, false};
      caster.Occluded(origins, directions, 2, occluded);
      EXPECT_FALSE(occluded[0]);
      EXPECT_TRUE(occluded[1]);
    }
  }
  EXPECT_FALSE(caster.Occluded(sound_origin, glm::vec3(0.0f)));
  EXPECT_FALSE(caster.Occluded(sound_origin, sound_direction, kNaN));
}

TEST(RayCasterHardCases, CornersThatAreNotFiniteAreLeftOut) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 3e38f}) {
    Mesh mesh = BoxMesh(glm::vec3(-1.0f), glm::vec3(1.0f));
    mesh.positions_m.push_back({bad, 0.0f, 0.0f});
    mesh.triangles.push_back({0, 1, 8});
    const RayCaster caster(mesh);
    const auto hit = caster.Intersect(glm::vec3(0.0f), {0.0f, 0.0f, 1.0f});
    ASSERT_TRUE(hit.has_value());
    EXPECT_EQ(hit->distance_m, 1.0f);
  }
}

// Two casters of one mesh return the same, hit for hit, rays through vertices included.
TEST(RayCasterHardCases, AnswersAreRepeatable) {
  std::mt19937 random(kSeed);
  const Mesh mesh = TriangleSoup(random);
  const RayCaster first(mesh);
  const RayCaster second(mesh);
  for (int i = 0; i < 20000; ++i) {
    const glm::vec3 aim = mesh.positions_m[random() % mesh.positions_m.size()];
    const glm::vec3 direction = RandomDirection(random);
    const auto a = first.Intersect(aim - 2.0f * direction, direction);
    const auto b = second.Intersect(aim - 2.0f * direction, direction);
    ASSERT_EQ(a.has_value(), b.has_value());
    if (!a) continue;
    ASSERT_EQ(a->triangle, b->triangle);
    ASSERT_EQ(a->distance_m, b->distance_m);
  }
}

}  // namespace
}  // namespace pleinair::ray_caster_hard_cases_test
