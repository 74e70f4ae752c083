// Penumbrae against the closed form of a disc behind a straight edge.
#include "objects/soft_sun.h"

#include <cmath>
#include <numbers>
#include <optional>

#include <tbb/global_control.h>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/objects/object_test_scenes.h"
#include "tests/objects/placement_stage.h"

namespace pleinair::soft_sun_test {
namespace {

constexpr double kRadius = 0.02;  // Wide enough for its penumbra to span many pixels.
const DirectionalLight kZenith{{0.0, 0.0, 1.0}, {}, kRadius};

// A view of the ground z = 0, with `visibility` as a function of x.
template <typename Visibility>
SurfaceView GroundView(const Camera& camera, const Visibility& visibility) {
  SurfaceView view;
  view.camera = camera;
  view.region = Image<std::int32_t>(64, 64, 0);
  view.position_world_m = RgbImage(64, 64);
  view.normal_world = RgbImage(64, 64, {0.0f, 0.0f, 1.0f});
  view.sun_visibility = GrayImage(64, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      view.position_world_m.At(x, y) = {
          (static_cast<float>(x) - 31.5f) / 32.0f, (31.5f - static_cast<float>(y)) / 32.0f, 0.0f};
      view.sun_visibility.At(x, y) = visibility(view.position_world_m.At(x, y).x);
    }
  }
  return view;
}

// Share of a disc of radius 1 on the far side of a straight edge at `u` from its centre.
double ShareBeyond(double u) {
  if (u >= 1.0) return 0.0;
  if (u <= -1.0) return 1.0;
  return (std::acos(u) - u * std::sqrt(1.0 - u * u)) / std::numbers::pi;
}

double HiddenAt(const RealSunShare& share, int x, int y) {
  return share.hidden.Contains(x - share.x_px, y - share.y_px)
             ? static_cast<double>(share.hidden.At(x - share.x_px, y - share.y_px))
             : 0.0;
}

// A plate 5 m up that ends at x = 0 hides the part of the disc on its side: from a point at x, what
// lies beyond x / (5 tan radius) disc radii. 32 points of the disc with places in the pixel's
// square, a third of the disc's radius wide: steps of 1 / 32, as much again for the square, and
// half of that for the share's curve over it.
TEST(SoftSun, AStraightEdgesPenumbraFollowsTheDisc) {
  Mesh plate;
  AddPlate({-3.0f, -3.0f}, {0.0f, 3.0f}, 5.0f, plate);
  const PatchScene objects = PatchesOf(plate);
  const RayCaster nothing{Mesh{}};
  const SurfaceView view = GroundView(FromAbove(), [](float) { return 1.0f; });
  const RealSunShare share = SoftSun(nothing, objects).OnReal(view, kZenith);
  int partial = 0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const double at_m = view.position_world_m.At(x, y).x;
      const double expected = ShareBeyond(at_m / (5.0 * std::tan(kRadius)));
      EXPECT_NEAR(HiddenAt(share, x, y), expected, 2.5 / 32.0) << "x " << at_m;
      partial += expected > 0.05 && expected < 0.95 ? 1 : 0;
    }
  }
  EXPECT_GT(partial, 64 * 3);
}

TEST(SoftSun, ManyDiscSamplesConverge) {
  Mesh plate;
  AddPlate({-3.0f, -3.0f}, {0.0f, 3.0f}, 5.0f, plate);
  const PatchScene objects = PatchesOf(plate);
  const RayCaster nothing{Mesh{}};
  const SurfaceView view = GroundView(FromAbove(), [](float) { return 1.0f; });
  const RealSunShare share =
      SoftSun(nothing, objects, {.disc_samples = 4096}).OnReal(view, kZenith);
  for (int x = 0; x < 64; ++x) {
    // The mean over a pixel against its middle: second order in a third of the disc's radius.
    const double at_m = view.position_world_m.At(x, 30).x;
    EXPECT_NEAR(HiddenAt(share, x, 30), ShareBeyond(at_m / (5.0 * std::tan(kRadius))), 0.012);
  }
}

// A real plate hides the same side of the disc: the object takes nothing of what it leaves. On the
// other side of the edge the object takes all of it. A product of shares would say half.
TEST(SoftSun, RealAndVirtualCastersHideThePartsThatTheyHideTogether) {
  const auto seen = [](float x) {
    return static_cast<float>(1.0 - ShareBeyond(x / (5.0 * std::tan(kRadius))));
  };
  const SurfaceView view = GroundView(FromAbove(), seen);
  Mesh left;
  AddPlate({-3.0f, -3.0f}, {0.0f, 3.0f}, 5.0f, left);
  Mesh right;
  AddPlate({0.0f, -3.0f}, {3.0f, 3.0f}, 5.0f, right);
  const RayCaster real(left);
  Mesh left_object;
  AddPlate({-3.0f, -3.0f}, {0.0f, 3.0f}, 5.001f, left_object);
  const PatchScene same = PatchesOf(left_object);
  const PatchScene other = PatchesOf(right);
  const RealSunShare by_same = SoftSun(real, same).OnReal(view, kZenith);
  const RealSunShare by_other = SoftSun(real, other).OnReal(view, kZenith);
  int in_penumbra = 0;
  for (int x = 0; x < 64; ++x) {
    const float share = view.sun_visibility.At(x, 20);
    if (share < 0.1f || share > 0.9f) continue;
    ++in_penumbra;
    EXPECT_NEAR(HiddenAt(by_same, x, 20), 0.0, 0.05);  // One point in 32, at a share of 0.6.
    EXPECT_NEAR(HiddenAt(by_other, x, 20), 1.0, 0.05);
  }
  EXPECT_GE(in_penumbra, 3);
}

// On an object, past a real plate: the same closed form.
TEST(SoftSun, AnObjectSeesTheDiscPastARealEdge) {
  Mesh plate;
  AddPlate({-3.0f, -3.0f}, {0.0f, 3.0f}, 5.0f, plate);
  const RayCaster real(plate);
  Mesh table;
  AddPlate({-0.9f, -0.9f}, {0.9f, 0.9f}, 0.0f, table);
  const PatchScene objects = PatchesOf(table);
  const ObjectView view = SeeObjects(objects, FromAbove());
  const ObjectSunShare share = SoftSun(real, objects).OnObjects(view, kZenith);
  ASSERT_EQ(share.seen.width, 2 * view.width_px);
  int on_table = 0;
  for (int y = 0; y < share.seen.height; ++y) {
    for (int x = 0; x < share.seen.width; ++x) {
      if (view.samples.At(x, y).triangle == ObjectView::kNothing) continue;
      ++on_table;
      const double at_m = (view.x_px + (x + 0.5) / 2.0 - 0.5 - 31.5) / 32.0;
      // A quarter of 32 points each.
      EXPECT_NEAR(
          share.seen.At(x, y), 1.0 - ShareBeyond(at_m / (5.0 * std::tan(kRadius))), 1.6 / 8.0);
    }
  }
  EXPECT_GT(on_table, 100 * 100);
}

TEST(SoftSun, AnObjectShadowsItself) {
  Mesh mesh;
  AddPlate({-0.9f, -0.9f}, {0.9f, 0.9f}, 0.0f, mesh);
  AddPlate({-0.2f, -0.2f}, {0.2f, 0.2f}, 5.0f, mesh);
  const PatchScene objects = PatchesOf(mesh);
  const RayCaster nothing{Mesh{}};
  Camera beside = FromAbove();
  beside.camera_from_world[3] = {1.0, 0.0, 10.0, 1.0};  // Sees the table beneath the lid.
  const ObjectView view = SeeObjects(objects, beside);
  const DirectionalLight sun{
      glm::normalize(glm::dvec3(0.05, 0.0, 1.0)), {}, kMeanSunAngularRadiusRad};
  const ObjectSunShare share = SoftSun(nothing, objects).OnObjects(view, sun);
  int dark = 0;
  int lit = 0;
  for (std::size_t i = 0; i < share.seen.pixels.size(); ++i) {
    if (view.samples.pixels[i].triangle == ObjectView::kNothing) continue;
    dark += share.seen.pixels[i] == 0.0f ? 1 : 0;
    lit += share.seen.pixels[i] == 1.0f ? 1 : 0;
  }
  EXPECT_GT(dark, 200);
  EXPECT_GT(lit, 5000);
}

// Of 24 sectors: a triangle's normal is up to 8 degrees, 0.13, off the sphere's, and tangent planes
// meet as far outside it. No triangle shadows another until 3 degrees from where the sphere turns
// away from the sun. A sample's part of a pixel spans up to 3.7 degrees of it, away from its rim.
TEST(SoftSun, OnASmoothObjectTheShadowsEdgeIsThatOfTheCurvedSurface) {
  const Mesh ball = placement_stage::SphereMesh(0.8f, 12, 24);
  const PatchScene objects = PatchesOf(ball);
  const RayCaster nothing{Mesh{}};
  const ObjectView view = SeeObjects(objects, FromAbove());
  const DirectionalLight sun{glm::normalize(glm::dvec3(0.7, 0.4, 0.6)), {}, 0.0};
  const ObjectSunShare share = SoftSun(nothing, objects).OnObjects(view, sun);
  int turned_away = 0;  // Triangles whose vertices' normals are not.
  for (std::size_t i = 0; i < share.seen.pixels.size(); ++i) {
    const ObjectView::Sample& sample = view.samples.pixels[i];
    if (sample.triangle == ObjectView::kNothing) continue;
    const auto [position_m, normal] = SmoothPlaceOf(sample, ball, view.eye_m);
    EXPECT_GT(glm::length(position_m), 0.7999f);
    EXPECT_LT(glm::length(position_m), 0.814f);
    if (normal.z < 0.3f) continue;
    const double cosine = glm::dot(glm::dvec3(normal), sun.direction_enu);
    if (cosine < -0.07) {
      EXPECT_EQ(share.seen.pixels[i], 0.0f) << cosine;
    } else if (cosine > 0.05) {
      EXPECT_EQ(share.seen.pixels[i], 1.0f) << cosine;
      turned_away +=
          glm::dot(glm::dvec3(TriangleNormal(ball, sample.triangle)), sun.direction_enu) <= 0.0 ? 1
                                                                                                : 0;
    }
  }
  EXPECT_GT(turned_away, 20);
}

TEST(SoftSun, DoesNotDependOnThreads) {
  Mesh plate;
  AddPlate({-0.4f, -0.3f}, {0.3f, 0.2f}, 5.0f, plate);
  AddPlate({-0.9f, -0.9f}, {0.9f, 0.9f}, 0.5f, plate);
  const PatchScene objects = PatchesOf(plate);
  const RayCaster nothing{Mesh{}};
  const SurfaceView view = GroundView(FromAbove(), [](float) { return 1.0f; });
  const SoftSun soft_sun(nothing, objects);
  const ObjectView seen = SeeObjects(objects, FromAbove());
  const RealSunShare real = soft_sun.OnReal(view, kZenith);
  const ObjectSunShare on_objects = soft_sun.OnObjects(seen, kZenith);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(soft_sun.OnReal(view, kZenith).hidden.pixels, real.hidden.pixels);
  EXPECT_EQ(soft_sun.OnObjects(seen, kZenith).seen.pixels, on_objects.seen.pixels);
}

// A point sun has edges that only the pixels' size softens.
TEST(SoftSun, ASunWithoutSizeCastsHardShadows) {
  Mesh plate;
  AddPlate({-3.0f, -3.0f}, {0.0f, 3.0f}, 5.0f, plate);
  const PatchScene objects = PatchesOf(plate);
  const RayCaster nothing{Mesh{}};
  const SurfaceView view = GroundView(FromAbove(), [](float) { return 1.0f; });
  const RealSunShare share = SoftSun(nothing, objects).OnReal(view, {{0.0, 0.0, 1.0}, {}, 0.0});
  for (int x = 0; x < 64; ++x) EXPECT_EQ(HiddenAt(share, x, 10), x < 32 ? 1.0 : 0.0);
}

// Its edge crosses samples' parts of the pixels: the share is the part that lies beyond it.
TEST(SoftSun, ASampleTakesTheShareOfItsPartOfThePixel) {
  Mesh plate;
  AddPlate({-3.0f, -3.0f}, {0.01f, 3.0f}, 5.0f, plate);  // To x = 31.82 px.
  const RayCaster real(plate);
  Mesh table;
  AddPlate({-0.9f, -0.9f}, {0.9f, 0.9f}, 0.0f, table);
  const PatchScene objects = PatchesOf(table);
  const ObjectView view = SeeObjects(objects, FromAbove());
  const ObjectSunShare share =
      SoftSun(real, objects, {.disc_samples = 1024}).OnObjects(view, {{0.0, 0.0, 1.0}, {}, 0.0});
  const int x = 2 * (32 - view.x_px);  // From 31.5 to 32 px.
  const int y = 2 * (20 - view.y_px);
  EXPECT_EQ(share.seen.At(x - 1, y), 0.0f);
  EXPECT_NEAR(share.seen.At(x, y), (32.0 - 31.82) / 0.5, 0.03);
  EXPECT_EQ(share.seen.At(x + 1, y), 1.0f);
}

TEST(SoftSunHardCases, NothingInViewGivesNothing) {
  Mesh plate;
  AddPlate({-1.0f, -1.0f}, {1.0f, 1.0f}, 20.0f, plate);  // Behind the camera.
  const PatchScene objects = PatchesOf(plate);
  const PatchScene none = PatchesOf(Mesh{});
  const RayCaster nothing{Mesh{}};
  EXPECT_TRUE(SeeObjects(objects, FromAbove()).Empty());
  EXPECT_TRUE(SeeObjects(none, FromAbove()).Empty());
  EXPECT_TRUE(SoftSun(nothing, objects).OnObjects({}, kZenith).seen.Empty());
  const SurfaceView view = GroundView(FromAbove(), [](float) { return 1.0f; });
  EXPECT_TRUE(SoftSun(nothing, none).OnReal(view, kZenith).hidden.Empty());
  // A surface that faces away from the sun has none to lose.
  EXPECT_TRUE(
      SoftSun(nothing, objects).OnReal(view, {{0.0, 0.0, -1.0}, {}, kRadius}).hidden.Empty());
}

// Around the camera: the entire picture is looked at.
TEST(SoftSunHardCases, AnObjectAroundTheCameraIsSeen) {
  Mesh floor;
  AddPlate({-50.0f, -50.0f}, {50.0f, 50.0f}, 1.0f, floor);
  AddPlate({-50.0f, -50.0f}, {50.0f, 50.0f}, 12.0f, floor);
  const PatchScene objects = PatchesOf(floor);
  const ObjectView view = SeeObjects(objects, FromAbove());
  ASSERT_EQ(view.width_px, 64);
  ASSERT_EQ(view.height_px, 64);
  const RayCaster nothing{Mesh{}};
  const ObjectSunShare share = SoftSun(nothing, objects).OnObjects(view, kZenith);
  for (const float seen : share.seen.pixels) EXPECT_EQ(seen, 0.0f);  // Under the lid.
}

TEST(SoftSunHardCases, RefusesWhatIsNoDiscAndTooFewSamples) {
  const PatchScene none = PatchesOf(Mesh{});
  const RayCaster nothing{Mesh{}};
  EXPECT_THROW(SoftSun(nothing, none, {.disc_samples = 3}), std::invalid_argument);
  const SurfaceView view = GroundView(FromAbove(), [](float) { return 1.0f; });
  const SoftSun soft_sun(nothing, none);
  EXPECT_THROW(soft_sun.OnReal(view, {glm::dvec3(0.0), {}, kRadius}), std::invalid_argument);
  EXPECT_THROW(soft_sun.OnReal(view, {{0.0, 0.0, 1.0}, {}, 2.0}), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::soft_sun_test
