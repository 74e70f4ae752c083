// Receivers on faces, kept while the camera moves, against those at pixels.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/objects/influence_stage.h"

namespace pleinair::object_influence_on_faces_test {
namespace {

// The face that each pixel of a view shows.
Image<std::int32_t> FacesOf(const PatchScene& scene, const SurfaceView& view) {
  Image<std::int32_t> faces(view.Width(), view.Height(), PatchScene::kSky);
  const glm::vec3 eye_m(view.camera.CentreWorldM());
  for (std::size_t i = 0; i < faces.pixels.size(); ++i) {
    if (view.region.pixels[i] == SurfaceView::kNoRegion) continue;
    const glm::vec3 direction = glm::normalize(view.position_world_m.pixels[i] - eye_m);
    const auto hit = scene.caster.Intersect(eye_m, direction);
    if (hit) faces.pixels[i] = PatchScene::SideOfHit(*hit, direction);
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
RgbImage ChangeOnFaces(InfluenceStage& setting,
                       ObjectInfluence& on_faces,
                       const SurfaceView& view) {
  setting.view = view;
  on_faces.See(setting.real, view, FacesOf(setting.real, view));
  std::swap(setting.influence, on_faces);
  RgbImage change = setting.Change(OneSky({1.0, 2.0, 3.0}));
  std::swap(setting.influence, on_faces);
  return change;
}

// Against receivers at pixels, from two places of one set-up. Interpolation over a quarter of the
// distance (2 % of what is strong), and 192 rays on each side (1 % each, of all that is hidden).
TEST(ObjectInfluenceOnFaces, ReceiversDoAsThoseAtPixelsWhileTheCameraMoves) {
  Mesh object;
  AddBox(object, {-0.4f, -0.4f, 0.0f}, {0.4f, 0.4f, 1.0f});
  const Mesh ground = CutGround();
  InfluenceStage first(ground, object, LookingEast({-4.0, 0.0, 1.6}));
  ObjectInfluence on_faces(first.real, first.object);
  EXPECT_GT(on_faces.ReceiverCount(), 500u);
  EXPECT_LT(on_faces.ReceiverCount(), 10000u);
  const auto fold = [](InfluenceStage& setting, ObjectInfluence& influence) {
    const std::vector<glm::vec3> no_real = setting.RealGlow(glm::vec3(0.0f));
    const std::vector<glm::vec3> no_object = setting.ObjectGlow(glm::vec3(0.0f));
    influence.Fold(0, {nullptr, no_real, no_object}, setting.view);
    influence.Fold(1, {MakeUniformSkyShape().get(), no_real, no_object}, setting.view);
  };
  fold(first, on_faces);
  for (const double y_m : {0.0, 1.5}) {
    InfluenceStage at_pixels(ground, object, LookingEast({-4.0, y_m, 1.6}));
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
TEST(ObjectInfluenceOnFaces, WhatStandsUnderAnObjectDoesNotDarkenFacesBesideIt) {
  Mesh object;
  AddBox(object, {-1.0f, -1.0f, 0.0f}, {1.0f, 1.0f, 0.002f});
  InfluenceStage setting(CutGround(), std::move(object), LookingEast({-4.0, 0.0, 2.0}));
  ObjectInfluence on_faces(setting.real, setting.object);
  const std::vector<glm::vec3> no_real = setting.RealGlow(glm::vec3(0.0f));
  const std::vector<glm::vec3> no_object = setting.ObjectGlow(glm::vec3(0.0f));
  on_faces.Fold(0, {nullptr, no_real, no_object}, setting.view);
  on_faces.Fold(1, {MakeUniformSkyShape().get(), no_real, no_object}, setting.view);
  const RgbImage change = ChangeOnFaces(setting, on_faces, SurfaceView(setting.view));
  for (std::size_t i = 0; i < change.pixels.size(); ++i) {
    if (IsCovered(setting.object, setting.view, i)) continue;
    const glm::vec3& p = setting.view.position_world_m.pixels[i];
    // A corner of the lattice may stand on the very edge.
    if (std::max(std::abs(p.x), std::abs(p.y)) < 1.1f) continue;
    EXPECT_GT(change.pixels[i].y, -0.2f) << p.x << ", " << p.y;
  }
}

TEST(ObjectInfluenceOnFaces, RefusesWhatDoesNotFit) {
  Mesh object;
  AddBox(object, {-0.5f, -0.5f, 0.0f}, {0.5f, 0.5f, 1.5f});
  InfluenceStage setting(CutGround(), std::move(object), LookingEast({-4.0, 1.0, 1.5}));
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

}  // namespace
}  // namespace pleinair::object_influence_on_faces_test
