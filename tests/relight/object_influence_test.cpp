// What objects change on real surfaces, against form factors and laws.
#include "relight/object_influence.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/lens.h"
#include "tests/relight/probe_test_scenes.h"

namespace pleinair::object_influence_test {
namespace {

// From `eye_m` to the horizon in the direction of x, a little down.
Camera LookingEast(const glm::dvec3& eye_m, int width_px = 160, int height_px = 120) {
  Camera camera;
  camera.intrinsics = {.width_px = width_px,
                       .height_px = height_px,
                       .fx_px = 0.8 * width_px,
                       .fy_px = 0.8 * width_px,
                       .cx_px = 0.5 * (width_px - 1),
                       .cy_px = 0.5 * (height_px - 1)};
  const glm::dvec3 forward = glm::normalize(glm::dvec3(1.0, 0.0, -0.25));
  const glm::dvec3 right(0.0, -1.0, 0.0);
  const glm::dmat3 camera_from_world =
      glm::transpose(glm::dmat3(right, glm::cross(forward, right), forward));
  camera.camera_from_world = glm::dmat4(camera_from_world);
  camera.camera_from_world[3] = glm::dvec4(-(camera_from_world * eye_m), 1.0);
  return camera;
}

// What the camera sees of `scene`; the surfaces get no light, so that no change is too small.
SurfaceView ViewOf(const PatchScene& scene, const Camera& camera) {
  const int width = camera.intrinsics.width_px;
  const int height = camera.intrinsics.height_px;
  SurfaceView view;
  view.camera = camera;
  view.region_names = {"scene"};
  view.region = Image<std::int32_t>(width, height, SurfaceView::kNoRegion);
  view.position_world_m = RgbImage(width, height);
  view.normal_world = RgbImage(width, height);
  view.sky_response = {RgbImage(width, height), RgbImage(width, height)};
  view.sun_bounce = RgbImage(width, height);
  view.sun_visibility = GrayImage(width, height);
  const glm::vec3 eye_m(camera.CentreWorldM());
  const glm::dmat3 world_from_camera = glm::transpose(glm::dmat3(camera.camera_from_world));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const glm::vec3 direction(
          glm::normalize(world_from_camera * *DirectionFromPixel(camera.intrinsics, {x, y})));
      const auto hit = scene.caster.Intersect(eye_m, direction);
      if (!hit) continue;
      view.region.At(x, y) = 0;
      view.position_world_m.At(x, y) = hit->position_m;
      const bool is_front = PatchScene::FaceOfHit(*hit, direction) % 2 == 0;
      view.normal_world.At(x, y) = is_front ? hit->geometric_normal : -hit->geometric_normal;
    }
  }
  return view;
}

// Whether the object hides a pixel's surface from the camera.
bool IsCovered(const PatchScene& object, const SurfaceView& view, std::size_t pixel) {
  const glm::vec3 eye_m(view.camera.CentreWorldM());
  const glm::vec3 apart = view.position_world_m.pixels[pixel] - eye_m;
  return object.caster.Occluded(eye_m, glm::normalize(apart), 0.999f * glm::length(apart));
}

// Polygon with `corners` corners, normal down.
Mesh Disc(const glm::vec3& centre, float radius, int corners) {
  Mesh mesh;
  mesh.positions_m.push_back(centre);
  for (int i = 0; i < corners; ++i) {
    const float angle =
        2.0f * std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(corners);
    mesh.positions_m.push_back(centre + radius * glm::vec3(std::cos(angle), std::sin(angle), 0.0f));
    mesh.triangles.emplace_back(0, 1 + (i + 1) % corners, 1 + i);
    mesh.triangle_material.push_back(0);
    mesh.triangle_group.push_back(0);
  }
  mesh.normals.assign(mesh.positions_m.size(), glm::vec3(0.0f, 0.0f, -1.0f));
  return mesh;
}

// Form factor of a disc for a point on a parallel plane `height` below and `offset` from its axis
// (Howell, catalog of radiation configuration factors, B-13).
double DiscShare(double radius, double height, double offset) {
  const double h = height / offset;
  const double r = radius / offset;
  const double z = 1.0 + h * h + r * r;
  return 0.5 * (1.0 - (z - 2.0 * r * r) / std::sqrt(z * z - 4.0 * r * r));
}

struct Setting {
  PatchScene real;
  PatchScene object;
  SurfaceView view;
  ObjectInfluence influence;

  Setting(Mesh real_mesh, Mesh object_mesh, const Camera& camera)
      : real(SceneOf(std::move(real_mesh))),
        object(SceneOf(std::move(object_mesh))),
        view(ViewOf(real, camera)),
        influence(real, object, view) {}

  std::vector<glm::vec3> RealGlow(const glm::vec3& radiosity) const {
    return std::vector<glm::vec3>(real.FaceCount(), radiosity);
  }
  std::vector<glm::vec3> ObjectGlow(const glm::vec3& radiosity) const {
    return std::vector<glm::vec3>(object.FaceCount(), radiosity);
  }
  // Light 0 is the sun, which nothing reflects.
  void FoldNoSun() {
    influence.Fold(0, nullptr, view, RealGlow(glm::vec3(0.0f)), ObjectGlow(glm::vec3(0.0f)));
  }
  // Light 1 is a uniform sky, whose light real and virtual faces have the given radiosity of.
  void FoldUniformSky(const glm::vec3& real_glow, const glm::vec3& object_glow) {
    influence.Fold(
        1, MakeUniformSkyShape().get(), view, RealGlow(real_glow), ObjectGlow(object_glow));
  }
  // In picture size.
  RgbImage Change(const Lighting& lighting, const InfluenceParts& parts = {}) const {
    IrradianceChange change;
    influence.Evaluate(lighting, parts, change);
    RgbImage whole(view.Width(), view.Height(), glm::vec3(0.0f));
    for (int y = 0; y < change.irradiance_rgb.height; ++y) {
      for (int x = 0; x < change.irradiance_rgb.width; ++x) {
        whole.At(change.x_px + x, change.y_px + y) = change.irradiance_rgb.At(x, y);
      }
    }
    return whole;
  }
};

// So wide that no ray below the horizon passes its end, but for the last of float's steps.
Mesh Ground(float half_side_m = 1e4f) {
  Mesh mesh;
  AddGround(mesh, half_side_m);
  return mesh;
}

Lighting OneSky(const glm::dvec3& irradiance_rgb) {
  Lighting lighting;
  lighting.sky = {{"uniform", irradiance_rgb}};
  return lighting;
}

// 192 rays of a lattice over the disc's sphere, some 2 sqrt(192) of them at the disc's rim and in
// doubt by a tenth of a ray each (1 %); blending over two fifths of the distance (2 %).
TEST(ObjectInfluence, ADiscOverAPlaneHidesItsFormFactorOfSky) {
  Setting setting(Ground(), Disc({0.0f, 0.0f, 1.0f}, 1.0f, 256), LookingEast({-5.0, 0.0, 0.8}));
  setting.FoldNoSun();
  setting.FoldUniformSky(glm::vec3(0.0f), glm::vec3(0.0f));
  const RgbImage change = setting.Change(OneSky({1.0, 2.0, 3.0}));
  int strong = 0;
  double sum = 0.0;
  double true_sum = 0.0;
  for (std::size_t i = 0; i < change.pixels.size(); ++i) {
    if (setting.view.region.pixels[i] == SurfaceView::kNoRegion) continue;
    if (IsCovered(setting.object, setting.view, i)) continue;
    const glm::vec3& p = setting.view.position_world_m.pixels[i];
    const double share = DiscShare(1.0, 1.0, std::max(std::hypot(p.x, p.y), 1e-4f));
    if (share < 1e-3) continue;
    EXPECT_NEAR(-change.pixels[i].x, share, 0.01 + 0.02 * share) << p.x << ", " << p.y;
    EXPECT_NEAR(change.pixels[i].y, 2.0f * change.pixels[i].x, 1e-5);
    strong += share > 0.3 ? 1 : 0;
    sum -= change.pixels[i].x;
    true_sum += share;
  }
  EXPECT_GT(strong, 100) << "the ground below the disc is in view";
  EXPECT_NEAR(sum / true_sum, 1.0, 0.02);
}

// An object as bright as what it hides cannot be seen, nor can its light.
TEST(ObjectInfluence, AWhiteObjectInAWhiteFurnaceChangesNothing) {
  Mesh real = Ground();
  AddBox(real, {3.0f, -2.0f, 0.0f}, {3.5f, 2.0f, 2.0f});
  Mesh object;
  AddBox(object, {-0.5f, -0.5f, 0.2f}, {0.5f, 0.5f, 1.2f});
  Setting setting(std::move(real), std::move(object), LookingEast({-4.0, 1.0, 1.5}));
  setting.FoldNoSun();
  // A uniform sky's radiance is 1 / pi of its irradiance, as that of a face of radiosity 1.
  setting.FoldUniformSky(glm::vec3(1.0f), glm::vec3(1.0f));
  EXPECT_GT(setting.influence.ReceiverCount(), 100u);
  for (const glm::vec3& change : setting.Change(OneSky(glm::dvec3(1.0))).pixels) {
    // A ray 4e-5 below the horizon passes the ground's end and meets nothing; its share is 2e-4.
    EXPECT_NEAR(change.x, 0.0f, 3e-4f);
  }
}

TEST(ObjectInfluence, IsLinearInTheLight) {
  Mesh object;
  AddBox(object, {-0.5f, -0.5f, 0.0f}, {0.5f, 0.5f, 1.5f});
  Setting setting(Ground(), std::move(object), LookingEast({-4.0, 1.0, 1.5}));
  RgbImage half_sky(16, 8, glm::vec3(1.0f, 0.5f, 2.0f));
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) half_sky.At(x, y) = glm::vec3(4.0f);
  }
  setting.influence.Fold(0,
                         nullptr,
                         setting.view,
                         setting.RealGlow({0.2f, 0.1f, 0.3f}),
                         setting.ObjectGlow({0.5f, 0.6f, 0.4f}));
  setting.FoldUniformSky({0.3f, 0.3f, 0.2f}, {0.1f, 0.2f, 0.1f});
  setting.influence.Fold(2,
                         MakeImageSkyShape("half", half_sky).get(),
                         setting.view,
                         setting.RealGlow({0.1f, 0.2f, 0.2f}),
                         setting.ObjectGlow({0.3f, 0.1f, 0.1f}));
  Lighting first;
  first.sun.irradiance_rgb = {3.0, 0.0, 1.0};
  first.sky = {{"uniform", {1.0, 2.0, 0.0}}, {"half", {0.0, 1.0, 4.0}}};
  Lighting second;
  second.sun.irradiance_rgb = {0.0, 2.0, 5.0};
  second.sky = {{"uniform", {0.5, 0.0, 3.0}}, {"half", {2.0, 0.0, 1.0}}};
  Lighting both = first;
  both.sun.irradiance_rgb = 0.25 * first.sun.irradiance_rgb + 3.0 * second.sun.irradiance_rgb;
  for (std::size_t k = 0; k < 2; ++k) {
    both.sky[k].irradiance_rgb =
        0.25 * first.sky[k].irradiance_rgb + 3.0 * second.sky[k].irradiance_rgb;
  }
  const RgbImage a = setting.Change(first);
  const RgbImage b = setting.Change(second);
  const RgbImage sum = setting.Change(both);
  const RgbImage hidden = setting.Change(both, {.object_light = false});
  const RgbImage gained = setting.Change(both, {.hidden_light = false});
  float darkest = 0.0f;
  float brightest = 0.0f;
  for (std::size_t i = 0; i < sum.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      // Ten units of light, in float.
      EXPECT_NEAR(sum.pixels[i][c], 0.25f * a.pixels[i][c] + 3.0f * b.pixels[i][c], 2e-5f);
      EXPECT_NEAR(sum.pixels[i][c], hidden.pixels[i][c] + gained.pixels[i][c], 2e-5f);
      darkest = std::min(darkest, hidden.pixels[i][c]);
      brightest = std::max(brightest, gained.pixels[i][c]);
    }
  }
  EXPECT_LT(darkest, -1.0f);
  EXPECT_GT(brightest, 1.0f);
}

// The object stands behind a wall: before it the light is as it was.
TEST(ObjectInfluence, WhatARealSurfaceHidesChangesNothing) {
  Mesh real = Ground();
  AddBox(real, {0.0f, -3.0f, 0.0f}, {0.2f, 3.0f, 3.0f});
  Mesh object;
  AddBox(object, {0.5f, -0.5f, 0.0f}, {1.5f, 0.5f, 1.0f});
  Setting setting(std::move(real), std::move(object), LookingEast({-6.0, 0.0, 1.5}));
  setting.FoldNoSun();
  setting.FoldUniformSky(glm::vec3(0.0f), glm::vec3(0.0f));
  const RgbImage change = setting.Change(OneSky(glm::dvec3(1.0)));
  for (std::size_t i = 0; i < change.pixels.size(); ++i) {
    if (setting.view.position_world_m.pixels[i].x < 0.01f &&
        std::abs(setting.view.position_world_m.pixels[i].y) < 1.0f) {
      EXPECT_EQ(change.pixels[i], glm::vec3(0.0f));
    }
  }
}

// A thin tile lies on the ground. Under it all is dark, but there nobody looks; beside it nothing
// of the sky is hidden but what 2 mm of its edge hide.
TEST(ObjectInfluence, TheGroundUnderAnObjectDoesNotDarkenTheGroundBesideIt) {
  Mesh object;
  AddBox(object, {-1.0f, -1.0f, 0.0f}, {1.0f, 1.0f, 0.002f});
  Setting setting(Ground(), std::move(object), LookingEast({-4.0, 0.0, 2.0}));
  setting.FoldNoSun();
  setting.FoldUniformSky(glm::vec3(0.0f), glm::vec3(0.0f));
  const RgbImage change = setting.Change(OneSky(glm::dvec3(1.0)));
  int beside = 0;
  for (std::size_t i = 0; i < change.pixels.size(); ++i) {
    if (IsCovered(setting.object, setting.view, i)) continue;
    const glm::vec3& p = setting.view.position_world_m.pixels[i];
    const double distance = std::max(std::abs(p.x), std::abs(p.y)) - 1.0;
    // Half a pixel's distance, 1 cm, puts the edge's share at 2 mm / (2 * 1 cm) of a quarter.
    if (distance > 0.01 && distance < 0.2) {
      EXPECT_GT(change.pixels[i].x, -0.1f) << p.x << ", " << p.y;
      ++beside;
    }
  }
  EXPECT_GT(beside, 50);
}

// Two boxes: each alone, and both, where neither stands before the other.
TEST(ObjectInfluence, ObjectsApartAddUp) {
  Mesh one;
  AddBox(one, {-0.5f, -1.5f, 0.0f}, {0.0f, -1.0f, 1.0f});
  Mesh other;
  AddBox(other, {-0.5f, 1.0f, 0.0f}, {0.0f, 1.5f, 1.0f});
  Mesh both;
  AddBox(both, {-0.5f, -1.5f, 0.0f}, {0.0f, -1.0f, 1.0f});
  AddBox(both, {-0.5f, 1.0f, 0.0f}, {0.0f, 1.5f, 1.0f});
  PatchScene pair = SceneOf(both);
  pair.mesh.group_names = {"one", "other"};
  for (std::size_t t = pair.mesh.triangles.size() / 2; t < pair.mesh.triangles.size(); ++t) {
    pair.mesh.triangle_group[t] = 1;
  }
  const Camera camera = LookingEast({-4.0, 0.0, 1.5});
  Setting together(Ground(), both, camera);
  together.influence = ObjectInfluence(together.real, pair, together.view);
  Setting first(Ground(), std::move(one), camera);
  Setting second(Ground(), std::move(other), camera);
  for (Setting* setting : {&together, &first, &second}) {
    setting->FoldNoSun();
    setting->influence.Fold(1,
                            MakeUniformSkyShape().get(),
                            setting->view,
                            setting->RealGlow(glm::vec3(0.0f)),
                            setting->ObjectGlow(glm::vec3(0.0f)));
  }
  const Lighting sky = OneSky(glm::dvec3(1.0));
  const RgbImage sum = together.Change(sky);
  const RgbImage a = first.Change(sky);
  const RgbImage b = second.Change(sky);
  double difference = 0.0;
  double size = 0.0;
  for (std::size_t i = 0; i < sum.pixels.size(); ++i) {
    if (IsCovered(together.object, together.view, i)) continue;
    difference += std::abs(sum.pixels[i].x - a.pixels[i].x - b.pixels[i].x);
    size += std::abs(sum.pixels[i].x);
  }
  EXPECT_GT(size, 10.0);
  // Blocks of other sizes, where the nearer of two objects decides.
  EXPECT_LT(difference, 0.05 * size);
}

TEST(ObjectInfluence, DoesNotDependOnTheNumberOfThreads) {
  Mesh object;
  AddBox(object, {-0.5f, -0.5f, 0.0f}, {0.5f, 0.5f, 1.5f});
  std::optional<RgbImage> expected;
  for (const std::size_t threads : {std::size_t{1}, std::size_t{2}, std::size_t{8}}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Setting setting(Ground(), object, LookingEast({-4.0, 1.0, 1.5}));
    setting.FoldNoSun();
    setting.FoldUniformSky(glm::vec3(0.2f), glm::vec3(0.4f));
    const RgbImage change = setting.Change(OneSky({1.0, 2.0, 3.0}));
    if (!expected) expected = change;
    EXPECT_EQ(expected->pixels, change.pixels) << threads << " threads";
  }
}

TEST(ObjectInfluence, LeavesOutWhatNoOneCouldSee) {
  Mesh object;
  AddBox(object, {-0.5f, -0.5f, 0.0f}, {0.5f, 0.5f, 1.5f});
  Setting setting(Ground(), std::move(object), LookingEast({-4.0, 1.0, 1.5}));
  for (RgbImage& response : setting.view.sky_response) {
    response.pixels.assign(response.pixels.size(), glm::vec3(1.0f));
  }
  setting.FoldNoSun();
  setting.FoldUniformSky(glm::vec3(0.0f), glm::vec3(0.0f));
  const RgbImage dim = setting.Change(OneSky(glm::dvec3(1.0)));
  int changed = 0;
  int untouched = 0;
  for (const glm::vec3& change : dim.pixels) {
    // A receiver's own change is 0 or above the bound; blending makes it less.
    (change == glm::vec3(0.0f) ? untouched : changed) += 1;
  }
  EXPECT_GT(changed, 1000);
  EXPECT_GT(untouched, 1000);
}

// The memory of a frame with more light shows in none after it, and the image ends where changes
// do.
TEST(ObjectInfluence, AChangeThatIsUsedAgainIsAsNew) {
  Mesh object;
  AddBox(object, {-0.5f, -0.5f, 0.0f}, {0.5f, 0.5f, 1.5f});
  Setting setting(Ground(), std::move(object), LookingEast({-4.0, 1.0, 1.5}));
  setting.view.sky_response.assign(
      1, RgbImage(setting.view.Width(), setting.view.Height(), glm::vec3(1.0f)));
  setting.FoldNoSun();
  setting.FoldUniformSky(glm::vec3(0.0f), glm::vec3(0.05f));
  IrradianceChange used;
  std::size_t largest = 0;
  for (const InfluenceParts& parts :
       {InfluenceParts{.hidden_light = true, .object_light = true},
        InfluenceParts{.hidden_light = false, .object_light = true},
        InfluenceParts{.hidden_light = false, .object_light = false},
        InfluenceParts{.hidden_light = true, .object_light = false}}) {
    IrradianceChange fresh;
    setting.influence.Evaluate(OneSky(glm::dvec3(1.0)), parts, fresh);
    setting.influence.Evaluate(OneSky(glm::dvec3(1.0)), parts, used);
    EXPECT_EQ(used.irradiance_rgb.pixels, fresh.irradiance_rgb.pixels);
    EXPECT_EQ(used.irradiance_rgb.width, fresh.irradiance_rgb.width);
    largest = std::max(largest, fresh.irradiance_rgb.pixels.size());
    const RgbImage& image = fresh.irradiance_rgb;
    for (const int x : {0, image.width - 1}) {
      bool changes = image.Empty();
      for (int y = 0; y < image.height; ++y) changes |= image.At(x, y) != glm::vec3(0.0f);
      EXPECT_TRUE(changes) << "column " << x;
    }
  }
  EXPECT_GT(largest, 1000u);
}

TEST(ObjectInfluence, NoObjectsOrNoneNearChangeNothing) {
  IrradianceChange change;
  ObjectInfluence().Evaluate(OneSky(glm::dvec3(1.0)), {}, change);
  EXPECT_TRUE(change.irradiance_rgb.Empty());
  Setting none(Ground(), {}, LookingEast({-4.0, 0.0, 1.5}));
  EXPECT_EQ(none.influence.ReceiverCount(), 0u);
  Mesh far_away;
  AddBox(far_away, {-900.0f, 0.0f, 0.0f}, {-899.0f, 1.0f, 1.0f});
  Setting behind(Ground(20.0f), std::move(far_away), LookingEast({-4.0, 0.0, 1.5}));
  EXPECT_EQ(behind.influence.ReceiverCount(), 0u);
}

// The camera inside of it: it covers every pixel.
TEST(ObjectInfluence, AnObjectAroundTheCameraChangesNothing) {
  Mesh object;
  AddBox(object, {-5.0f, -1.0f, 0.5f}, {-3.0f, 1.0f, 2.5f});
  Setting setting(Ground(), std::move(object), LookingEast({-4.0, 0.0, 1.5}));
  EXPECT_EQ(setting.influence.ReceiverCount(), 0u);
}

// In place of what rays to the sky would find.
TEST(ObjectInfluence, TakesWhatIsKnownToBeHiddenOfTheSky) {
  Setting setting(Ground(), Disc({0.0f, 0.0f, 1.0f}, 1.0f, 256), LookingEast({-5.0, 0.0, 0.8}));
  setting.FoldNoSun();
  const std::vector<Receiver> receivers = setting.influence.Receivers();
  ASSERT_EQ(receivers.size(), setting.influence.ReceiverCount());
  for (const Receiver& receiver : receivers) {
    EXPECT_NEAR(receiver.position_m.z, 0.0f, 1e-3f);
    EXPECT_EQ(receiver.normal, glm::vec3(0.0f, 0.0f, 1.0f));
  }
  const auto fold = [&](const std::vector<glm::vec3>& hidden_sky) {
    setting.influence.Fold(1,
                           nullptr,
                           setting.view,
                           setting.RealGlow(glm::vec3(0.0f)),
                           setting.ObjectGlow(glm::vec3(0.0f)),
                           hidden_sky);
  };
  fold(std::vector<glm::vec3>(receivers.size(), glm::vec3(0.25f)));
  int changed = 0;
  for (const glm::vec3& pixel : setting.Change(OneSky(glm::dvec3(2.0))).pixels) {
    // Bilinear weights add up to 1.
    if (pixel.x == 0.0f) continue;
    EXPECT_NEAR(pixel.x, -0.5f, 1e-5f);
    ++changed;
  }
  EXPECT_GT(changed, 1000);
  EXPECT_THROW(fold(std::vector<glm::vec3>(receivers.size() + 1)), std::invalid_argument);
}

// The face that each pixel of a view shows.
Image<std::int32_t> FacesOf(const PatchScene& scene, const SurfaceView& view) {
  Image<std::int32_t> faces(view.Width(), view.Height(), PatchScene::kSky);
  const glm::vec3 eye_m(view.camera.CentreWorldM());
  for (std::size_t i = 0; i < faces.pixels.size(); ++i) {
    if (view.region.pixels[i] == SurfaceView::kNoRegion) continue;
    const glm::vec3 direction = glm::normalize(view.position_world_m.pixels[i] - eye_m);
    const auto hit = scene.caster.Intersect(eye_m, direction);
    if (hit) faces.pixels[i] = PatchScene::FaceOfHit(*hit, direction);
  }
  return faces;
}

// Patches of ground of up to half a metre.
Mesh CutGround() {
  Mesh ground;
  AddGround(ground, 12.0f);
  PatchOptions options;
  options.patch_size_m = 0.5;
  options.extend_ground = false;
  return BuildPatchScene(SceneOf(std::move(ground)).mesh, options).mesh;
}

// The change that receivers on faces give, in picture size.
RgbImage ChangeOnFaces(Setting& setting, ObjectInfluence& on_faces, const SurfaceView& view) {
  setting.view = view;
  on_faces.See(setting.real, view, FacesOf(setting.real, view));
  std::swap(setting.influence, on_faces);
  RgbImage change = setting.Change(OneSky({1.0, 2.0, 3.0}));
  std::swap(setting.influence, on_faces);
  return change;
}

// Against receivers at pixels, from two places of one set-up. Interpolation over a quarter of the
// distance (2 % of what is strong), and 192 rays on each side (1 % each, of all that is hidden).
TEST(ObjectInfluence, ReceiversOnFacesDoAsThoseAtPixelsWhileTheCameraMoves) {
  Mesh object;
  AddBox(object, {-0.4f, -0.4f, 0.0f}, {0.4f, 0.4f, 1.0f});
  const Mesh ground = CutGround();
  Setting first(ground, object, LookingEast({-4.0, 0.0, 1.6}));
  ObjectInfluence on_faces(first.real, first.object);
  EXPECT_GT(on_faces.ReceiverCount(), 500u);
  EXPECT_LT(on_faces.ReceiverCount(), 10000u);
  const auto fold = [](Setting& setting, ObjectInfluence& influence) {
    const std::vector<glm::vec3> no_real = setting.RealGlow(glm::vec3(0.0f));
    const std::vector<glm::vec3> no_object = setting.ObjectGlow(glm::vec3(0.0f));
    influence.Fold(0, nullptr, setting.view, no_real, no_object);
    influence.Fold(1, MakeUniformSkyShape().get(), setting.view, no_real, no_object);
  };
  fold(first, on_faces);
  for (const double y_m : {0.0, 1.5}) {
    Setting at_pixels(ground, object, LookingEast({-4.0, y_m, 1.6}));
    fold(at_pixels, at_pixels.influence);
    const RgbImage expected = at_pixels.Change(OneSky({1.0, 2.0, 3.0}));
    const RgbImage change = ChangeOnFaces(first, on_faces, at_pixels.view);
    double squares = 0.0;
    double size = 0.0;
    for (std::size_t i = 0; i < change.pixels.size(); ++i) {
      if (IsCovered(first.object, at_pixels.view, i)) continue;
      const double difference = double{change.pixels[i].y} - double{expected.pixels[i].y};
      squares += difference * difference;
      size += double{expected.pixels[i].y} * double{expected.pixels[i].y};
      EXPECT_NEAR(change.pixels[i].y, expected.pixels[i].y, 0.1) << i;
    }
    EXPECT_GT(size, 10.0);
    EXPECT_LT(std::sqrt(squares / size), 0.05) << y_m;
  }
}

// Thinner than anything stands apart: under it all is dark, beside it nothing.
TEST(ObjectInfluence, WhatStandsUnderAnObjectDoesNotDarkenFacesBesideIt) {
  Mesh object;
  AddBox(object, {-1.0f, -1.0f, 0.0f}, {1.0f, 1.0f, 0.002f});
  Setting setting(CutGround(), std::move(object), LookingEast({-4.0, 0.0, 2.0}));
  ObjectInfluence on_faces(setting.real, setting.object);
  const std::vector<glm::vec3> no_real = setting.RealGlow(glm::vec3(0.0f));
  const std::vector<glm::vec3> no_object = setting.ObjectGlow(glm::vec3(0.0f));
  on_faces.Fold(0, nullptr, setting.view, no_real, no_object);
  on_faces.Fold(1, MakeUniformSkyShape().get(), setting.view, no_real, no_object);
  const RgbImage change = ChangeOnFaces(setting, on_faces, SurfaceView(setting.view));
  for (std::size_t i = 0; i < change.pixels.size(); ++i) {
    if (IsCovered(setting.object, setting.view, i)) continue;
    const glm::vec3& p = setting.view.position_world_m.pixels[i];
    // A corner of the lattice may stand on the very edge.
    if (std::max(std::abs(p.x), std::abs(p.y)) < 1.1f) continue;
    EXPECT_GT(change.pixels[i].y, -0.2f) << p.x << ", " << p.y;
  }
}

TEST(ObjectInfluence, OnFacesRefusesWhatDoesNotFit) {
  Mesh object;
  AddBox(object, {-0.5f, -0.5f, 0.0f}, {0.5f, 0.5f, 1.5f});
  Setting setting(CutGround(), std::move(object), LookingEast({-4.0, 1.0, 1.5}));
  const Image<std::int32_t> faces = FacesOf(setting.real, setting.view);
  EXPECT_THROW(setting.influence.See(setting.real, setting.view, faces), std::logic_error);
  ObjectInfluence on_faces(setting.real, setting.object);
  EXPECT_THROW(on_faces.See(setting.object, setting.view, faces), std::invalid_argument);
  EXPECT_THROW(on_faces.See(setting.real, setting.view, Image<std::int32_t>(3, 3, 0)),
               std::invalid_argument);
  ObjectInfluenceOptions options;
  options.least_spacing = 0.0;
  EXPECT_THROW(ObjectInfluence(setting.real, setting.object, options), std::invalid_argument);
}

TEST(ObjectInfluence, RefusesWhatDoesNotFit) {
  Mesh object;
  AddBox(object, {-0.5f, -0.5f, 0.0f}, {0.5f, 0.5f, 1.5f});
  Setting setting(Ground(), std::move(object), LookingEast({-4.0, 1.0, 1.5}));
  const std::vector<glm::vec3> real = setting.RealGlow(glm::vec3(0.0f));
  const std::vector<glm::vec3> glow = setting.ObjectGlow(glm::vec3(0.0f));
  EXPECT_THROW(setting.influence.Fold(0, nullptr, setting.view, glow, glow), std::invalid_argument);
  EXPECT_THROW(setting.influence.Fold(0, nullptr, setting.view, real, real), std::invalid_argument);
  EXPECT_THROW(setting.influence.Fold(3, MakeUniformSkyShape().get(), setting.view, real, glow),
               std::invalid_argument)
      << "the view has two shapes";
  setting.FoldNoSun();
  IrradianceChange change;
  EXPECT_THROW(setting.influence.Evaluate(OneSky(glm::dvec3(1.0)), {}, change),
               std::invalid_argument)
      << "the sky was not folded";
  EXPECT_THROW(
      ObjectInfluence(setting.real, setting.object, setting.view, {.rays_per_receiver = 0}),
      std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::object_influence_test
