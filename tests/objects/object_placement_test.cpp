// Objects that rest on floors, walls, slopes and stairs.
#include "objects/object_placement.h"

#include <cmath>
#include <filesystem>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <glm/gtc/matrix_transform.hpp>

#include "scene/mesh_io.h"
#include "tests/objects/placement_stage.h"

namespace pleinair::object_placement_test {
namespace {

using namespace placement_stage;

// The bar: within 1 mm of the surface, the axis within 0.1 deg of the normal, nowhere in the mesh.
void ExpectRests(const Mesh& object,
                 const RestingObject& resting,
                 const SurfacePoint& point,
                 const Mesh& mesh) {
  const Mesh placed = TransformMesh(resting.world_from_object, object);
  EXPECT_LE(Gap(placed, mesh), 1e-3);
  EXPECT_EQ(Crossings(placed, mesh), 0);
  EXPECT_LE(AngleDeg(AxisOf(resting.world_from_object), point.normal), 0.1);
}

// 0.4 m wide, 0.3 m deep and 0.6 m high, its foot at the origin.
Mesh Crate() { return BoxMesh({-0.2f, -0.15f, 0.0f}, {0.2f, 0.15f, 0.6f}); }

// Turned every way and three times as large, far away.
glm::dmat4 SomePose() {
  glm::dmat4 pose = glm::translate(glm::dmat4(1.0), {30.0, -20.0, 7.0});
  return glm::rotate(pose, 2.1, glm::normalize(glm::dvec3(0.3, -0.8, 0.4)));
}

struct Stage {
  explicit Stage(Mesh scene) : mesh(std::move(scene)), caster(mesh) {}
  std::optional<SurfacePoint> Pick(const glm::dvec3& from, const glm::dvec3& towards) const {
    return SurfaceAlong(caster, mesh, from, glm::normalize(towards - from));
  }
  std::optional<RestingObject> Rest(const Mesh& object,
                                    const SurfacePoint& point,
                                    const glm::dmat4& pose = glm::dmat4(1.0)) const {
    return RestOn(PlaceableObject(object), pose, point, caster, mesh);
  }
  Mesh mesh;
  RayCaster caster;
};

TEST(ObjectPlacement, RestsOnAFloorWhereItWasPutDown) {
  const Stage stage(Floor().Done());
  const auto point = stage.Pick({1.0, -5.0, 3.0}, {1.5, 0.25, 0.0});
  ASSERT_TRUE(point);
  const auto resting = stage.Rest(Crate(), *point);
  ASSERT_TRUE(resting);
  ExpectRests(Crate(), *resting, *point, stage.mesh);
  const glm::dvec3 foot = FootOf(PlaceableObject(Crate()), resting->world_from_object);
  EXPECT_NEAR(foot.x, 1.5, 1e-5);
  EXPECT_NEAR(foot.y, 0.25, 1e-5);
  // 0.1 mm of clearance, and rounding.
  EXPECT_NEAR(foot.z, 1e-4, 1e-5);
  EXPECT_EQ(resting->slid_m, glm::dvec3(0.0));
}

// The turn about the axis stays: the smallest rotation that brings the axis to the normal.
TEST(ObjectPlacement, KeepsItsTurnAndItsScale) {
  const Stage stage(Floor().Done());
  const auto point = stage.Pick({0.0, -5.0, 3.0}, {0.0, 0.0, 0.0});
  glm::dmat4 pose = glm::rotate(glm::dmat4(1.0), 0.7, {0.0, 0.0, 1.0});
  pose = glm::scale(pose, glm::dvec3(0.5));
  const auto turned = stage.Rest(Crate(), *point, pose);
  ASSERT_TRUE(turned);
  for (int column = 0; column < 3; ++column) {
    EXPECT_LT(glm::distance(turned->world_from_object[column], pose[column]), 1e-12);
  }
  // Tilted by 0.4 about X and put back: as it was before.
  const auto upright = stage.Rest(Crate(), *point, glm::rotate(glm::dmat4(1.0), 0.4, {1, 0, 0}));
  ASSERT_TRUE(upright);
  EXPECT_LT(glm::distance(glm::dvec3(upright->world_from_object[0]), {1, 0, 0}), 1e-12);
  // Upside down there are many smallest rotations: it is the one about its X axis.
  const auto turned_over =
      stage.Rest(Crate(), *point, glm::rotate(glm::dmat4(1.0), kPi, {0, 1, 0}));
  ASSERT_TRUE(turned_over);
  EXPECT_LT(glm::distance(glm::dvec3(turned_over->world_from_object[0]), {-1, 0, 0}), 1e-9);
  ExpectRests(Crate(), *turned_over, *point, stage.mesh);
}

TEST(ObjectPlacement, RestsOnAWallASlopeAndASheetFromEitherSide) {
  Builder builder = Floor();
  builder.Box("wall", {-10, 3, 0}, {10, 3.2f, 4});
  // 30 degrees, rising towards -X.
  const float rise = 4.0f * std::tan(static_cast<float>(kPi) / 6.0f);
  builder.Quad("slope", {-9, -9, rise}, {-9, -4, rise}, {-5, -4, 0}, {-5, -9, 0});
  builder.Quad("sheet", {5, -2, 1}, {9, -2, 1}, {9, 2, 1}, {5, 2, 1});
  const Stage stage(builder.Done());
  const glm::dvec3 eye(0.0, -8.0, 1.7);
  struct Case {
    glm::dvec3 from;
    glm::dvec3 towards;
    std::string group;
    glm::dvec3 normal;
  };
  const double sine = 0.5;
  const double cosine = std::sqrt(0.75);
  for (const Case& one :
       {Case{eye, {1.0, 3.0, 2.0}, "wall", {0, -1, 0}},
        Case{eye + glm::dvec3(0, 0, 3), {-7.0, -6.5, 1.15}, "slope", {sine, 0, cosine}},
        Case{{7.0, 0.0, 3.0}, {7.0, 0.1, 1.0}, "sheet", {0, 0, 1}},
        Case{{7.0, -4.0, 0.2}, {7.0, 0.0, 1.0}, "sheet", {0, 0, -1}}}) {
    const auto point = stage.Pick(one.from, one.towards);
    ASSERT_TRUE(point) << one.group;
    EXPECT_EQ(point->group, one.group);
    EXPECT_LT(AngleDeg(point->normal, one.normal), 1e-4) << one.group;
    for (const glm::dmat4& pose : {glm::dmat4(1.0), SomePose()}) {
      const auto resting = stage.Rest(Crate(), *point, pose);
      ASSERT_TRUE(resting) << one.group;
      ExpectRests(Crate(), *resting, *point, stage.mesh);
      EXPECT_EQ(resting->slid_m, glm::dvec3(0.0)) << one.group;
    }
  }
}

TEST(ObjectPlacement, SlidesAwayFromAWallAndOutOfACorner) {
  Builder builder = Floor();
  builder.Box("wall", {-10, 3, 0}, {10, 3.2f, 4});
  builder.Quad("sheet", {2, -10, 0}, {2, 3, 0}, {2, 3, 4}, {2, -10, 4});
  const Stage stage(builder.Done());
  // 5 cm before the wall, with 15 cm of crate in the way.
  auto point = stage.Pick({0.0, 0.0, 1.7}, {0.0, 2.95, 0.0});
  ASSERT_TRUE(point);
  auto resting = stage.Rest(Crate(), *point);
  ASSERT_TRUE(resting);
  ExpectRests(Crate(), *resting, *point, stage.mesh);
  EXPECT_LT(glm::distance(resting->slid_m, {0.0, -0.1, 0.0}), 1e-3);
  // In the corner, out of both; the sheet's other side does not count as free.
  point = stage.Pick({0.0, 0.0, 1.7}, {1.9, 2.9, 0.0});
  ASSERT_TRUE(point);
  resting = stage.Rest(Crate(), *point);
  ASSERT_TRUE(resting);
  ExpectRests(Crate(), *resting, *point, stage.mesh);
  EXPECT_LT(glm::distance(resting->slid_m, {-0.1, -0.05, 0.0}), 1e-3);
  // On the wall near the floor: upwards.
  point = stage.Pick({0.0, 0.0, 1.7}, {0.0, 3.0, 0.05});
  ASSERT_TRUE(point);
  EXPECT_EQ(point->group, "wall");
  resting = stage.Rest(Crate(), *point);
  ASSERT_TRUE(resting);
  ExpectRests(Crate(), *resting, *point, stage.mesh);
  EXPECT_GT(resting->slid_m.z, 0.05);
}

TEST(ObjectPlacement, AKerbRaisesItAndATableThatItDoesNotFitUnderHasNoRoom) {
  Builder builder = Floor();
  builder.Box("kerb", {-10, 1, 0}, {10, 5, 0.03f});
  builder.Box("table", {-3, -3, 0.5f}, {-1, -1, 0.52f});
  builder.Box("ceiling", {-10, -10, 2.2f}, {10, 10, 2.3f});
  const Stage stage(builder.Done());
  // 5 cm short of the kerb: 10 cm of crate over it, and 3 cm up is the shorter way.
  const auto point = stage.Pick({0.0, -3.0, 1.7}, {0.0, 0.95, 0.0});
  ASSERT_TRUE(point);
  EXPECT_EQ(point->group, "floor");
  const auto resting = stage.Rest(Crate(), *point);
  ASSERT_TRUE(resting);
  ExpectRests(Crate(), *resting, *point, stage.mesh);
  EXPECT_NEAR(resting->raised_m, 0.03, 1e-3);
  EXPECT_EQ(resting->slid_m, glm::dvec3(0.0));
  // Under the table, 0.5 m high, a crate of 0.6 m: on top of it is no place in sight of the point.
  const auto below = stage.Pick({-2.0, -8.0, 0.3}, {-2.0, -2.0, 0.0});
  ASSERT_TRUE(below);
  EXPECT_EQ(below->group, "floor");
  EXPECT_FALSE(stage.Rest(Crate(), *below));
  // Half of the size fits.
  const glm::dmat4 half = glm::scale(glm::dmat4(1.0), glm::dvec3(0.5));
  const auto fits = stage.Rest(Crate(), *below, half);
  ASSERT_TRUE(fits);
  ExpectRests(Crate(), *fits, *below, stage.mesh);
  EXPECT_EQ(fits->slid_m, glm::dvec3(0.0));
}

// All along a flight of stairs: treads and risers, objects that fit a tread and that do not.
TEST(ObjectPlacement, RestsAnywhereOnStairs) {
  const Stage stage(Stairs());
  int on_riser = 0;
  int slid = 0;
  int raised = 0;
  for (const Mesh& object : {BoxMesh({-0.05f, -0.05f, 0.0f}, {0.05f, 0.05f, 0.1f}),
                             BoxMesh({-0.2f, -0.2f, 0.0f}, {0.2f, 0.2f, 0.1f}),
                             SphereMesh(0.25f, 24, 48)}) {
    for (double height = 0.003; height < 1.0; height += 0.0137) {
      // From the front and above: rays that fall by 45 degrees meet treads and risers in turn.
      const auto point = stage.Pick({0.1, -3.0, 3.0 + 2.0 * height}, {0.1, 0.0, 2.0 * height});
      if (!point || point->group != "stairs") continue;
      const auto resting = stage.Rest(object, *point);
      ASSERT_TRUE(resting) << "height " << height;
      ExpectRests(object, *resting, *point, stage.mesh);
      on_riser += std::abs(point->normal.z) < 0.5;
      slid += resting->slid_m != glm::dvec3(0.0);
      raised += resting->raised_m > 0.01;
    }
  }
  EXPECT_GT(on_riser, 10);
  EXPECT_GT(slid, 10);
  EXPECT_GT(raised, 10);
}

// Picked at the rim of a platform, an object whose lowest corner hangs beyond it is let down.
TEST(ObjectPlacement, IsLetDownWhereItsLowestCornerHangsBeyondTheEdge) {
  Builder builder = Floor();
  builder.Box("platform", {-2, -2, 0}, {2, 2, 1});
  const Stage stage(builder.Done());
  // A slanted underside: 0 at x = +0.5, 0.2 m higher at the other end.
  Mesh wedge = BoxMesh({-0.5f, -0.1f, 0.0f}, {0.5f, 0.1f, 0.5f});
  for (glm::vec3& corner : wedge.positions_m) {
    if (corner.z == 0.0f && corner.x < 0.0f) corner.z = 0.2f;
  }
  const auto point = stage.Pick({0.0, 0.0, 3.0}, {1.9, 0.0, 1.0});
  ASSERT_TRUE(point);
  EXPECT_EQ(point->group, "platform");
  const auto resting = stage.Rest(wedge, *point);
  ASSERT_TRUE(resting);
  ExpectRests(wedge, *resting, *point, stage.mesh);
  // Over the rim, at 2 - 1.9 m from its foot, the underside is 0.08 m over its lowest corner.
  EXPECT_NEAR(resting->raised_m, -0.08, 1e-3);
}

// What is wrong with an object's mesh does not matter: its hull does.
TEST(ObjectPlacement, OpenAndNonManifoldObjectsRest) {
  const Stage stage(Stairs());
  const auto point = stage.Pick({0.3, -3.0, 3.0}, {0.3, 0.4, 0.34});
  ASSERT_TRUE(point);
  Mesh sheet = Builder()
                   .Quad("sheet", {-0.1f, 0, 0}, {0.1f, 0, 0}, {0.1f, 0, 0.3f}, {-0.1f, 0, 0.3f})
                   .Done();
  Mesh flat =
      Builder()
          .Quad("mat", {-0.1f, -0.05f, 0}, {0.1f, -0.05f, 0}, {0.1f, 0.05f, 0}, {-0.1f, 0.05f, 0})
          .Done();
  Mesh doubled = Crate();
  doubled.triangles.push_back(doubled.triangles.front());
  doubled.triangles.push_back({0, 7, 3});
  doubled.triangles.push_back({2, 2, 2});
  doubled.positions_m.emplace_back(1e9f);  // Of no triangle.
  for (Mesh* object : {&sheet, &flat, &doubled}) {
    SCOPED_TRACE(object->group_names.front());
    object->triangle_group.assign(object->triangles.size(), 0);
    object->triangle_material.assign(object->triangles.size(), 0);
    object->normals.assign(object->positions_m.size(), glm::vec3(0, 0, 1));
    const auto resting = stage.Rest(*object, *point);
    ASSERT_TRUE(resting);
    ExpectRests(*object, *resting, *point, stage.mesh);
  }
}

// The floor is a fan of slivers, some without area, and one corner of the mesh is not a number.
TEST(ObjectPlacement, RestsOnSliversAndPassesOverBrokenTriangles) {
  Mesh mesh = Floor().Done();
  mesh.triangles.clear();
  mesh.positions_m = {{-10, -10, 0}, {10, -10, 0}, {10, 10, 0}, {-10, 10, 0}};
  for (int i = 0; i <= 4000; ++i) {
    mesh.positions_m.emplace_back(-10.0f + 0.005f * static_cast<float>(i), 10.0f, 0.0f);
  }
  for (std::uint32_t i = 0; i < 4000; ++i) mesh.triangles.push_back({0, 5 + i, 4 + i});
  mesh.triangles.push_back({0, 1, 2});
  mesh.triangles.push_back({0, 2, 2});
  mesh.positions_m.emplace_back(std::nanf(""));
  mesh.triangles.push_back({0, 1, 4005});
  mesh.triangle_group.assign(mesh.triangles.size(), 0);
  mesh.triangle_material.assign(mesh.triangles.size(), 0);
  mesh.normals.assign(mesh.positions_m.size(), glm::vec3(0, 0, 1));
  const Stage stage(mesh);
  const auto point = stage.Pick({-4.0, -8.0, 3.0}, {-2.0, 4.0, 0.0});
  ASSERT_TRUE(point);
  EXPECT_LT(AngleDeg(point->normal, {0, 0, 1}), 1e-9);
  const auto resting = stage.Rest(Crate(), *point);
  ASSERT_TRUE(resting);
  EXPECT_NEAR(FootOf(PlaceableObject(Crate()), resting->world_from_object).z, 1e-4, 1e-5);
}

TEST(ObjectPlacement, TurnsLiftsAndScalesAboutItsFoot) {
  const PlaceableObject object(Crate());
  const glm::dmat4 pose = SomePose();
  const glm::dvec3 foot = FootOf(object, pose);
  const glm::dmat4 turned = Turned(object, pose, 0.5);
  EXPECT_LT(glm::distance(FootOf(object, turned), foot), 1e-12);
  EXPECT_LT(AngleDeg(AxisOf(turned), AxisOf(pose)), 1e-9);
  EXPECT_NEAR(AngleDeg(turned[0], pose[0]), 0.5 * 180.0 / kPi, 1e-9);
  // Counter-clockwise from above.
  EXPECT_GT(glm::dot(glm::cross(glm::dvec3(pose[0]), glm::dvec3(turned[0])), AxisOf(pose)), 0.0);
  const glm::dmat4 lifted = Lifted(pose, 0.25);
  EXPECT_LT(glm::distance(FootOf(object, lifted), foot + 0.25 * AxisOf(pose)), 1e-12);
  const glm::dmat4 scaled = Scaled(object, pose, 3.0);
  EXPECT_LT(glm::distance(FootOf(object, scaled), foot), 1e-12);
  EXPECT_NEAR(glm::length(glm::dvec3(scaled[1])), 3.0, 1e-12);
  for (const double factor : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_THROW(Scaled(object, pose, factor), std::invalid_argument);
  }
}

TEST(ObjectPlacement, RefusesWhatIsNoPoseAndNoObject) {
  const Stage stage(Floor().Done());
  const auto point = stage.Pick({0.0, -5.0, 3.0}, {0.0, 0.0, 0.0});
  EXPECT_THROW(stage.Rest(Crate(), *point, glm::dmat4(0.0)), std::invalid_argument);
  EXPECT_THROW(stage.Rest(Crate(), *point, glm::dmat4(std::nan(""))), std::invalid_argument);
  EXPECT_THROW(PlaceableObject(Mesh{}), std::invalid_argument);
}

// A courtyard, its own object and 200 places all over the picture, in poses of all kinds.
TEST(ObjectPlacement, RestsWhereverItIsDroppedInTheCourtyard) {
  const std::filesystem::path folder =
      std::filesystem::path(PLEINAIR_SOURCE_DIR) / "datasets/samples/courtyard";
  const Stage stage(LoadMesh(folder / "scene.obj").mesh);
  const Mesh object = LoadMesh(folder / "object.obj").mesh;
  const PlaceableObject placeable(object);
  Mesh buildings = stage.mesh;
  std::erase_if(buildings.triangles, [&, i = std::size_t{0}](const glm::uvec3&) mutable {
    return stage.mesh.group_names[stage.mesh.triangle_group[i++]] == "paving";
  });
  std::mt19937 random(18);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int rested = 0;
  int refused = 0;
  int slid = 0;
  int walls = 0;
  double worst_gap_m = 0.0;
  for (int drop = 0; rested + refused < 200; ++drop) {
    // Looking around from the middle at the height of eyes, mostly down.
    const auto point =
        stage.Pick({0.0, 0.0, 1.7},
                   {10.0 * uniform(random), 10.0 * uniform(random), 1.0 + 2.0 * uniform(random)});
    glm::dmat4 pose = glm::rotate(
        glm::dmat4(1.0), 3.0 * uniform(random), glm::dvec3(uniform(random), uniform(random), 1.0));
    pose = glm::scale(pose, glm::dvec3(std::exp(uniform(random))));
    if (!point) continue;
    const auto resting = RestOn(placeable, pose, *point, stage.caster, stage.mesh);
    if (!resting) {
      ++refused;
      continue;
    }
    ++rested;
    slid += resting->slid_m != glm::dvec3(0.0);
    walls += std::abs(point->normal.z) < 0.5;
    const Mesh placed = TransformMesh(resting->world_from_object, object);
    worst_gap_m = std::max(worst_gap_m, Gap(placed, stage.mesh));
    EXPECT_EQ(Crossings(placed, stage.mesh), 0) << "drop " << drop;
    EXPECT_LE(AngleDeg(AxisOf(resting->world_from_object), point->normal), 0.1);
    // One solid corner of it stands for all: what nothing crosses is inside or outside altogether.
    EXPECT_FALSE(IsInside(buildings, placed.positions_m.front())) << "drop " << drop;
  }
  EXPECT_LE(worst_gap_m, 1e-3);
  EXPECT_GE(rested, 195);
  EXPECT_GE(slid, 5);
  EXPECT_GE(walls, 20);
}

}  // namespace
}  // namespace pleinair::object_placement_test
