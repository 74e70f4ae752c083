#include "relight/survey/survey_look_up.h"

#include <cmath>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "scene/lat_long.h"

namespace pleinair {
namespace {

constexpr LatLongSize kSize{256, 128};
constexpr float kFloorM = -1.5f;

// From 1.5 m over a wide floor whose albedo is a board of one map pixel a field, and nothing else.
Survey OverAFloor() {
  Survey survey;
  SurfaceView& view = survey.view;
  view.region = Image<std::int32_t>(kSize.width, kSize.height, SurfaceView::kNoRegion);
  view.position_world_m = RgbImage(kSize.width, kSize.height, glm::vec3(0.0f));
  view.normal_world = view.albedo_rgb = view.position_world_m;
  view.albedo_measured = view.may_be_sampled = Gray8Image(kSize.width, kSize.height, 0);
  view.edge_distance_px = GrayImage(kSize.width, kSize.height, 5.0f);
  for (int y = 0; y < kSize.height; ++y) {
    for (int x = 0; x < kSize.width; ++x) {
      const glm::vec3 direction(DirectionFromLatLong({x + 0.5, y + 0.5}, kSize));
      if (!(direction.z < -0.1f)) continue;
      const std::size_t i = view.region.Index(x, y);
      view.region.pixels[i] = 0;
      view.position_world_m.pixels[i] = direction * (kFloorM / direction.z);
      view.normal_world.pixels[i] = {0.0f, 0.0f, 1.0f};
      view.albedo_rgb.pixels[i] = glm::vec3((x + y) % 2 == 0 ? 0.2f : 0.6f);
      view.albedo_measured.pixels[i] = view.may_be_sampled.pixels[i] = 1;
    }
  }
  return survey;
}

constexpr glm::vec3 kUp{0.0f, 0.0f, 1.0f};

TEST(SurveyLookUp, PlacesAreThoseOfTheMap) {
  const SurveyLookUp look_up(OverAFloor());
  for (int y = 1; y < kSize.height; y += 9) {
    for (int x = 0; x < kSize.width; x += 7) {
      const glm::vec3 direction(DirectionFromLatLong({x + 0.5, y + 0.5}, kSize));
      const glm::vec2 place = look_up.PlaceOf(3.0f * direction);
      EXPECT_NEAR(place.x, x, 1e-4f) << x << ", " << y;
      EXPECT_NEAR(place.y, y, 1e-4f) << x << ", " << y;
    }
  }
}

TEST(SurveyLookUp, AMeanOverManyTexelsIsTheMean) {
  const SurveyLookUp look_up(OverAFloor());
  const glm::vec3 point_m(1.3f, 0.9f, kFloorM);
  for (const float side_px : {4.0f, 8.0f, 16.0f}) {
    const auto mean = look_up.MeanAlbedo(look_up.PlaceOf(point_m), side_px, point_m, kUp, 0);
    ASSERT_TRUE(mean) << side_px;
    EXPECT_NEAR(mean->y, 0.4f, 1e-4f) << side_px;
  }
  // Of one texel it is that texel's.
  const Survey survey = OverAFloor();
  const std::size_t texel = survey.view.region.Index(40, 100);
  const glm::vec3& there_m = survey.view.position_world_m.pixels[texel];
  const auto one = look_up.MeanAlbedo(look_up.PlaceOf(there_m), 1.0f, there_m, kUp, 0);
  ASSERT_TRUE(one);
  EXPECT_NEAR(one->y, survey.view.albedo_rgb.pixels[texel].y, 1e-3f);
}

TEST(SurveyLookUp, AMeanAcrossAnEdgeIsNotGiven) {
  const SurveyLookUp look_up(OverAFloor());
  const glm::vec3 point_m(1.3f, 0.9f, kFloorM);
  EXPECT_FALSE(look_up.MeanAlbedo(look_up.PlaceOf(point_m), 8.0f, point_m, kUp, 1));
  const glm::vec3 wall{1.0f, 0.0f, 0.0f};
  EXPECT_FALSE(look_up.MeanAlbedo(look_up.PlaceOf(point_m), 8.0f, point_m, wall, 0));
  // Where the floor ends in the map.
  const glm::vec3 far_m(0.0f, kFloorM / -0.1005f, kFloorM);
  EXPECT_TRUE(look_up.At(far_m, kUp, 0));
  EXPECT_FALSE(look_up.MeanAlbedo(look_up.PlaceOf(far_m), 16.0f, far_m, kUp, 0));
}

}  // namespace
}  // namespace pleinair
