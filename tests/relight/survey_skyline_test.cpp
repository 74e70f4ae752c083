#include "relight/survey/internal/survey_skyline.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "relight/surface_view_builder.h"
#include "scene/lat_long.h"
#include "scene/upper_median.h"
#include "sunmodel/angles.h"
#include "sunmodel/sky_luminance.h"
#include "tests/relight/survey_test_site.h"

namespace pleinair::survey_skyline_test {
namespace {

constexpr LatLongSize kSize{512, 256};

double ElevationDeg(const glm::dvec3& direction) { return DegFromRad(std::asin(direction.z)); }
double AzimuthDeg(const glm::dvec3& direction) {
  return DegFromRad(std::atan2(direction.x, direction.y));
}

using RadianceOf = std::function<glm::dvec3(const glm::dvec3& direction)>;

RgbImage MapOf(const RadianceOf& radiance, double relative_noise = 0.0, std::uint32_t seed = 1) {
  RgbImage map(kSize.width, kSize.height, glm::vec3(1.0f));
  std::uint32_t state = seed;
  const auto random = [&] {
    state = state * 1664525u + 1013904223u;
    return static_cast<double>(state >> 8) / (1u << 24) - 0.5;
  };
  for (int y = 0; y < kSize.height; ++y) {
    for (int x = 0; x < kSize.width; ++x) {
      const double noise = std::max(1.0 + std::sqrt(12.0) * relative_noise * random(), 0.01);
      map.At(x, y) = glm::vec3(noise * radiance(DirectionFromLatLong({x + 0.5, y + 0.5}, kSize)));
    }
  }
  return map;
}

Gray8Image UpperHalf() {
  Gray8Image shows_sky(kSize.width, kSize.height, 0);
  std::fill_n(shows_sky.pixels.begin(), shows_sky.pixels.size() / 2, std::uint8_t{255});
  return shows_sky;
}

int CountOf(const Gray8Image& mask) {
  return static_cast<int>(
      std::count_if(mask.pixels.begin(), mask.pixels.end(), [](auto pixel) { return pixel != 0; }));
}

// How many of the sky's pixels that `is_thing`, and of the others, are found.
struct Found {
  double of_things = 0.0;
  double of_sky = 0.0;
};

Found FoundIn(const RgbImage& map, const std::function<bool(const glm::dvec3&)>& is_thing) {
  const Gray8Image hidden = FindHiddenSky(map, UpperHalf());
  int things = 0;
  int things_found = 0;
  int sky_found = 0;
  for (int y = 0; y < kSize.height / 2; ++y) {
    for (int x = 0; x < kSize.width; ++x) {
      const bool thing = is_thing(DirectionFromLatLong({x + 0.5, y + 0.5}, kSize));
      const bool found = hidden.At(x, y) != 0;
      things += thing ? 1 : 0;
      things_found += thing && found ? 1 : 0;
      sky_found += !thing && found ? 1 : 0;
    }
  }
  return {static_cast<double>(things_found) / things,
          sky_found / (0.5 * kSize.width * kSize.height - things)};
}

const glm::dvec3 kHighSun = glm::normalize(glm::dvec3(0.5, -0.6, 0.7));
const glm::dvec3 kLowSun = glm::normalize(glm::dvec3(-0.8, -0.6, 0.12));

// The zenith of the clear sky is 1 in the green, and the disc is lit by `glare`, as a lens does.
RadianceOf ClearSky(const glm::dvec3& sun, double depth, double glare = 0.0) {
  return [=, clear = ClearSkyDistribution(sun, depth)](const glm::dvec3& direction) {
    const double zenith = clear.Radiance({0.0, 0.0, 1.0}).y;
    const double from_sun =
        std::atan2(glm::length(glm::cross(direction, sun)), glm::dot(direction, sun));
    const glm::dvec3 up(direction.x, direction.y, std::max(direction.z, 0.01));
    const double veil = glare / (1.0 + std::pow(from_sun / RadFromDeg(1.0), 2.0));
    return clear.Radiance(glm::normalize(up)) / zenith * glm::dvec3(0.5, 1.0, 2.0) +
           glm::dvec3(veil + (from_sun < RadFromDeg(0.3) ? 5e4 : 0.0));
  };
}

// A wood to the east, 2 to 14 deg high.
bool IsWood(const glm::dvec3& direction) {
  const double azimuth = AzimuthDeg(direction);
  if (std::abs(azimuth - 90.0) > 50.0) return false;
  return ElevationDeg(direction) < 8.0 + 4.0 * std::sin(RadFromDeg(9.0 * azimuth));
}

RadianceOf WithWood(const RadianceOf& sky) {
  return [=](const glm::dvec3& direction) {
    if (!IsWood(direction)) return sky(direction);
    const double leaves =
        0.15 + 0.1 * std::sin(200.0 * direction.z) * std::sin(300.0 * direction.y);
    return leaves * glm::dvec3(0.7, 1.0, 0.4);
  };
}

// Smooth waves of 60 deg to 2 deg, each half as high as the last: -1 to 1 or so.
double Waves(const glm::dvec3& direction, std::uint32_t seed) {
  double sum = 0.0;
  double height = 0.6;
  double frequency = 6.0;
  for (int octave = 0; octave < 5; ++octave) {
    const double turn = 1.7 * octave + 0.9 * seed;
    const glm::dvec3 a(std::cos(turn), std::sin(turn), 0.7);
    const glm::dvec3 b(-std::sin(1.3 * turn), std::cos(1.3 * turn), 1.4);
    sum += height * std::sin(frequency * glm::dot(a, direction) + turn) *
           std::cos(1.2 * frequency * glm::dot(b, direction) - turn);
    height *= 0.5;
    frequency *= 2.0;
  }
  return sum;
}

// Bright where the sun is on it, with dark bases and an edge of a degree or less; far off the air
// is before them.
RadianceOf BrokenClouds(const RadianceOf& clear, std::uint32_t seed) {
  return [=](const glm::dvec3& direction) {
    // Clouds are flat: nearer to each other towards the horizon.
    const double flat = 0.4 / std::max(direction.z, 0.05);
    const glm::dvec3 place(flat * direction.x, flat * direction.y, 1.0);
    const double thick = 4.0 * (Waves(0.5 * place, seed) - 0.1);
    const double cloud = std::clamp(thick, 0.0, 1.0);
    const double shade = 4.0 - 2.6 * std::clamp(thick - 0.6, 0.0, 1.0);
    const double through_air = std::exp(-0.06 / std::max(direction.z, 1e-3));
    const glm::dvec3 seen = cloud * (shade * glm::dvec3(0.95, 1.0, 1.05) - clear(direction));
    return clear(direction) + through_air * seen;
  };
}

// Its outline of 142 columns, 18 of them two rows up or down, is known to a pixel.
constexpr double kEdgesOfWood = 160.0 / (512 * 128);

TEST(SurveySkyline, AWoodBeforeAClearSkyIsFound) {
  const Found found = FoundIn(MapOf(WithWood(ClearSky(kHighSun, 0.1))), IsWood);
  EXPECT_GT(found.of_things, 0.9);
  EXPECT_LT(found.of_sky, kEdgesOfWood);
}

// Dark clouds that stand on the wood may be treated as it.
TEST(SurveySkyline, AWoodBeforeBrokenCloudsIsFound) {
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    const Found found =
        FoundIn(MapOf(WithWood(BrokenClouds(ClearSky(kHighSun, 0.1), seed))), IsWood);
    EXPECT_GT(found.of_things, 0.8) << seed;
    EXPECT_LT(found.of_sky, 0.01) << seed;
  }
}

TEST(SurveySkyline, AWoodInANoisyMapIsFoundAndTheNoiseIsNot) {
  const Found found = FoundIn(MapOf(WithWood(ClearSky(kHighSun, 0.1)), 0.15), IsWood);
  EXPECT_GT(found.of_things, 0.8);
  EXPECT_LT(found.of_sky, kEdgesOfWood);
  EXPECT_EQ(CountOf(FindHiddenSky(MapOf(ClearSky(kHighSun, 0.1), 0.3), UpperHalf())), 0);
}

TEST(SurveySkyline, BrokenCloudsHideNothing) {
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    const RgbImage map = MapOf(BrokenClouds(ClearSky(kHighSun, 0.1), seed));
    EXPECT_EQ(CountOf(FindHiddenSky(map, UpperHalf())), 0) << seed;
  }
}

TEST(SurveySkyline, DarkCloudsOfAnOvercastSkyHideNothing) {
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    const RgbImage map = MapOf([&](const glm::dvec3& direction) {
      // A factor of four between the darkest and the brightest.
      const double cloud = std::exp2(0.9 * Waves(2.0 * direction, seed));
      return cloud * OvercastSkyLuminance(direction) * glm::dvec3(0.95, 1.0, 1.1);
    });
    EXPECT_EQ(CountOf(FindHiddenSky(map, UpperHalf())), 0) << seed;
  }
}

TEST(SurveySkyline, ALowSunAndItsGlowHideNothing) {
  for (const double glare : {0.0, 30.0, 1000.0}) {
    for (const double depth : {0.0, 0.1, 0.6}) {
      const RgbImage map = MapOf(ClearSky(kLowSun, depth, glare));
      EXPECT_EQ(CountOf(FindHiddenSky(map, UpperHalf())), 0) << glare << " " << depth;
    }
  }
}

TEST(SurveySkyline, ASunsetsGradientHidesNothing) {
  const RgbImage map = MapOf([](const glm::dvec3& direction) {
    const double low = std::exp(-ElevationDeg(direction) / 6.0);
    const double to_west = 0.5 - 0.5 * direction.x;
    // The earth's shadow opposite, a glow in the west.
    return (0.2 + 3.0 * low * to_west * to_west) * glm::dvec3(1.0, 0.6, 0.4) +
           (1.0 - 0.6 * low) * glm::dvec3(0.2, 0.3, 0.6);
  });
  EXPECT_EQ(CountOf(FindHiddenSky(map, UpperHalf())), 0);
}

// A dark cloud with a perfectly sharp edge, or a balloon.
TEST(SurveySkyline, WhatStandsOnNothingHidesNothing) {
  const RadianceOf sky = ClearSky(kHighSun, 0.1);
  const RgbImage map = MapOf([&](const glm::dvec3& direction) {
    const double elevation = ElevationDeg(direction);
    const bool aloft = elevation > 20.0 && elevation < 30.0 && direction.y > 0.3;
    return aloft ? glm::dvec3(0.1) : sky(direction);
  });
  EXPECT_EQ(CountOf(FindHiddenSky(map, UpperHalf())), 0);
}

TEST(SurveySkyline, ATreeOverTheMeshIsFoundWhereTheMeshLeavesTheMapFree) {
  const RgbImage map = MapOf(WithWood(ClearSky(kHighSun, 0.1)));
  Gray8Image shows_sky = UpperHalf();
  int things = 0;
  for (int y = 0; y < kSize.height / 2; ++y) {
    for (int x = 0; x < kSize.width; ++x) {
      const glm::dvec3 direction = DirectionFromLatLong({x + 0.5, y + 0.5}, kSize);
      if (ElevationDeg(direction) < 4.0) shows_sky.At(x, y) = 0;
      const bool high = std::sin(RadFromDeg(9.0 * AzimuthDeg(direction))) > 0.3;
      things += shows_sky.At(x, y) != 0 && IsWood(direction) && high ? 1 : 0;
    }
  }
  const Gray8Image hidden = FindHiddenSky(map, shows_sky);
  EXPECT_GT(CountOf(hidden), 0.85 * things);
  for (std::size_t i = 0; i < hidden.pixels.size(); ++i) {
    ASSERT_TRUE(hidden.pixels[i] == 0 || shows_sky.pixels[i] != 0);
  }
}

TEST(SurveySkyline, AnEaveIsThePartOfTheMeshThatItIs) {
  const RadianceOf sky = ClearSky(kHighSun, 0.1);
  const RgbImage map = MapOf([&](const glm::dvec3& direction) {
    return ElevationDeg(direction) < 22.0 ? glm::dvec3(0.1) : sky(direction);
  });
  Gray8Image shows_sky = UpperHalf();
  for (int y = 0; y < kSize.height / 2; ++y) {
    for (int x = 0; x < kSize.width; ++x) {
      const glm::dvec3 direction = DirectionFromLatLong({x + 0.5, y + 0.5}, kSize);
      if (ElevationDeg(direction) < 20.0) shows_sky.At(x, y) = 0;
    }
  }
  EXPECT_EQ(CountOf(FindHiddenSky(map, shows_sky)), 0);
}

TEST(SurveySkyline, ABlackMapHidesNothing) {
  const RgbImage black(kSize.width, kSize.height, glm::vec3(0.0f));
  EXPECT_EQ(CountOf(FindHiddenSky(black, UpperHalf())), 0);
  EXPECT_TRUE(SkylineOf(black, Gray8Image(kSize.width, kSize.height, 0), {}).Empty());
}

TEST(SurveySkyline, ReflectsItsRadianceInTheMapOverTheSkysIrradiance) {
  const RgbImage map(kSize.width, kSize.height, glm::vec3(3.0f, 2.0f, 1.0f));
  Gray8Image hidden(kSize.width, kSize.height, 0);
  for (int y = 90; y < 128; ++y) {  // Below 26.7 deg.
    for (int x = 256; x < 512; ++x) hidden.At(x, y) = 255;
  }
  // No sky in the blue: nothing is reflected of it.
  const Skyline skyline = SkylineOf(map, hidden, {30.0, 10.0, 0.0});
  const auto cell = [](double x, double z) {
    return SkyTable::CellOf(glm::vec3(glm::dvec3(x, std::sqrt(1.0 - x * x - z * z), z)));
  };
  EXPECT_FLOAT_EQ(skyline.hidden[cell(0.5, 0.3)], 1.0f);
  EXPECT_LT(glm::distance(skyline.reflected[cell(0.5, 0.3)], glm::vec3(0.1f, 0.2f, 0.0f)), 1e-6f);
  EXPECT_FLOAT_EQ(skyline.hidden[cell(0.5, 0.002)], 1.0f) << "at the horizon";
  EXPECT_EQ(skyline.hidden[cell(0.5, 0.6)], 0.0f) << "above";
  EXPECT_EQ(skyline.hidden[cell(-0.5, 0.3)], 0.0f) << "beside";
}

// A street lamp before the night's sky: one ray that meets it must not outweigh all others.
TEST(SurveySkyline, ALampCountsAsAWhiteSurfaceInTheSun) {
  RgbImage map(kSize.width, kSize.height, glm::vec3(0.002f));
  Gray8Image hidden(kSize.width, kSize.height, 0);
  for (int y = 90; y < 128; ++y) {
    for (int x = 256; x < 512; ++x) hidden.At(x, y) = 255;
  }
  for (int y = 108; y < 112; ++y) {
    for (int x = 380; x < 386; ++x) map.At(x, y) = glm::vec3(60.0f);
  }
  const Skyline skyline = SkylineOf(map, hidden, glm::dvec3(0.01));
  float most = 0.0f;
  for (const glm::vec3& reflected : skyline.reflected) most = std::max(most, reflected.x);
  EXPECT_NEAR(most, 11.0 / std::numbers::pi, 1e-3);
}

// A ring of trees, 28 deg high, that reflect 2.5 % of the sky's irradiance a steradian.
constexpr double kRingDeg = 28.0;
constexpr double kRingReflects = 0.025;

// The known site with such a ring; `sky` is without.
KnownSite SiteInRing(const RgbImage& sky) {
  KnownSite site;
  site.sky = sky;
  const glm::vec3 irradiance(HorizontalIrradiance(sky));
  for (int y = 0; y < sky.height / 2; ++y) {
    for (int x = 0; x < sky.width; ++x) {
      const glm::dvec3 direction = DirectionFromLatLong({x + 0.5, y + 0.5}, KnownSite::kMapSize);
      if (ElevationDeg(direction) > kRingDeg) continue;
      site.sky.At(x, y) = static_cast<float>(kRingReflects) * irradiance;
    }
  }
  return site;
}

// The irradiance of an even sky that the ground says, by the model of `prepared`, when the site
// looks like `picture` under one.
double SkyIrradianceFrom(const PreparedScene& prepared, const RgbImage& picture) {
  SurfaceViewBuilder builder(prepared, {});
  Camera camera;
  camera.intrinsics = {
      .width_px = 8, .height_px = 8, .fx_px = 8.0, .fy_px = 8.0, .cx_px = 3.5, .cy_px = 3.5};
  const std::vector<std::shared_ptr<const SkyShape>> shapes{MakeUniformSkyShape()};
  builder.Update(camera, {0.0, 0.0, -1.0}, kMeanSunAngularRadiusRad, shapes, {});
  const SurfaceView& view = builder.SurveyUnderCurrentSun()->view;
  std::vector<double> irradiance;
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    if (view.may_be_sampled.pixels[i] == 0 || view.edge_distance_px.pixels[i] < 2.0f) continue;
    irradiance.push_back(std::numbers::pi * picture.pixels[i].y /
                         (view.albedo_rgb.pixels[i].y * view.sky_response[0].pixels[i].y));
  }
  return UpperMedian(std::move(irradiance));
}

// 3 %: rays of the picture, the survey and the view, and the ring's edge, a pixel of 1.4 deg of
// which half is counted as sky.
TEST(SurveySkyline, TheSkyBehindARingOfTreesIsRecovered) {
  const KnownSite surveyed = SiteInRing(TheKnownSite().sky);
  KeepsNothing store;
  PreparedScene prepared =
      PrepareScene(surveyed.Model(surveyed.Map()), KnownSite::Options(), store, {});
  ASSERT_TRUE(prepared.survey);
  ASSERT_FALSE(prepared.survey->skyline.Empty());
  const glm::dvec3 truth = HorizontalIrradiance(TheKnownSite().sky);
  const glm::dvec3& found = prepared.survey->light.sky_irradiance_rgb;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c] / truth[c], 1.0, 0.03) << c;

  RgbImage even = TheKnownSite().sky;
  for (glm::vec3& pixel : even.pixels) pixel = pixel.y > 0.0f ? glm::vec3(40.0f) : pixel;
  const RgbImage picture = SiteInRing(even).Map(false);
  const double irradiance = HorizontalIrradiance(even).y;
  EXPECT_NEAR(SkyIrradianceFrom(prepared, picture) / irradiance, 1.0, 0.03);

  // On open ground it is all one, whichever rays a receiver has.
  PatchScene open;
  open.skyline = prepared.survey->skyline;
  const std::vector<Receiver> ground(64);
  const auto even_sky = SeenPast(open.skyline, MakeUniformSkyShape());
  const GatheredRays rays(open, ground, {.rays_per_receiver = 128});
  const std::vector<glm::vec3> at_ground = rays.FromSky(*even_sky);
  for (const glm::vec3& value : at_ground) EXPECT_NEAR(value.x / at_ground[0].x, 1.0, 1e-5);

  // The mesh alone takes the trees for sky.
  prepared.survey->skyline = {};
  EXPECT_LT(SkyIrradianceFrom(prepared, picture) / irradiance, 0.9);
}

}  // namespace
}  // namespace pleinair::survey_skyline_test
