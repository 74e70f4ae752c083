// Shadow volumes where they are known to break, against ray casting.
#include <string>

#include <gtest/gtest.h>

#include "ray_cast_reference.h"
#include "render/compositor.h"
#include "render/gl_context.h"
#include "render/internal/composite_input.h"
#include "scene/mesh_io.h"
#include "shadow_mask.h"
#include "test_scenes.h"

namespace pleinair::test::shadow_mask_hard_cases_test {
namespace {

// At most 0.01 % of pixels farther than one pixel from an edge; at least one pixel may differ.
constexpr double kMaxDifferentShare = 1e-4;

class ShadowMaskHardCase : public testing::Test {
 protected:
  struct Picture {
    const Mesh& phantom;
    const Mesh& object;
    const Camera& camera;
    glm::dvec3 to_sun;
  };
  MaskComparison Compare(const Picture& picture) {
    ShadowMask mask;
    mask.SetPhantom(picture.phantom);
    mask.SetObjects({{picture.object}});
    return CompareShadowMasks(
        mask, Join(picture.phantom, picture.object), picture.camera, picture.to_sun);
  }
  void ExpectLikeRayCasting(const Picture& picture,
                            const std::string& what,
                            std::size_t least_shadowed = 20) {
    const MaskComparison comparison = Compare(picture);
    EXPECT_GE(comparison.shadowed, least_shadowed) << what;
    EXPECT_LE(comparison.DifferentShare(), kMaxDifferentShare)
        << what << ": " << comparison.different_off_edges << " pixels";
  }

  HeadlessContext context_;
  const Mesh ground_ = Ground(20.0f);
  const Mesh sphere_ = Sphere({0.0f, 0.0f, 1.2f}, 1.0f, 20);
  const Camera camera_ = LookAt({4.0, -5.0, 2.5}, {0.0, 0.0, 0.8}, 240, 180, 180.0);
};

TEST_F(ShadowMaskHardCase, CameraInsideAShadowVolume) {
  // Under a table's plate, looking out into the light, along the beam, and against it.
  const Mesh table = Box({-2.0f, -2.0f, 2.0f}, {2.0f, 2.0f, 2.2f});
  const glm::dvec3 to_sun = DirectionOf(150.0, 60.0);
  const glm::dvec3 eye = glm::dvec3(0.0, 0.0, 2.0) - 1.0 * to_sun;
  for (const glm::dvec3& ahead :
       {glm::dvec3(1.0, 0.2, -0.3), -to_sun, to_sun, glm::dvec3(-1, 0, 0)}) {
    const Camera camera = LookAt(eye, eye + ahead, 240, 180, 150.0);
    ExpectLikeRayCasting({ground_, table, camera, to_sun}, "ahead", 0);
  }
}

TEST_F(ShadowMaskHardCase, NearPlaneThroughAShadowVolume) {
  // A post right beside the camera, whose volume's sides pass through the eye's own place.
  const Mesh post = Box({-0.05f, -0.05f, 0.0f}, {0.05f, 0.05f, 3.0f});
  const glm::dvec3 to_sun = DirectionOf(180.0, 45.0);
  for (const double aside : {-0.05, 0.0, 0.02, 0.05, 0.051, 0.1}) {
    const Camera camera = LookAt({aside, 1.0, 1.2}, {aside, 5.0, 0.0}, 240, 180, 180.0);
    ExpectLikeRayCasting({ground_, post, camera, to_sun}, "aside " + std::to_string(aside), 0);
  }
}

TEST_F(ShadowMaskHardCase, SurfaceThatTouchesTheCamera) {
  const Camera camera = LookAt({0.0, -4.0, 0.001}, {0.0, 0.0, 0.5}, 240, 180, 180.0);
  ExpectLikeRayCasting({ground_, sphere_, camera, DirectionOf(100.0, 30.0)}, "eye on the ground");
}

TEST_F(ShadowMaskHardCase, SunAnywhere) {
  for (const double azimuth : {0.0, 45.0, 90.0, 141.34, 180.0, 321.34}) {
    for (const double elevation : {0.0, 0.5, 45.0, 90.0}) {
      // On the horizon nothing of the ground is lit or shaded: the sphere's own dark half is all.
      ExpectLikeRayCasting({ground_, sphere_, camera_, DirectionOf(azimuth, elevation)},
                           "sun " + std::to_string(azimuth) + " " + std::to_string(elevation),
                           0);
    }
  }
}

TEST_F(ShadowMaskHardCase, SunBelowTheGround) {
  ExpectLikeRayCasting({ground_, sphere_, camera_, DirectionOf(120.0, -20.0)}, "night");
}

TEST_F(ShadowMaskHardCase, SunBehindTheCameraAndStraightAhead) {
  const glm::dvec3 ahead = glm::normalize(glm::dvec3(0.0, 0.0, 0.8) - glm::dvec3(4.0, -5.0, 2.5));
  ExpectLikeRayCasting({ground_, sphere_, camera_, -ahead}, "behind", 0);
  const Camera up = LookAt({0.0, -6.0, 0.5}, {0.0, 0.0, 2.5}, 240, 180, 150.0);
  const glm::dvec3 to_sphere = glm::normalize(glm::dvec3(0.0, 6.0, 2.0));
  ExpectLikeRayCasting({ground_, sphere_, up, to_sphere}, "ahead", 0);
}

TEST_F(ShadowMaskHardCase, SunInThePlaneOfTriangles) {
  const Mesh box = Box({-1.0f, -1.0f, 0.0f}, {1.0f, 1.0f, 2.0f});
  for (const glm::dvec3& to_sun : {glm::dvec3(0.0, 0.0, 1.0),
                                   glm::normalize(glm::dvec3(0.0, -1.0, 1.0)),
                                   glm::dvec3(1.0, 0.0, 0.0)}) {
    ExpectLikeRayCasting({ground_, box, camera_, to_sun}, "box", 0);
  }
}

TEST_F(ShadowMaskHardCase, OpenAndNonManifoldCasters) {
  const glm::dvec3 to_sun = DirectionOf(215.0, 40.0);
  const Mesh sheet = MeshOf({{-1, 0, 0.3f}, {1, 0, 0.3f}, {1, 0.5f, 2}, {-1, 0.5f, 2}},
                            {{0, 1, 2}, {0, 2, 3}},
                            Material{});
  ExpectLikeRayCasting({ground_, sheet, camera_, to_sun}, "sheet");
  ExpectLikeRayCasting({ground_, TurnedInsideOut(sheet), camera_, to_sun}, "sheet turned over");
  ExpectLikeRayCasting({ground_, Join(sheet, TurnedInsideOut(sheet)), camera_, to_sun},
                       "doubled sheet");
  ExpectLikeRayCasting({ground_, Join(sphere_, sphere_), camera_, to_sun}, "doubled sphere");
  Mesh bowl = sphere_;
  bowl.triangles.resize(bowl.triangles.size() / 2);
  bowl.triangle_material.resize(bowl.triangles.size());
  bowl.triangle_group.resize(bowl.triangles.size());
  ExpectLikeRayCasting({ground_, bowl, camera_, to_sun}, "part of a sphere");
  ExpectLikeRayCasting(
      {ground_, Join(sphere_, Box({0, -0.5f, 0}, {2, 0.5f, 1.5f})), camera_, to_sun}, "through");
  // Three leaves on one edge, wound as it comes.
  const Mesh book = MeshOf({{0, 0, 0}, {0, 0, 2}, {1.2f, 0, 1}, {-0.8f, 0.9f, 1}, {-0.7f, -1, 1}},
                           {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}},
                           Material{});
  ExpectLikeRayCasting({ground_, book, camera_, to_sun}, "three triangles at an edge");
  // A sphere that goes through itself: a cap of it is pulled back through the rest.
  Mesh crossed = sphere_;
  for (glm::vec3& p : crossed.positions_m) {
    if (p.x > 0.4f) p.x = 0.8f - 2.0f * p.x;
  }
  ExpectLikeRayCasting({ground_, crossed, camera_, to_sun}, "self-intersecting");
}

TEST_F(ShadowMaskHardCase, HardMeshesOfTheCollection) {
  if (!SharedFile("data/meshes/suzanne.obj")) GTEST_SKIP() << "the meshes are not here";
  for (const char* name : {"suzanne.obj",
                           "teapot.obj",
                           "bunny_10k.obj",
                           "bunny_16k_hard.ply",
                           "chair_doubled.obj",
                           "soup.stl",
                           "house_no_indices.glb"}) {
    const Mesh mesh = LoadMesh(*SharedFile(std::filesystem::path("data/meshes") / name)).mesh;
    const BoundingBox box = BoundingBoxOf(mesh);
    const glm::dvec3 size(box.upper_m - box.lower_m);
    const double scale = 2.0 / std::max({size.x, size.y, size.z});
    glm::dmat4 world_from_mesh(scale);
    world_from_mesh[3] = glm::dvec4(-scale * glm::dvec3(0.5 * (box.lower_m.x + box.upper_m.x),
                                                        0.5 * (box.lower_m.y + box.upper_m.y),
                                                        box.lower_m.z),
                                    1.0);
    ExpectLikeRayCasting(
        {ground_, TransformMesh(world_from_mesh, mesh), camera_, DirectionOf(215.0, 38.0)}, name);
  }
}

// Counts of 1 to 300 on one line of sight, 128 and 256 among them.
TEST_F(ShadowMaskHardCase, ThreeHundredVolumesDeep) {
  Mesh stairs;
  for (int i = 0; i < 300; ++i) {
    const float edge = -1.5f + 0.01f * static_cast<float>(i);
    const float z = 1.0f + 0.005f * static_cast<float>(i);
    stairs = Join(
        stairs,
        MeshOf({{edge, -1, z}, {2, -1, z}, {2, 1, z}, {edge, 1, z}}, {{0, 1, 2}, {0, 2, 3}}, {}));
  }
  const Camera camera = LookAt({0.0, -6.0, 0.9}, {0.0, 0.0, 0.0}, 240, 180, 250.0);
  ExpectLikeRayCasting({ground_, stairs, camera, {0.0, 0.0, 1.0}}, "stairs", 1000);
}

TEST_F(ShadowMaskHardCase, ObjectOfAMillimetreAndOfAKilometre) {
  const glm::dvec3 to_sun = DirectionOf(215.0, 40.0);
  for (const float size : {1e-3f, 1e3f}) {
    const Mesh ground = Ground(20.0f * size);
    const Mesh sphere = Sphere({0.0f, 0.0f, 1.2f * size}, size, 20);
    const Camera camera = LookAt(glm::dvec3(4.0, -5.0, 2.5) * static_cast<double>(size),
                                 glm::dvec3(0.0, 0.0, 0.8) * static_cast<double>(size),
                                 240,
                                 180,
                                 180.0);
    ExpectLikeRayCasting({ground, sphere, camera, to_sun}, std::to_string(size));
  }
}

TEST_F(ShadowMaskHardCase, ObjectThatTouchesTheGroundOrStandsHalfInIt) {
  const glm::dvec3 to_sun = DirectionOf(215.0, 40.0);
  for (const float height : {1.0f, 0.0f, -0.5f}) {
    ExpectLikeRayCasting({ground_, Sphere({0.0f, 0.0f, height}, 1.0f, 20), camera_, to_sun},
                         std::to_string(height),
                         10);
  }
}

// Float has 1.5 cm there; what comes of it is a mesh in steps, but the same for both methods.
TEST_F(ShadowMaskHardCase, FarFromTheOrigin) {
  const glm::dvec3 there(20000.0, -60000.0, 100.0);
  const auto move = [&](const Mesh& mesh) {
    glm::dmat4 to_there(1.0);
    to_there[3] = glm::dvec4(there, 1.0);
    return TransformMesh(to_there, mesh);
  };
  const Camera camera = LookAt(
      there + glm::dvec3(4.0, -5.0, 2.5), there + glm::dvec3(0.0, 0.0, 0.8), 240, 180, 180.0);
  const MaskComparison comparison =
      Compare({move(ground_), move(Box({-1, -1, 0}, {1, 1, 2})), camera, DirectionOf(215.0, 40.0)});
  EXPECT_GT(comparison.shadowed, 20u);
  // The reference itself casts its rays in float from there: 0.4 cm, up to two pixels at its edges.
  EXPECT_LE(comparison.DifferentShare(), 1e-2);
}

TEST_F(ShadowMaskHardCase, NothingAtAllOrNothingInView) {
  const glm::dvec3 to_sun = DirectionOf(215.0, 40.0);
  for (const std::uint8_t value : ShadowMask().Draw(camera_, to_sun).pixels) {
    ASSERT_EQ(value, 0);
  }
  ExpectLikeRayCasting({ground_, Mesh{}, camera_, to_sun}, "no object", 0);
  ExpectLikeRayCasting({Mesh{}, sphere_, camera_, to_sun}, "no phantom", 0);
  ExpectLikeRayCasting(
      {ground_, Sphere({8.0f, -10.0f, 1.0f}, 1.0f, 12), camera_, to_sun}, "behind", 0);
}

TEST_F(ShadowMaskHardCase, PicturesOfEverySize) {
  const glm::dvec3 to_sun = DirectionOf(215.0, 40.0);
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(641, 479), std::pair(3, 200)}) {
    const Camera camera = LookAt({4.0, -5.0, 2.5}, {0.0, 0.0, 0.8}, width, height, 0.75 * height);
    ExpectLikeRayCasting({ground_, sphere_, camera, to_sun}, std::to_string(width), 0);
  }
}

// Each 32nd pixel of each 32nd row is held against ray casting: those that a camera of fewer pixels
// sees through the same points.
TEST_F(ShadowMaskHardCase, APictureOf4096x2160) {
  constexpr int kStep = 32;
  const glm::dvec3 to_sun = DirectionOf(215.0, 40.0);
  const Camera large = LookAt({4.0, -5.0, 2.5}, {0.0, 0.0, 0.8}, 4096, 2160, 2000.0);
  ShadowMask shadow_mask;
  shadow_mask.SetPhantom(ground_);
  shadow_mask.SetObjects({{sphere_}});
  const Gray8Image mask = shadow_mask.Draw(large, to_sun);
  ASSERT_EQ(mask.width, 4096);
  ASSERT_EQ(mask.height, 2160);
  Camera coarse = large;
  coarse.intrinsics.width_px /= kStep;
  coarse.intrinsics.height_px /= kStep;
  coarse.intrinsics.fx_px /= kStep;
  coarse.intrinsics.fy_px /= kStep;
  coarse.intrinsics.cx_px /= kStep;  // Pixel i is the large one's 32 i.
  coarse.intrinsics.cy_px /= kStep;
  const RayCaster caster(Join(ground_, sphere_));
  const Image<VisiblePoint> points = CastPicture(caster, coarse);
  const Gray8Image expected = ReferenceShadowMask(caster, points, to_sun);
  const Gray8Image at_edge = EdgeNeighbourhood(points, expected, coarse);
  int shadowed = 0;
  for (int y = 0; y < expected.height; ++y) {
    for (int x = 0; x < expected.width; ++x) {
      shadowed += expected.At(x, y) != 0 ? 1 : 0;
      if (at_edge.At(x, y) != 0) continue;
      ASSERT_EQ(mask.At(kStep * x, kStep * y), expected.At(x, y)) << x << ", " << y;
    }
  }
  EXPECT_GT(shadowed, 100);
}

TEST_F(ShadowMaskHardCase, RefusesWhatMakesNoSense) {
  Compositor compositor;
  EXPECT_THROW(ValidatedDirection({0.0, 0.0, 0.0}), std::invalid_argument);
  Camera camera = camera_;
  camera.intrinsics.width_px = 0;
  EXPECT_THROW(ValidateCamera(camera), std::invalid_argument);
  camera.intrinsics.width_px = 1000000;
  EXPECT_THROW(ShadowMask().Draw(camera, {0.0, 0.0, 1.0}), std::runtime_error);
  Mesh broken = sphere_;
  broken.triangles[0].x = 1000000;
  EXPECT_THROW(compositor.SetPhantom(broken), std::invalid_argument);
  broken = sphere_;
  broken.positions_m[3].y = std::nanf("");
  EXPECT_THROW(compositor.SetObjects({{broken}}), std::invalid_argument);
  broken = sphere_;
  broken.normals.clear();
  EXPECT_THROW(compositor.SetObjects({{broken}}), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::test::shadow_mask_hard_cases_test
