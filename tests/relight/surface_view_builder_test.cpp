#include "relight/surface_view_builder.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "scene/state_id.h"
#include "sunmodel/sky_shapes.h"
#include "tests/relight/survey_test_site.h"

namespace pleinair::surface_view_builder_test {
namespace {

constexpr double kRadius = kMeanSunAngularRadiusRad;

// Stands at `position_m`, looks to the north and a little down.
SunPlace At(const glm::dvec3& direction_enu, double radius_rad = kMeanSunAngularRadiusRad) {
  return {direction_enu, radius_rad, direction_enu};
}

Camera LookingNorth(const glm::dvec3& position_m, int width_px = 96, int height_px = 72) {
  Camera camera;
  camera.intrinsics = {.width_px = width_px,
                       .height_px = height_px,
                       .fx_px = 0.8 * width_px,
                       .fy_px = 0.8 * width_px,
                       .cx_px = 0.5 * (width_px - 1),
                       .cy_px = 0.5 * (height_px - 1)};
  const glm::dvec3 right(1.0, 0.0, 0.0);
  const glm::dvec3 forward = glm::normalize(glm::dvec3(0.0, 1.0, -0.2));
  const glm::dvec3 down = glm::cross(forward, right);
  const glm::dmat3 world_from_camera(right, down, forward);
  const glm::dmat3 camera_from_world = glm::transpose(world_from_camera);
  camera.camera_from_world = glm::dmat4(camera_from_world);
  camera.camera_from_world[3] = glm::dvec4(-(camera_from_world * position_m), 1.0);
  return camera;
}

const Camera kCamera = LookingNorth({1.0, -6.0, 2.0});

const std::vector<std::shared_ptr<const SkyShape>> kUniform{MakeUniformSkyShape()};

SurfaceViewBuilder Builder(const PreparedScene& scene, int block_px = 4) {
  return {scene, {.receiver_block_px = block_px}};
}

const PreparedScene& SiteWithoutAMap() {
  static const PreparedScene prepared = [] {
    SiteModel site = TheKnownSite().Model({});
    site.environment.reset();
    for (std::uint32_t i = 0; i < 3; ++i) {
      site.mesh.materials[i].diffuse_albedo = KnownSite::AlbedoOf(i);
    }
    site.diffuse_regions = {"ground", "house"};
    PrepareOptions options = KnownSite::Options();
    options.patches = {.patch_size_m = 1.5, .growth_per_m = 0.4};
    KeepsNothing store;
    return PrepareScene(site, options, store, {});
  }();
  return prepared;
}

// 4 %: the survey's own spread of albedos (see survey_test.cpp).
TEST(SurfaceViewBuilder, TakesTheAlbedoThatTheSurveyFoundAtTheSamePoint) {
  SurfaceViewBuilder builder = Builder(ThePreparedSite());
  const SurfaceView& view =
      builder.Update(kCamera, TheKnownSite().sun_direction_enu, kRadius, kUniform, {});
  int sampled = 0;
  for (std::size_t i = 0; i < view.region.pixels.size(); ++i) {
    if (view.may_be_sampled.pixels[i] == 0 || view.edge_distance_px.pixels[i] < 3.0f) continue;
    ASSERT_EQ(view.albedo_measured.pixels[i], 1);
    const auto region = static_cast<std::uint32_t>(view.region.pixels[i]);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(view.albedo_rgb.pixels[i][c] / KnownSite::AlbedoOf(region)[c], 1.0, 0.04);
    }
    ++sampled;
  }
  EXPECT_GT(sampled, 1500);
}

// Behind the low wall, seen from the map's place, the map knows nothing.
TEST(SurfaceViewBuilder, WhatTheMapCannotSeeIsNotMeasured) {
  SurfaceViewBuilder builder = Builder(ThePreparedSite());
  const SurfaceView& view = builder.Update(
      LookingNorth({6.0, -3.0, 2.5}), TheKnownSite().sun_direction_enu, kRadius, kUniform, {});
  const SurfaceView& survey = ThePreparedSite().survey->view;
  int hidden = 0;
  for (std::size_t i = 0; i < view.region.pixels.size(); ++i) {
    const glm::vec3& p = view.position_world_m.pixels[i];
    const bool behind_wall =
        view.region.pixels[i] == 0 && p.x > 4.6f && p.x < 7.0f && std::abs(p.y) < 1.5f;
    if (!behind_wall) continue;
    ++hidden;
    EXPECT_EQ(view.albedo_measured.pixels[i], 0);
    EXPECT_EQ(view.may_be_sampled.pixels[i], 0);
    EXPECT_NEAR(view.albedo_rgb.pixels[i].x, 0.3f, 0.04f) << "its material's mean";
  }
  EXPECT_GT(hidden, 50);
  EXPECT_EQ(survey.region_names, view.region_names);
}

TEST(SurfaceViewBuilder, WithoutAMapTheMaterialsAlbedoCounts) {
  SurfaceViewBuilder builder = Builder(SiteWithoutAMap());
  const SurfaceView& view =
      builder.Update(kCamera, TheKnownSite().sun_direction_enu, kRadius, kUniform, {});
  EXPECT_EQ(builder.SurveyUnderCurrentSun(), nullptr);
  for (std::size_t i = 0; i < view.region.pixels.size(); ++i) {
    const std::int32_t region = view.region.pixels[i];
    if (region == SurfaceView::kNoRegion) {
      EXPECT_EQ(view.may_be_sampled.pixels[i], 0);
      EXPECT_EQ(view.sky_response[0].pixels[i], glm::vec3(0.0f));
      continue;
    }
    EXPECT_EQ(view.albedo_measured.pixels[i], 1);
    EXPECT_EQ(view.may_be_sampled.pixels[i], region < 2 ? 1 : 0);
    EXPECT_GE(view.footprint_radius_px.pixels[i], 0.5f);
  }
}

// Blending over 4 x 4 pixels against gathering at each: away from edges, 256 rays' own spread.
TEST(SurfaceViewBuilder, BlendedReceiversComeCloseToExactOnes) {
  SurfaceViewBuilder blended = Builder(SiteWithoutAMap(), 4);
  SurfaceViewBuilder exact = Builder(SiteWithoutAMap(), 1);
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  const SurfaceView& a = blended.Update(kCamera, sun, kRadius, kUniform, {});
  const SurfaceView& b = exact.Update(kCamera, sun, kRadius, kUniform, {});
  double squares = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < a.region.pixels.size(); ++i) {
    if (a.region.pixels[i] == SurfaceView::kNoRegion || a.edge_distance_px.pixels[i] < 2.0f) {
      continue;
    }
    const double ratio = a.sky_response[0].pixels[i].y / b.sky_response[0].pixels[i].y;
    squares += (ratio - 1.0) * (ratio - 1.0);
    ++count;
    EXPECT_EQ(a.sun_visibility.pixels[i], b.sun_visibility.pixels[i]);
  }
  ASSERT_GT(count, 1000);
  EXPECT_LT(std::sqrt(squares / count), 0.02);
}

SurfaceViewOptions OnSurfaces() {
  return {.receivers_at = SurfaceViewOptions::ReceiversAt::kSurfaces};
}

// Root mean square of a - b over that of b, in green, away from edges.
double RelativeRms(const RgbImage& a, const RgbImage& b, const SurfaceView& view) {
  double off = 0.0;
  double all = 0.0;
  for (std::size_t i = 0; i < b.pixels.size(); ++i) {
    if (view.region.pixels[i] == SurfaceView::kNoRegion || view.edge_distance_px.pixels[i] < 2.0f) {
      continue;
    }
    off += std::pow(double{a.pixels[i].y} - b.pixels[i].y, 2.0);
    all += std::pow(double{b.pixels[i].y}, 2.0);
  }
  EXPECT_GT(all, 0.0);
  return std::sqrt(off / all);
}

TEST(SurfaceViewBuilder, LightOnSurfacesComesCloseToThatOfPixels) {
  SurfaceViewBuilder on_surfaces(SiteWithoutAMap(), OnSurfaces());
  SurfaceViewBuilder exact = Builder(SiteWithoutAMap(), 1);
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  const SurfaceView& a = on_surfaces.Update(kCamera, sun, kRadius, kUniform, {});
  const SurfaceView& b = exact.Update(kCamera, sun, kRadius, kUniform, {});
  // Most of it is the receivers' own noise: without blocks it is 0.019.
  EXPECT_LT(RelativeRms(a.sky_response[0], b.sky_response[0], b), 0.022);
  EXPECT_LT(RelativeRms(a.sun_bounce, b.sun_bounce, b), 0.15) << "the pixels' own noise in it";
  int off = 0;
  for (std::size_t i = 0; i < a.region.pixels.size(); ++i) {
    off += a.region.pixels[i] != b.region.pixels[i] ? 1 : 0;
  }
  EXPECT_LE(off, static_cast<int>(a.region.pixels.size()) / 200);
}

TEST(SurfaceViewBuilder, LightOnSurfacesIsBlendedInBlocks) {
  SurfaceViewOptions by_pixel = OnSurfaces();
  by_pixel.geometry_block_px = 1;
  SurfaceViewBuilder exact(SiteWithoutAMap(), by_pixel);
  SurfaceViewBuilder in_blocks(SiteWithoutAMap(), OnSurfaces());
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  const SurfaceView& a = in_blocks.Update(kCamera, sun, kRadius, kUniform, {});
  const SurfaceView& b = exact.Update(kCamera, sun, kRadius, kUniform, {});
  EXPECT_NE(a.sky_response[0].pixels, b.sky_response[0].pixels);
  EXPECT_LT(RelativeRms(a.sky_response[0], b.sky_response[0], b), 0.01);
  EXPECT_LT(RelativeRms(a.sun_bounce, b.sun_bounce, b), 0.03);
}

// What was shown before stays, and changes nothing of what comes after: neither another place, nor
// another sun or sky on the way.
TEST(SurfaceViewBuilder, LightOnSurfacesDoesNotDependOnTheWayThere) {
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  const Camera there = LookingNorth({-1.5, -5.0, 1.6});
  SurfaceViewBuilder walked(SiteWithoutAMap(), OnSurfaces());
  const std::vector<std::shared_ptr<const SkyShape>> clear{MakeClearSkyShape(sun)};
  walked.Update(kCamera, glm::normalize(glm::dvec3(0.3, 0.7, 0.5)), kRadius, clear, {});
  walked.Update(LookingNorth({0.0, -5.5, 1.8}), sun, kRadius, kUniform, {});
  const SurfaceView& a = walked.Update(there, sun, kRadius, kUniform, {});
  SurfaceViewBuilder fresh(SiteWithoutAMap(), OnSurfaces());
  const SurfaceView& b = fresh.Update(there, sun, kRadius, kUniform, {});
  EXPECT_EQ(a.region.pixels, b.region.pixels);
  EXPECT_EQ(a.position_world_m.pixels, b.position_world_m.pixels);
  EXPECT_EQ(a.sky_response[0].pixels, b.sky_response[0].pixels);
  EXPECT_EQ(a.sun_bounce.pixels, b.sun_bounce.pixels);
  EXPECT_EQ(a.sun_visibility.pixels, b.sun_visibility.pixels);
}

LookedAtPlaces Around(const glm::vec3& middle_m, float radius_m) {
  return {[=](std::int32_t, const glm::vec3& point_m, float reach_m) {
            return glm::distance(point_m, middle_m) <= radius_m + reach_m;
          },
          7};
}

// All that a view has at a pixel, but for the distance to an edge.
bool IsAlike(const SurfaceView& a, const SurfaceView& b, std::size_t pixel) {
  const auto is_alike = [pixel](const auto& image, const auto& other) {
    return image.pixels[pixel] == other.pixels[pixel];
  };
  return is_alike(a.region, b.region) && is_alike(a.position_world_m, b.position_world_m) &&
         is_alike(a.normal_world, b.normal_world) && is_alike(a.albedo_rgb, b.albedo_rgb) &&
         is_alike(a.albedo_measured, b.albedo_measured) &&
         is_alike(a.may_be_sampled, b.may_be_sampled) &&
         is_alike(a.footprint_radius_px, b.footprint_radius_px) &&
         is_alike(a.sky_response[0], b.sky_response[0]) &&
         is_alike(a.sun_visibility, b.sun_visibility) && is_alike(a.sun_bounce, b.sun_bounce);
}

bool IsBlank(const SurfaceView& view, std::size_t pixel) {
  return view.region.pixels[pixel] == SurfaceView::kNoRegion &&
         view.normal_world.pixels[pixel] == glm::vec3(0.0f) &&
         view.albedo_rgb.pixels[pixel] == glm::vec3(0.0f) &&
         view.may_be_sampled.pixels[pixel] == 0 && view.sun_visibility.pixels[pixel] == 0.0f &&
         view.sky_response[0].pixels[pixel] == glm::vec3(0.0f) &&
         view.sun_bounce.pixels[pixel] == glm::vec3(0.0f);
}

// A part after the whole, and other parts after that: each is as in the whole view of its camera,
// and nothing of the one before remains.
TEST(SurfaceViewBuilder, APartOfAViewIsAsInTheWhole) {
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  SurfaceViewBuilder builder(ThePreparedSite(), OnSurfaces());
  builder.Update(kCamera, sun, kRadius, kUniform, {});
  const ViewPart left{{{{-5, 10}, {21, 40}}}, {}};
  const ViewPart right{{{{60, 30}, {200, 71}}, {{3, 3}, {5, 5}}, {{-9, -9}, {-2, -2}}}, {}};
  const ViewPart near_a_place{{}, Around(glm::vec3(1.0f, -3.0f, 0.0f), 1.0f)};
  double x_m = 0.9;
  for (const ViewPart& part : {left, right, near_a_place}) {
    const Camera camera = LookingNorth({x_m -= 0.1, -6.0, 2.0});
    SurfaceViewBuilder fresh(ThePreparedSite(), OnSurfaces());
    const SurfaceView& whole = fresh.Update(camera, sun, kRadius, kUniform, {});
    const SurfaceView& view = builder.Update(camera, At(sun), kUniform, {}, &part);
    int made = 0;
    for (int y = 0; y < view.Height(); ++y) {
      for (int x = 0; x < view.Width(); ++x) {
        const std::size_t pixel = view.region.Index(x, y);
        const bool is_wanted = std::ranges::any_of(part.rects, [&](const PixelRect& rect) {
          return rect.Holds({x, y});
        });
        const bool shows_place =
            part.places.any_near && whole.region.pixels[pixel] != SurfaceView::kNoRegion &&
            part.places.any_near(0, whole.position_world_m.pixels[pixel], 0.0f);
        EXPECT_TRUE(IsAlike(view, whole, pixel) ||
                    (!is_wanted && !shows_place && IsBlank(view, pixel)))
            << x << " " << y;
        made += view.region.pixels[pixel] != SurfaceView::kNoRegion ? 1 : 0;
        // The part's own rim is an edge, and not near.
        if (shows_place) {
          EXPECT_EQ(std::min(view.edge_distance_px.pixels[pixel], 7.0f),
                    std::min(whole.edge_distance_px.pixels[pixel], 7.0f));
        }
      }
    }
    EXPECT_FALSE(view.is_whole);
    EXPECT_GT(made, 100);
    EXPECT_LT(made, view.Width() * view.Height() / 2);
  }
  const Camera camera = builder.View().camera;
  SurfaceViewBuilder fresh(ThePreparedSite(), OnSurfaces());
  const SurfaceView& whole = fresh.Update(camera, sun, kRadius, kUniform, {});
  const SurfaceView& completed = builder.WholeView();
  for (std::size_t i = 0; i < whole.region.pixels.size(); ++i) {
    ASSERT_TRUE(IsAlike(completed, whole, i));
    ASSERT_EQ(completed.edge_distance_px.pixels[i], whole.edge_distance_px.pixels[i]);
  }
}

// Shapes of the sky come and go between parts: no response of an earlier view remains.
TEST(SurfaceViewBuilder, APartHasNoResponseOfAnEarlierSky) {
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  const std::vector<std::shared_ptr<const SkyShape>> two{kUniform[0], MakeClearSkyShape(sun)};
  const ViewPart left{{{{0, 40}, {21, 60}}}, {}};
  SurfaceViewBuilder builder(SiteWithoutAMap(), OnSurfaces());
  builder.Update(kCamera, At(sun), two, {});
  builder.Update(LookingNorth({0.9, -6.0, 2.0}), At(sun), kUniform, {}, &left);
  const SurfaceView& view = builder.Update(LookingNorth({0.8, -6.0, 2.0}), At(sun), two, {}, &left);
  for (std::size_t i = 0; i < view.region.pixels.size(); ++i) {
    if (view.region.pixels[i] != SurfaceView::kNoRegion) continue;
    EXPECT_EQ(view.sky_response[0].pixels[i], glm::vec3(0.0f));
    EXPECT_EQ(view.sky_response[1].pixels[i], glm::vec3(0.0f));
  }
}

// What is flat in the picture lies between the rows of corners: a strip 0.2 m deep at 20 m is a
// pixel high.
TEST(SurfaceViewBuilder, APartHoldsPlacesThatNoCornerShows) {
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  const auto is_in_strip = [](const glm::vec3& point_m, float reach_m) {
    return std::abs(point_m.x - 1.0f) <= 0.5f + reach_m &&
           std::abs(point_m.y - 2.0f) <= 0.05f + reach_m && point_m.z < 0.1f + reach_m;
  };
  const ViewPart part{{},
                      {[&](std::int32_t, const glm::vec3& point_m, float reach_m) {
                         return is_in_strip(point_m, reach_m);
                       },
                       0}};
  int shown = 0;
  for (int step = 0; step < 12; ++step) {
    const Camera camera = LookingNorth({1.0, -6.0, 1.0 + 0.01 * step});
    SurfaceViewBuilder fresh(SiteWithoutAMap(), OnSurfaces());
    SurfaceViewBuilder whole(SiteWithoutAMap(), OnSurfaces());
    const SurfaceView& all = whole.Update(camera, sun, kRadius, kUniform, {});
    const SurfaceView& view = fresh.Update(camera, At(sun), kUniform, {}, &part);
    for (std::size_t i = 0; i < all.region.pixels.size(); ++i) {
      if (all.region.pixels[i] == SurfaceView::kNoRegion ||
          !is_in_strip(all.position_world_m.pixels[i], 0.0f)) {
        continue;
      }
      ++shown;
      EXPECT_TRUE(IsAlike(view, all, i)) << step;
    }
  }
  EXPECT_GT(shown, 5);
}

// The same camera again, and no part: the whole view is made. A polygon or receivers in the picture
// ask for all of it. A part stands where parts are asked for.
TEST(SurfaceViewBuilder, APartDoesNotStandForTheWhole) {
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  const ViewPart nothing;
  SurfaceViewBuilder builder(SiteWithoutAMap(), OnSurfaces());
  const SurfaceView& view = builder.Update(kCamera, At(sun), kUniform, {}, &nothing);
  const auto shows_nothing = [&] {
    return std::ranges::all_of(
        view.region.pixels, [](std::int32_t region) { return region == SurfaceView::kNoRegion; });
  };
  EXPECT_TRUE(shows_nothing());
  const StateId before = view.geometry_id;
  builder.Update(kCamera, At(sun), kUniform, {}, &nothing);
  EXPECT_EQ(view.geometry_id, before);
  EXPECT_TRUE(shows_nothing());
  builder.Update(kCamera, At(sun), kUniform, {});
  EXPECT_FALSE(shows_nothing());
  const std::vector<SampleRegionPolygon> all{{"", {{0, 0}, {95, 0}, {95, 71}, {0, 71}}}};
  builder.Update(LookingNorth({0.8, -6.0, 2.0}), At(sun), kUniform, all, &nothing);
  EXPECT_FALSE(shows_nothing());
  SurfaceViewBuilder in_picture = Builder(SiteWithoutAMap());
  const SurfaceView& by_pixels = in_picture.Update(kCamera, At(sun), kUniform, {}, &nothing);
  EXPECT_GT(by_pixels.region.pixels.back(), SurfaceView::kNoRegion);
}

TEST(SurfaceViewBuilder, ASunMadeAheadIsTakenByAMovedCamera) {
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  const glm::dvec3 next = glm::normalize(sun + glm::dvec3(0.02, 0.0, 0.0));
  const Camera there = LookingNorth({0.9, -6.0, 2.0});
  SurfaceViewBuilder ahead(SiteWithoutAMap(), OnSurfaces());
  ahead.Update(kCamera, sun, kRadius, kUniform, {});
  ahead.MakeAhead(At(next));
  const SurfaceView& a = ahead.Update(there, next, kRadius, kUniform, {});
  SurfaceViewBuilder fresh(SiteWithoutAMap(), OnSurfaces());
  const SurfaceView& b = fresh.Update(there, next, kRadius, kUniform, {});
  EXPECT_EQ(a.sun_bounce.pixels, b.sun_bounce.pixels);
  EXPECT_EQ(a.sun_visibility.pixels, b.sun_visibility.pixels);
}

// What is off lies in penumbrae and slivers that no block's corner sees.
TEST(SurfaceViewBuilder, BlocksOfSunComeCloseToPixels) {
  SurfaceViewBuilder blocks(SiteWithoutAMap(), {.sun_block_px = 4});
  SurfaceViewBuilder exact(SiteWithoutAMap(), {});
  // From behind the house: its shadow falls towards the camera.
  const glm::dvec3 sun = glm::normalize(glm::dvec3(0.3, 0.7, 0.5));
  const SurfaceView& a = blocks.Update(kCamera, sun, kRadius, kUniform, {});
  const SurfaceView& b = exact.Update(kCamera, sun, kRadius, kUniform, {});
  int lit = 0;
  int shaded = 0;
  int off = 0;
  for (std::size_t i = 0; i < a.sun_visibility.pixels.size(); ++i) {
    if (b.region.pixels[i] == SurfaceView::kNoRegion) continue;
    lit += b.sun_visibility.pixels[i] == 1.0f ? 1 : 0;
    shaded += b.sun_visibility.pixels[i] == 0.0f ? 1 : 0;
    off += a.sun_visibility.pixels[i] != b.sun_visibility.pixels[i] ? 1 : 0;
  }
  EXPECT_GT(lit, 300);
  EXPECT_GT(shaded, 300);
  EXPECT_LE(off, (lit + shaded) / 200);
  EXPECT_THROW(SurfaceViewBuilder(SiteWithoutAMap(), {.sun_block_px = -1}), std::invalid_argument);
}

// The sun on faces is kept apart from the sun in the view: with a new camera the first stays.
TEST(SurfaceViewBuilder, ANewCameraKeepsTheSunsFaces) {
  SurfaceViewBuilder builder = Builder(SiteWithoutAMap());
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  builder.Update(kCamera, sun, kRadius, kUniform, {});
  const StateId before = builder.SunFacesId();
  const SurfaceView& view =
      builder.Update(LookingNorth({2.0, -6.0, 2.0}), sun, kRadius, kUniform, {});
  EXPECT_EQ(builder.SunFacesId(), before);
  ASSERT_EQ(builder.PixelSides().pixels.size(), view.region.pixels.size());
  for (std::size_t i = 0; i < view.region.pixels.size(); ++i) {
    EXPECT_EQ(builder.PixelSides().pixels[i] == PatchScene::kSky,
              view.region.pixels[i] == SurfaceView::kNoRegion);
  }
  builder.Update(kCamera, glm::normalize(sun + glm::dvec3(0.02, 0.0, 0.0)), kRadius, kUniform, {});
  EXPECT_NE(builder.SunFacesId(), before);
}

TEST(SurfaceViewBuilder, IsAPureFunctionOfItsArguments) {
  SurfaceViewBuilder builder = Builder(SiteWithoutAMap());
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  const SurfaceView first = builder.Update(kCamera, sun, kRadius, kUniform, {});
  const StateId geometry = first.geometry_id;
  const StateId sun_id = first.sun_id;

  const SurfaceView& kept = builder.Update(kCamera, sun, kRadius, kUniform, {});
  EXPECT_EQ(kept.geometry_id, geometry);
  EXPECT_EQ(kept.sun_id, sun_id);

  const SurfaceView& moved =
      builder.Update(kCamera, glm::normalize(glm::dvec3(0.6, -0.4, 0.5)), kRadius, kUniform, {});
  EXPECT_EQ(moved.geometry_id, geometry);
  EXPECT_NE(moved.sun_id, sun_id);
  EXPECT_NE(moved.sun_visibility.pixels, first.sun_visibility.pixels);

  builder.Update(LookingNorth({0.0, -9.0, 3.0}), sun, kRadius, kUniform, {});
  const SurfaceView& back = builder.Update(kCamera, sun, kRadius, kUniform, {});
  EXPECT_NE(back.geometry_id, geometry);
  EXPECT_EQ(back.sky_response[0].pixels, first.sky_response[0].pixels);
  EXPECT_EQ(back.sun_bounce.pixels, first.sun_bounce.pixels);
  EXPECT_EQ(back.sun_visibility.pixels, first.sun_visibility.pixels);
  EXPECT_EQ(back.edge_distance_px.pixels, first.edge_distance_px.pixels);
}

TEST(SurfaceViewBuilder, PolygonsLimitWhereItMayBeSampled) {
  SurfaceViewBuilder builder = Builder(SiteWithoutAMap());
  const std::vector<SampleRegionPolygon> polygons{
      {"ground", {{10.0, 10.0}, {60.0, 10.0}, {60.0, 70.0}, {10.0, 70.0}}}};
  const SurfaceView& view =
      builder.Update(kCamera, TheKnownSite().sun_direction_enu, kRadius, kUniform, polygons);
  int sampled = 0;
  for (int y = 0; y < view.Height(); ++y) {
    for (int x = 0; x < view.Width(); ++x) {
      if (view.may_be_sampled.At(x, y) == 0) continue;
      ++sampled;
      EXPECT_EQ(view.region.At(x, y), 0);
      EXPECT_TRUE(x >= 10 && x <= 60 && y >= 10 && y <= 70);
    }
  }
  EXPECT_GT(sampled, 100);
}

// A person's judgment belongs to the pixels of its polygon that show its group, and to that frame
// alone; where two overlap the last one stands.
TEST(SurfaceViewBuilder, CarriesWhatAPersonJudgedOfTheSun) {
  SurfaceViewBuilder builder = Builder(SiteWithoutAMap());
  const auto square = [](double from, double to) {
    return std::vector<glm::dvec2>{{from, from}, {to, from}, {to, to}, {from, to}};
  };
  std::vector<SampleRegionPolygon> polygons{{"ground", square(10.0, 50.0), JudgedSun::kLit},
                                            {"ground", square(40.0, 70.0), JudgedSun::kShaded},
                                            {"house", square(0.0, 70.0), JudgedSun::kGrazing}};
  const glm::dvec3 sun = TheKnownSite().sun_direction_enu;
  const SurfaceView& view = builder.Update(kCamera, sun, kRadius, kUniform, polygons);
  std::map<JudgedSun, int> pixels;
  for (int y = 0; y < view.Height(); ++y) {
    for (int x = 0; x < view.Width(); ++x) {
      const std::int32_t region = view.region.At(x, y);
      const auto within = [&](int from, int to) {
        return x >= from && x <= to && y >= from && y <= to;
      };
      const bool ground = region != SurfaceView::kNoRegion && view.region_names[region] == "ground";
      const bool house = region != SurfaceView::kNoRegion && view.region_names[region] == "house";
      const JudgedSun expected = house && within(0, 70)     ? JudgedSun::kGrazing
                                 : ground && within(40, 70) ? JudgedSun::kShaded
                                 : ground && within(10, 50) ? JudgedSun::kLit
                                                            : JudgedSun::kUnknown;
      EXPECT_EQ(view.judged_sun.At(x, y), expected) << x << ", " << y;
      ++pixels[expected];
    }
  }
  EXPECT_EQ(pixels.size(), 4u);
  const StateId geometry = view.geometry_id;
  polygons[0].sun = JudgedSun::kShaded;
  builder.Update(kCamera, sun, kRadius, kUniform, polygons);
  EXPECT_NE(view.geometry_id, geometry);
  builder.Update(kCamera, sun, kRadius, kUniform, {});
  EXPECT_TRUE(view.judged_sun.Empty());
}

// Each pixel's surface projects back onto the pixel: 1e-3 px from float positions 10 m away.
TEST(SurfaceViewBuilder, PixelsSeeThroughTheDistortedLens) {
  Camera camera = kCamera;
  camera.intrinsics.distortion = {-0.2, 0.05, 0.001, -0.001, 0.0};
  SurfaceViewBuilder builder = Builder(SiteWithoutAMap());
  const SurfaceView& view =
      builder.Update(camera, TheKnownSite().sun_direction_enu, kRadius, kUniform, {});
  for (int y = 0; y < view.Height(); y += 5) {
    for (int x = 0; x < view.Width(); x += 5) {
      if (view.region.At(x, y) == SurfaceView::kNoRegion) continue;
      const glm::dvec3 p(camera.camera_from_world *
                         glm::dvec4(glm::dvec3(view.position_world_m.At(x, y)), 1.0));
      const double u = p.x / p.z;
      const double v = p.y / p.z;
      const double r2 = u * u + v * v;
      const auto& d = camera.intrinsics.distortion;
      const double radial = 1.0 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]));
      const double xd = u * radial + 2.0 * d[2] * u * v + d[3] * (r2 + 2.0 * u * u);
      const double yd = v * radial + d[2] * (r2 + 2.0 * v * v) + 2.0 * d[3] * u * v;
      EXPECT_NEAR(camera.intrinsics.fx_px * xd + camera.intrinsics.cx_px, x, 1e-3);
      EXPECT_NEAR(camera.intrinsics.fy_px * yd + camera.intrinsics.cy_px, y, 1e-3);
    }
  }
}

// Under the survey's own sun the map's sun parts are the survey's; under another one they are not.
TEST(SurfaceViewBuilder, TheSurveysMapFollowsTheSun) {
  const PreparedScene& prepared = ThePreparedSite();
  SurfaceViewBuilder builder = Builder(prepared);
  EXPECT_THROW(builder.SurveyUnderCurrentSun(), std::logic_error);
  builder.Update(kCamera, prepared.survey->light.sun_direction_enu, kRadius, kUniform, {});
  const Survey* now = builder.SurveyUnderCurrentSun();
  EXPECT_EQ(now->view.sun_visibility.pixels, prepared.survey->view.sun_visibility.pixels);
  EXPECT_EQ(now->view.sun_bounce.pixels, prepared.survey->view.sun_bounce.pixels);
  EXPECT_EQ(now->view.albedo_rgb.pixels, prepared.survey->view.albedo_rgb.pixels);
  builder.Update(kCamera, glm::normalize(glm::dvec3(0.6, -0.4, 0.5)), kRadius, kUniform, {});
  now = builder.SurveyUnderCurrentSun();
  EXPECT_NE(now->view.sun_visibility.pixels, prepared.survey->view.sun_visibility.pixels);
  EXPECT_EQ(now, builder.SurveyUnderCurrentSun());
}

const glm::dvec3 kLaterSun = glm::normalize(glm::dvec3(0.6, -0.4, 0.5));

// Until the part of this sun is made on its thread.
void WaitUntilAtHand(const SurfaceViewBuilder& builder,
                     const Camera& camera,
                     const glm::dvec3& sun_direction_enu) {
  while (!builder.IsAtHand(camera, At(sun_direction_enu), {})) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

void ExpectSameView(const SurfaceView& a, const SurfaceView& b) {
  EXPECT_EQ(a.sun_direction_enu, b.sun_direction_enu);
  EXPECT_EQ(a.region.pixels, b.region.pixels);
  EXPECT_EQ(a.sun_visibility.pixels, b.sun_visibility.pixels);
  EXPECT_EQ(a.sun_bounce.pixels, b.sun_bounce.pixels);
  EXPECT_EQ(a.edge_distance_px.pixels, b.edge_distance_px.pixels);
  EXPECT_EQ(a.albedo_rgb.pixels, b.albedo_rgb.pixels);
  ASSERT_EQ(a.sky_response.size(), b.sky_response.size());
  for (std::size_t k = 0; k < a.sky_response.size(); ++k) {
    EXPECT_EQ(a.sky_response[k].pixels, b.sky_response[k].pixels);
  }
}

TEST(SurfaceViewBuilder, AViewTakenFromAheadIsTheOneMadeAtOnce) {
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  for (const PreparedScene* site : {&SiteWithoutAMap(), &ThePreparedSite()}) {
    SurfaceViewBuilder ahead = Builder(*site);
    SurfaceViewBuilder at_once = Builder(*site);
    ahead.Update(kCamera, sun, kRadius, kUniform, {});
    EXPECT_TRUE(ahead.IsAtHand(kCamera, At(sun), {}));
    EXPECT_FALSE(ahead.IsAtHand(kCamera, At(kLaterSun), {}));
    ahead.MakeAhead(At(kLaterSun));
    // While it is made, the last view stands.
    ExpectSameView(ahead.Update(kCamera, sun, kRadius, kUniform, {}),
                   at_once.Update(kCamera, sun, kRadius, kUniform, {}));
    WaitUntilAtHand(ahead, kCamera, kLaterSun);
    const StateId faces = ahead.SunFacesId();
    ExpectSameView(ahead.Update(kCamera, kLaterSun, kRadius, kUniform, {}),
                   at_once.Update(kCamera, kLaterSun, kRadius, kUniform, {}));
    EXPECT_NE(ahead.SunFacesId(), faces);
    EXPECT_EQ(ahead.SunFaces().radiosity, at_once.SunFaces().radiosity);
    if (site->survey) {
      EXPECT_EQ(ahead.SurveyUnderCurrentSun()->view.sun_visibility.pixels,
                at_once.SurveyUnderCurrentSun()->view.sun_visibility.pixels);
    }
    // It was taken: the sun before is not at hand any more.
    EXPECT_FALSE(ahead.IsAtHand(kCamera, At(sun), {}));
  }
}

// An Update that wants it before it is made waits for it.
TEST(SurfaceViewBuilder, AViewThatIsStillBeingMadeIsWaitedFor) {
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  SurfaceViewBuilder ahead = Builder(SiteWithoutAMap());
  SurfaceViewBuilder at_once = Builder(SiteWithoutAMap());
  ahead.Update(kCamera, sun, kRadius, kUniform, {});
  ahead.MakeAhead(At(kLaterSun));
  ExpectSameView(ahead.Update(kCamera, kLaterSun, kRadius, kUniform, {}),
                 at_once.Update(kCamera, kLaterSun, kRadius, kUniform, {}));
}

// What was made of another view, or for another sun, is not used.
TEST(SurfaceViewBuilder, WhatWasMadeAheadForAnotherViewIsNotUsed) {
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  const Camera moved = LookingNorth({2.0, -7.0, 2.5});
  const std::vector<SampleRegionPolygon> polygons{
      {"ground", {{10.0, 10.0}, {60.0, 10.0}, {60.0, 70.0}}}};
  SurfaceViewBuilder ahead = Builder(SiteWithoutAMap());
  SurfaceViewBuilder at_once = Builder(SiteWithoutAMap());
  ahead.Update(kCamera, sun, kRadius, kUniform, {});
  ahead.MakeAhead(At(kLaterSun));
  WaitUntilAtHand(ahead, kCamera, kLaterSun);
  EXPECT_TRUE(ahead.Stands(kCamera, {}));
  EXPECT_FALSE(ahead.Stands(moved, {}));
  EXPECT_FALSE(ahead.Stands(kCamera, polygons));
  EXPECT_FALSE(ahead.IsAtHand(moved, At(kLaterSun), {}));
  EXPECT_FALSE(ahead.IsAtHand(kCamera, At(kLaterSun), polygons));
  EXPECT_FALSE(ahead.IsAtHand(kCamera, At(kLaterSun, 2.0 * kRadius), {}));
  ExpectSameView(ahead.Update(moved, kLaterSun, kRadius, kUniform, {}),
                 at_once.Update(moved, kLaterSun, kRadius, kUniform, {}));
  // Also while it is still being made.
  ahead.MakeAhead(At(sun));
  ExpectSameView(ahead.Update(kCamera, sun, kRadius, kUniform, {}),
                 at_once.Update(kCamera, sun, kRadius, kUniform, {}));
}

// Shapes of the sky may change meanwhile: they are no part of it.
TEST(SurfaceViewBuilder, ANewSkyLeavesWhatIsMadeAhead) {
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  const std::vector<std::shared_ptr<const SkyShape>> two{MakeUniformSkyShape(),
                                                         MakeUniformSkyShape()};
  SurfaceViewBuilder ahead = Builder(SiteWithoutAMap());
  SurfaceViewBuilder at_once = Builder(SiteWithoutAMap());
  ahead.Update(kCamera, sun, kRadius, kUniform, {});
  ahead.MakeAhead(At(kLaterSun));
  ahead.Update(kCamera, sun, kRadius, two, {});
  WaitUntilAtHand(ahead, kCamera, kLaterSun);
  ExpectSameView(ahead.Update(kCamera, kLaterSun, kRadius, two, {}),
                 at_once.Update(kCamera, kLaterSun, kRadius, two, {}));
}

// The sun moves on, what its light does after it has met a surface stays.
TEST(SurfaceViewBuilder, BouncesMayComeFromAnotherPlaceThanTheSun) {
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  for (const auto at :
       {SurfaceViewOptions::ReceiversAt::kPixels, SurfaceViewOptions::ReceiversAt::kSurfaces}) {
    SurfaceViewOptions options;
    options.receivers_at = at;
    SurfaceViewBuilder apart(SiteWithoutAMap(), options);
    SurfaceViewBuilder before(SiteWithoutAMap(), options);
    SurfaceViewBuilder after(SiteWithoutAMap(), options);
    apart.Update(kCamera, At(sun), kUniform, {});
    const StateId faces = apart.SunFacesId();
    const SurfaceView& view = apart.Update(kCamera, {kLaterSun, kRadius, sun}, kUniform, {});
    EXPECT_EQ(apart.SunFacesId(), faces);
    const SurfaceView& of_sun = after.Update(kCamera, At(kLaterSun), kUniform, {});
    const SurfaceView& of_bounces = before.Update(kCamera, At(sun), kUniform, {});
    EXPECT_EQ(view.sun_direction_enu, kLaterSun);
    EXPECT_EQ(view.sun_visibility.pixels, of_sun.sun_visibility.pixels);
    EXPECT_EQ(view.edge_distance_px.pixels, of_sun.edge_distance_px.pixels);
    EXPECT_EQ(view.sun_bounce.pixels, of_bounces.sun_bounce.pixels);
    // Made ahead it is the same.
    before.MakeAhead({kLaterSun, kRadius, sun});
    ExpectSameView(before.Update(kCamera, {kLaterSun, kRadius, sun}, kUniform, {}), view);
    EXPECT_EQ(before.SunFaces().radiosity, apart.SunFaces().radiosity);
  }
}

// One at a time; and before the first view there is nothing to be made of.
TEST(SurfaceViewBuilder, MakesOneSunAhead) {
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  const glm::dvec3 third = glm::normalize(glm::dvec3(-0.3, -0.5, 0.6));
  SurfaceViewBuilder builder = Builder(SiteWithoutAMap());
  builder.MakeAhead(At(kLaterSun));
  EXPECT_FALSE(builder.IsAtHand(kCamera, At(kLaterSun), {}));
  builder.Update(kCamera, sun, kRadius, kUniform, {});
  builder.MakeAhead(At(sun));  // It stands.
  builder.MakeAhead(At(kLaterSun));
  WaitUntilAtHand(builder, kCamera, kLaterSun);
  builder.MakeAhead(At(third));
  WaitUntilAtHand(builder, kCamera, third);
  EXPECT_FALSE(builder.IsAtHand(kCamera, At(kLaterSun), {}));
  // A builder that is destroyed meanwhile waits for its thread.
  builder.MakeAhead(At(kLaterSun));
}

TEST(SurfaceViewBuilderHardCases, APictureOfOnePixelAndOneOfSkyAlone) {
  SurfaceViewBuilder builder = Builder(SiteWithoutAMap());
  const glm::dvec3& sun = TheKnownSite().sun_direction_enu;
  EXPECT_EQ(builder.Update(LookingNorth({0, -6, 2}, 1, 1), sun, kRadius, kUniform, {}).Width(), 1);
  Camera up = kCamera;
  up.camera_from_world = glm::dmat4(glm::dmat3(1, 0, 0, 0, 1, 0, 0, 0, 1));
  up.camera_from_world[3] = glm::dvec4(0.0, 6.0, -50.0, 1.0);
  const SurfaceView& view = builder.Update(up, sun, kRadius, kUniform, {});
  for (const std::int32_t region : view.region.pixels) EXPECT_EQ(region, SurfaceView::kNoRegion);
}

}  // namespace
}  // namespace pleinair::surface_view_builder_test
