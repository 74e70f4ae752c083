#include "relight/survey/survey.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "relight/survey/survey_maps.h"
#include "relight/volume/environment.h"
#include "tests/relight/survey_test_site.h"

namespace pleinair::survey_test {
namespace {

// Measured over true albedo of the pixels of a region, sorted; the channel with the largest spread.
std::vector<double> AlbedoRatios(const PreparedScene& prepared,
                                 std::int32_t region,
                                 std::uint32_t material,
                                 float margin_px) {
  const SurfaceView& view = prepared.survey->view;
  std::vector<double> ratios;
  for (std::size_t i = 0; i < view.region.pixels.size(); ++i) {
    if (view.region.pixels[i] != region || view.albedo_measured.pixels[i] == 0) continue;
    if (view.edge_distance_px.pixels[i] < margin_px) continue;
    for (int c = 0; c < 3; ++c) {
      ratios.push_back(view.albedo_rgb.pixels[i][c] / KnownSite::AlbedoOf(material)[c]);
    }
  }
  std::sort(ratios.begin(), ratios.end());
  return ratios;
}

// 1 %: the disc in one pixel loses nothing, its background is the ring's median (0.1 % here).
TEST(Survey, MeasuresTheSunsDisc) {
  const SurveyLight& light = ThePreparedSite().survey->light;
  EXPECT_FALSE(light.sun_clipped);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(light.sun_irradiance_rgb[c] / TheKnownSite().sun_irradiance_rgb[c], 1.0, 0.01);
    EXPECT_LT(std::abs(light.sun_irradiance_rgb[c] - TheKnownSite().sun_irradiance_rgb[c]),
              3.0 * light.sun_irradiance_stddev_rgb[c]);
  }
}

// A quarter of the sky's low third is hidden by the house; its rows go on behind it. What is left
// is the sky's slope from south to north.
TEST(Survey, MeasuresTheSkyBehindTheHouseToo) {
  const glm::dvec3 truth = HorizontalIrradiance(TheKnownSite().sky);
  const SurveyLight& light = ThePreparedSite().survey->light;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(light.sky_irradiance_rgb[c] / truth[c], 1.0, 0.01);
  EXPECT_LT(light.sky_radiance.At(128, 30).x, 100.0f) << "the disc is taken out";
  EXPECT_EQ(light.sky_radiance.At(128, 100), glm::vec3(0.0f)) << "black below the horizon";
}

// The map was made with other rays and other pixels gathering: 1 % is some 2 sigma of a receiver's
// own 128 rays each side, so the median is held to it and the spread to 4 %.
TEST(Survey, FindsTheAlbedosThatTheMapWasMadeWith) {
  struct Case {
    std::int32_t region;
    std::uint32_t material;
  };
  for (const auto& [region, material] : {Case{0, 0}, Case{1, 1}, Case{2, 2}}) {
    const std::vector<double> ratios = AlbedoRatios(ThePreparedSite(), region, material, 2.0f);
    ASSERT_GT(ratios.size(), 100u) << region;
    EXPECT_NEAR(ratios[ratios.size() / 2], 1.0, 0.01) << region;
    EXPECT_GT(ratios[ratios.size() / 20], 0.96) << region;
    EXPECT_LT(ratios[ratios.size() - 1 - ratios.size() / 20], 1.04) << region;
  }
}

// The house's rear and roof are not in the map, nor is the ground behind it.
TEST(Survey, WhatTheMapCannotSeeTakesItsMaterialsAlbedo) {
  const PreparedScene& prepared = ThePreparedSite();
  for (std::size_t face = 0; face < prepared.patches.FaceCount(); ++face) {
    const std::uint32_t material = prepared.patches.mesh.triangle_material[face / 2];
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(
          prepared.patches.face_albedo_rgb[face][c] / KnownSite::AlbedoOf(material)[c], 1.0, 0.12)
          << "face " << face;
    }
  }
}

// albedo = pi L / E with the very E that relighting uses. Half float: 2^-11.
TEST(Survey, RelightingWithItsOwnLightGivesTheMapBack) {
  const SurveyMaps maps = MakeSurveyMaps(*ThePreparedSite().survey);
  const SurfaceView& view = ThePreparedSite().survey->view;
  const RgbImage& map = TheKnownMap();
  std::size_t surfaces = 0;
  std::size_t known = 0;
  for (std::size_t i = 0; i < map.pixels.size(); ++i) {
    if (view.region.pixels[i] == SurfaceView::kNoRegion) continue;
    ++surfaces;
    if (view.albedo_measured.pixels[i] == 0) continue;
    ++known;
    for (int c = 0; c < 3; ++c) {
      ASSERT_NEAR(maps.relit.pixels[i][c] / map.pixels[i][c], 1.0, 0.5 / 1024.0) << i;
    }
  }
  EXPECT_GT(known, surfaces * 99 / 100);
}

TEST(Survey, OnlyDiffuseRegionsInsideTheMaskMayBeSampled) {
  SiteModel site = TheKnownSite().Model(TheKnownMap());
  site.diffuse_regions = {"ground", "brick"};  // A group and a material.
  site.diffuse_mask = Gray8Image(256, 128, 255);
  for (int y = 0; y < 128; ++y) site.diffuse_mask->At(200, y) = 0;
  KeepsNothing store;
  PrepareOptions options = KnownSite::Options();
  options.gather.rays_per_receiver = 16;
  options.survey_receiver_block_px = 8;
  const PreparedScene prepared = PrepareScene(site, options, store, {});
  const SurfaceView& view = prepared.survey->view;
  std::array<int, 5> sampled{};
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 256; ++x) {
      if (view.may_be_sampled.At(x, y) == 0) continue;
      EXPECT_NE(x, 200);
      ++sampled[static_cast<std::size_t>(view.region.At(x, y) + 1)];
    }
  }
  EXPECT_EQ(sampled[0], 0) << "sky";
  EXPECT_GT(sampled[1], 1000) << "ground";
  EXPECT_GT(sampled[2], 500) << "house";
  EXPECT_EQ(sampled[3], 0) << "low wall";
  EXPECT_EQ(sampled[4], 0) << "the ground's extension";
  site.diffuse_regions = {"no such thing"};
  EXPECT_THROW(PrepareScene(site, options, store, {}), std::invalid_argument);
}

TEST(Survey, EdgesAreWhereSurfacesAndShadowsEnd) {
  const SurfaceView& view = ThePreparedSite().survey->view;
  for (int y = 0; y < view.Height(); ++y) {
    for (int x = 0; x + 1 < view.Width(); ++x) {
      const bool jump = view.region.At(x, y) != view.region.At(x + 1, y) ||
                        (view.region.At(x, y) >= 0 &&
                         view.sun_visibility.At(x, y) != view.sun_visibility.At(x + 1, y));
      if (jump) {
        EXPECT_EQ(view.edge_distance_px.At(x, y), 0.0f);
        EXPECT_EQ(view.edge_distance_px.At(x + 1, y), 0.0f);
      }
    }
  }
}

TEST(SurveyMaps, ShowTheAmbientWeight) {
  const SurveyMaps maps = MakeSurveyMaps(*ThePreparedSite().survey);
  // Straight down: open ground but for the house 4 m away and the low wall.
  EXPECT_NEAR(maps.ambient_weight.At(10, 125).x, 0.9, 0.1);
  // North, on the house's wall at 1 m: half of the sky.
  EXPECT_NEAR(maps.ambient_weight.At(128, 60).x, 0.5, 0.05);
  EXPECT_EQ(maps.ambient_weight.At(128, 5), glm::vec3(0.0f)) << "sky";
}

}  // namespace
}  // namespace pleinair::survey_test
