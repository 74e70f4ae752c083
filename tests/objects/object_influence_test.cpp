// What objects change on real surfaces, against form factors and laws.
#include "objects/object_influence.h"

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

#include "tests/objects/influence_stage.h"

namespace pleinair::object_influence_test {
namespace {

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

// A ball of `rings` rings from pole to pole, normals outwards.
Mesh Ball(const glm::vec3& centre, float radius, int rings) {
  Mesh mesh;
  const int around = 2 * rings;
  for (int ring = 0; ring <= rings; ++ring) {
    const float polar =
        std::numbers::pi_v<float> * static_cast<float>(ring) / static_cast<float>(rings);
    for (int i = 0; i < around; ++i) {
      const float azimuth =
          2.0f * std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(around);
      mesh.normals.emplace_back(std::sin(polar) * std::cos(azimuth),
                                std::sin(polar) * std::sin(azimuth),
                                std::cos(polar));
      mesh.positions_m.push_back(centre + radius * mesh.normals.back());
    }
  }
  for (int ring = 0; ring < rings; ++ring) {
    for (int i = 0; i < around; ++i) {
      const int next = (i + 1) % around;
      const int above = ring * around;
      mesh.triangles.emplace_back(above + i, above + around + i, above + around + next);
      mesh.triangles.emplace_back(above + i, above + around + next, above + next);
    }
  }
  mesh.triangle_material.assign(mesh.triangles.size(), 0);
  mesh.triangle_group.assign(mesh.triangles.size(), 0);
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

// 192 rays of a lattice over the disc's sphere, some 2 sqrt(192) of them at the disc's rim and in
// doubt by a tenth of a ray each (1 %); blending over two fifths of the distance (2 %).
TEST(ObjectInfluence, ADiscOverAPlaneHidesItsFormFactorOfSky) {
  InfluenceStage setting(
      Ground(), Disc({0.0f, 0.0f, 1.0f}, 1.0f, 256), LookingEast({-5.0, 0.0, 0.8}));
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

// A ball stands on the plane, which its box touches all around. A polyhedron of 32 rings hides half
// a percent less; rays and blending as above.
TEST(ObjectInfluence, ABallOnAPlaneHidesItsFormFactorOfSky) {
  constexpr double kRadius = 0.5;
  const auto radius_m = static_cast<float>(kRadius);
  InfluenceStage setting(Ground(),
                         Ball({0.0f, 0.0f, radius_m}, radius_m, 32),
                         LookingEast({-4.0, 0.0, 1.2}, 320, 240));
  setting.FoldNoSun();
  setting.FoldUniformSky(glm::vec3(0.0f), glm::vec3(0.0f));
  const RgbImage change = setting.Change(OneSky(glm::dvec3(1.0)));
  int near = 0;
  for (std::size_t i = 0; i < change.pixels.size(); ++i) {
    if (setting.view.region.pixels[i] == SurfaceView::kNoRegion) continue;
    if (IsCovered(setting.object, setting.view, i)) continue;
    const glm::vec3& p = setting.view.position_world_m.pixels[i];
    const double apart = std::hypot(p.x, p.y, kRadius);
    // All of it above the plane: the sphere's solid angle times the cosine to its middle.
    const double share = kRadius * kRadius * kRadius / (apart * apart * apart);
    if (share < 2e-3) continue;
    EXPECT_NEAR(-change.pixels[i].x, share, 0.01 + 0.025 * share) << p.x << ", " << p.y;
    near += share > 0.5 ? 1 : 0;
  }
  EXPECT_GT(near, 50) << "the ground beside the ball is in view";
}

// An object as bright as what it hides cannot be seen, nor can its light.
TEST(ObjectInfluence, AWhiteObjectInAWhiteFurnaceChangesNothing) {
  Mesh real = Ground();
  AddBox(real, {3.0f, -2.0f, 0.0f}, {3.5f, 2.0f, 2.0f});
  Mesh object;
  AddBox(object, {-0.5f, -0.5f, 0.2f}, {0.5f, 0.5f, 1.2f});
  InfluenceStage setting(std::move(real), std::move(object), LookingEast({-4.0, 1.0, 1.5}));
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
  InfluenceStage setting(Ground(), std::move(object), LookingEast({-4.0, 1.0, 1.5}));
  RgbImage half_sky(16, 8, glm::vec3(1.0f, 0.5f, 2.0f));
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) half_sky.At(x, y) = glm::vec3(4.0f);
  }
  setting.influence.Fold(
      0,
      {nullptr, setting.RealGlow({0.2f, 0.1f, 0.3f}), setting.ObjectGlow({0.5f, 0.6f, 0.4f})},
      setting.view);
  setting.FoldUniformSky({0.3f, 0.3f, 0.2f}, {0.1f, 0.2f, 0.1f});
  setting.influence.Fold(2,
                         {MakeImageSkyShape("half", half_sky).get(),
                          setting.RealGlow({0.1f, 0.2f, 0.2f}),
                          setting.ObjectGlow({0.3f, 0.1f, 0.1f})},
                         setting.view);
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
  InfluenceStage setting(std::move(real), std::move(object), LookingEast({-6.0, 0.0, 1.5}));
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
  InfluenceStage setting(Ground(), std::move(object), LookingEast({-4.0, 0.0, 2.0}));
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
  InfluenceStage together(Ground(), both, camera);
  together.influence = ObjectInfluence(together.real, pair, together.view);
  InfluenceStage first(Ground(), std::move(one), camera);
  InfluenceStage second(Ground(), std::move(other), camera);
  for (InfluenceStage* setting : {&together, &first, &second}) {
    setting->FoldNoSun();
    setting->influence.Fold(1,
                            {MakeUniformSkyShape().get(),
                             setting->RealGlow(glm::vec3(0.0f)),
                             setting->ObjectGlow(glm::vec3(0.0f))},
                            setting->view);
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
    InfluenceStage setting(Ground(), object, LookingEast({-4.0, 1.0, 1.5}));
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
  InfluenceStage setting(Ground(), std::move(object), LookingEast({-4.0, 1.0, 1.5}));
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
  InfluenceStage setting(Ground(), std::move(object), LookingEast({-4.0, 1.0, 1.5}));
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
  InfluenceStage none(Ground(), {}, LookingEast({-4.0, 0.0, 1.5}));
  EXPECT_EQ(none.influence.ReceiverCount(), 0u);
  Mesh far_away;
  AddBox(far_away, {-900.0f, 0.0f, 0.0f}, {-899.0f, 1.0f, 1.0f});
  InfluenceStage behind(Ground(20.0f), std::move(far_away), LookingEast({-4.0, 0.0, 1.5}));
  EXPECT_EQ(behind.influence.ReceiverCount(), 0u);
}

// The camera inside of it: it covers every pixel.
TEST(ObjectInfluence, AnObjectAroundTheCameraChangesNothing) {
  Mesh object;
  AddBox(object, {-5.0f, -1.0f, 0.5f}, {-3.0f, 1.0f, 2.5f});
  InfluenceStage setting(Ground(), std::move(object), LookingEast({-4.0, 0.0, 1.5}));
  EXPECT_EQ(setting.influence.ReceiverCount(), 0u);
}

// In place of what rays to the sky would find.
TEST(ObjectInfluence, TakesWhatIsKnownToBeHiddenOfTheSky) {
  InfluenceStage setting(
      Ground(), Disc({0.0f, 0.0f, 1.0f}, 1.0f, 256), LookingEast({-5.0, 0.0, 0.8}));
  setting.FoldNoSun();
  const std::vector<Receiver> receivers = setting.influence.Receivers();
  ASSERT_EQ(receivers.size(), setting.influence.ReceiverCount());
  for (const Receiver& receiver : receivers) {
    EXPECT_NEAR(receiver.position_m.z, 0.0f, 1e-3f);
    EXPECT_EQ(receiver.normal, glm::vec3(0.0f, 0.0f, 1.0f));
  }
  const auto fold = [&](const std::vector<glm::vec3>& hidden_sky) {
    setting.influence.Fold(1,
                           {nullptr,
                            setting.RealGlow(glm::vec3(0.0f)),
                            setting.ObjectGlow(glm::vec3(0.0f)),
                            hidden_sky},
                           setting.view);
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

TEST(ObjectInfluence, RefusesWhatDoesNotFit) {
  Mesh object;
  AddBox(object, {-0.5f, -0.5f, 0.0f}, {0.5f, 0.5f, 1.5f});
  InfluenceStage setting(Ground(), std::move(object), LookingEast({-4.0, 1.0, 1.5}));
  const std::vector<glm::vec3> real = setting.RealGlow(glm::vec3(0.0f));
  const std::vector<glm::vec3> glow = setting.ObjectGlow(glm::vec3(0.0f));
  EXPECT_THROW(setting.influence.Fold(0, {nullptr, glow, glow}, setting.view),
               std::invalid_argument);
  EXPECT_THROW(setting.influence.Fold(0, {nullptr, real, real}, setting.view),
               std::invalid_argument);
  EXPECT_THROW(setting.influence.Fold(3, {MakeUniformSkyShape().get(), real, glow}, setting.view),
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
