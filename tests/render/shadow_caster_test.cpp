#include "render/internal/shadow_caster.h"

#include <random>
#include <string>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "scene/ray_caster.h"
#include "test_scenes.h"

namespace pleinair::test::shadow_caster_test {
namespace {

ShadowCaster CasterOf(const Mesh& mesh) { return {mesh.positions_m, mesh.triangles}; }

ShadowVolumes VolumesOf(const Mesh& mesh, const glm::dvec3& to_sun) {
  ShadowVolumes volumes;
  CasterOf(mesh).BuildVolumes(to_sun, std::nullopt, volumes);
  return volumes;
}

// How often a half line crosses the volumes' faces, outwards minus inwards: the number of prisms
// that hold `point`. Along a line that a camera might look along; sides end at infinity, so that
// they are cut at a distance that no point here reaches.
int PrismsAround(const ShadowCaster& caster,
                 const ShadowVolumes& volumes,
                 const glm::dvec3& to_sun,
                 const glm::dvec3& point) {
  const glm::dvec3 line = glm::normalize(glm::dvec3(0.31, 0.87, 0.11));
  int count = 0;
  const auto cross = [&](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    const double facing = glm::dot(normal, line);
    if (facing == 0.0) return;
    const double distance = glm::dot(normal, a - point) / facing;
    if (distance <= 0.0) return;
    const glm::dvec3 hit = point + distance * line;
    const bool inside = glm::dot(glm::cross(b - a, hit - a), normal) > 0.0 &&
                        glm::dot(glm::cross(c - b, hit - b), normal) > 0.0 &&
                        glm::dot(glm::cross(a - c, hit - c), normal) > 0.0;
    if (inside) count += facing > 0.0 ? 1 : -1;
  };
  const auto at = [&](std::uint32_t index) { return glm::dvec3(caster.Positions()[index]); };
  const glm::dvec3 far_away = -1e4 * to_sun;
  for (std::size_t i = 0; i < volumes.caps.size(); i += 3) {
    cross(at(volumes.caps[i]), at(volumes.caps[i + 1]), at(volumes.caps[i + 2]));
  }
  for (std::size_t i = 0; i < volumes.sides.size(); i += 3) {
    const glm::dvec3 a = at(volumes.sides[i]);
    const glm::dvec3 b = at(volumes.sides[i + 1]);
    cross(a, b, b + far_away);
    cross(a, b + far_away, a + far_away);
  }
  return count;
}

// Random points around `mesh`: in a prism exactly where a ray to the sun meets the mesh.
void ExpectVolumesHoldTheShadow(const Mesh& mesh, const glm::dvec3& to_sun, const char* what) {
  const ShadowCaster caster = CasterOf(mesh);
  ShadowVolumes volumes;
  caster.BuildVolumes(to_sun, std::nullopt, volumes);
  const RayCaster rays(mesh);
  constexpr unsigned kSeed = 7;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<float> place(-3.0f, 3.0f);
  int in_shadow = 0;
  for (int i = 0; i < 400; ++i) {
    const glm::vec3 point(place(random), place(random), place(random));
    const bool is_shadowed = rays.Occluded(point, glm::vec3(to_sun));
    const int prisms = PrismsAround(caster, volumes, to_sun, glm::dvec3(point));
    EXPECT_EQ(prisms > 0, is_shadowed) << what << ", seed " << kSeed << ", point " << i;
    EXPECT_GE(prisms, 0) << what << ", seed " << kSeed << ", point " << i;
    in_shadow += is_shadowed ? 1 : 0;
  }
  EXPECT_GT(in_shadow, 5) << what;  // The case covers what it tests.
}

TEST(ShadowCaster, VolumesHoldTheShadowOfClosedMeshes) {
  const glm::dvec3 to_sun = DirectionOf(200.0, 40.0);
  ExpectVolumesHoldTheShadow(Box({-1, -1, -1}, {1, 1, 1}), to_sun, "box");
  ExpectVolumesHoldTheShadow(Sphere({0, 0, 0}, 1.2f, 12), to_sun, "sphere");
  ExpectVolumesHoldTheShadow(
      Join(Box({-1, -1, -1}, {0.5f, 1, 1}), Box({-0.5f, -0.5f, 0}, {1, 2, 1.5f})),
      to_sun,
      "boxes through each other");
}

// A room seen from inside: its floor is in the shadow of its ceiling.
TEST(ShadowCaster, VolumesHoldTheShadowInsideAnInvertedBox) {
  ExpectVolumesHoldTheShadow(
      TurnedInsideOut(Box({-2, -2, -2}, {2, 2, 2})), DirectionOf(30.0, 50.0), "room");
}

TEST(ShadowCaster, VolumesHoldTheShadowOfOpenAndNonManifoldMeshes) {
  for (const double elevation : {-35.0, 20.0, 65.0}) {
    const glm::dvec3 to_sun = DirectionOf(140.0, elevation);
    ExpectVolumesHoldTheShadow(Ground(1.5f), to_sun, "sheet");
    Mesh open = Box({-1, -1, -1}, {1, 1, 1});
    open.triangles.pop_back();
    ExpectVolumesHoldTheShadow(open, to_sun, "box with a hole in its top");
    open.triangles.erase(open.triangles.begin(), open.triangles.begin() + 6);
    ExpectVolumesHoldTheShadow(open, to_sun, "half of a box");
    Mesh poleless = Sphere({0, 0, 0}, 1.2f, 12);
    std::erase_if(poleless.triangles, [](const glm::uvec3& t) { return t.x == 0; });
    ExpectVolumesHoldTheShadow(poleless, to_sun, "sphere without its north pole");
    Mesh turned = Box({-1, -1, -1}, {1, 1, 1});
    std::swap(turned.triangles[3].x, turned.triangles[3].y);
    ExpectVolumesHoldTheShadow(turned, to_sun, "box with one triangle turned over");
    const Mesh doubled = Join(Ground(1.5f), TurnedInsideOut(Ground(1.5f)));
    ExpectVolumesHoldTheShadow(doubled, to_sun, "doubled sheet");
    const Mesh fin =
        Join(Box({-1, -1, -1}, {1, 1, 0}),
             MeshOf({{-1, -1, 0}, {1, -1, 0}, {0, -1, 1.5f}}, {{0, 1, 2}}, Material{}));
    ExpectVolumesHoldTheShadow(fin, to_sun, "box with a fin on an edge");
  }
}

TEST(ShadowCaster, AClosedMeshCastsWithItsFrontsAndItsSilhouetteAlone) {
  // Sun from above and one side: two faces of the box see it, and six edges bound them.
  const ShadowVolumes volumes =
      VolumesOf(Box({-1, -1, -1}, {1, 1, 1}), glm::normalize(glm::dvec3(0.0, -1.0, 2.0)));
  EXPECT_EQ(volumes.caps.size() / 3, 4u);
  EXPECT_EQ(volumes.sides.size() / 3, 6u);
}

TEST(ShadowCaster, EveryBatchFitsIntoTheStencil) {
  Mesh stack;
  for (int i = 0; i < 300; ++i) stack = Join(stack, Ground(1.0f, 0.01f * static_cast<float>(i)));
  const ShadowVolumes volumes = VolumesOf(stack, {0.0, 0.0, 1.0});
  std::size_t caps = 0;
  for (const ShadowVolumes::Batch& batch : volumes.batches) {
    EXPECT_LE(batch.depth_bound, ShadowVolumes::kMaxBatchDepth);
    caps += batch.cap_count / 3;
  }
  EXPECT_GE(volumes.batches.size(), 3u);
  EXPECT_EQ(caps, 600u);
}

TEST(ShadowCaster, LeavesOutWhatCannotShadeTheReceivers) {
  const Mesh scene =
      Join(Ground(50.0f), Join(Box({5, 5, 0}, {9, 9, 4}), Box({-1, 5, 0}, {1, 6, 4})));
  const ShadowCaster caster = CasterOf(scene);
  ShadowVolumes volumes;
  // Sun from the north: only the box to the north of the receivers can reach them.
  const glm::dvec3 to_sun = DirectionOf(0.0, 40.0);
  caster.BuildVolumes(to_sun, BoundingBox{{-0.5f, -0.5f, 0.0f}, {0.5f, 0.5f, 2.0f}}, volumes);
  EXPECT_GE(volumes.caps.size() / 3, 1u);
  EXPECT_LE(volumes.caps.size() / 3, 4u);
  caster.BuildVolumes(to_sun, BoundingBox{{-20.5f, -0.5f, 0.0f}, {-20.0f, 0.5f, 2.0f}}, volumes);
  EXPECT_TRUE(volumes.batches.empty());
}

TEST(ShadowCaster, TakesMeshesWithoutAnythingInThem) {
  EXPECT_TRUE(VolumesOf(Mesh{}, {0.0, 0.0, 1.0}).batches.empty());
  const Mesh needle = MeshOf({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}}, {{0, 1, 2}}, Material{});
  EXPECT_TRUE(VolumesOf(needle, {0.0, 0.0, 1.0}).batches.empty());
}

}  // namespace
}  // namespace pleinair::test::shadow_caster_test
