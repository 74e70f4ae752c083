// Skies made with a sun that is complete, cut off, veiled or absent; and what looks like a sun.
#include "relight/survey/map_sun.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "relight/survey/internal/map_pixels.h"
#include "scene/image_io.h"
#include "scene/lat_long.h"
#include "scene/lighting.h"
#include "sunmodel/angles.h"
#include "sunmodel/north.h"

namespace pleinair::map_sun_test {
namespace {

constexpr LatLongSize kSize{1024, 512};
constexpr double kPixelDeg = 180.0 / kSize.height;

glm::dvec3 Direction(double azimuth_deg, double elevation_deg) {
  const double elevation = RadFromDeg(elevation_deg);
  return TurnedClockwise({0.0, std::cos(elevation), std::sin(elevation)}, RadFromDeg(azimuth_deg));
}

double AngleDeg(const glm::dvec3& a, const glm::dvec3& b) {
  return DegFromRad(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
}

template <typename RadianceAt>
RgbImage Map(const RadianceAt& radiance_at, LatLongSize size = kSize) {
  RgbImage map(size.width, size.height);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      map.At(x, y) = glm::vec3(float(radiance_at(MapPixelDirection(x, y, size))));
    }
  }
  return map;
}

// Overcast as Moon and Spencer have it: three times brighter above than at the horizon. Grey
// ground.
double Overcast(const glm::dvec3& direction) {
  return direction.z > 0.0 ? (1.0 + 2.0 * direction.z) / 3.0 : 0.2;
}

// Adds a disc of `irradiance` normal to its beam, spread evenly over `radius_deg`.
void AddDisc(const glm::dvec3& centre, double radius_deg, double irradiance, RgbImage& map) {
  const LatLongSize size{map.width, map.height};
  std::vector<MapPixel> pixels = MapPixelsAround(centre, RadFromDeg(radius_deg), size);
  if (pixels.empty()) {
    const glm::ivec2 at = LatLongPixelFromDirection(centre, size);
    pixels.push_back({at.x, at.y, 0.0});
  }
  double area_sr = 0.0;
  for (const MapPixel& pixel : pixels) area_sr += LatLongPixelSolidAngleSr(pixel.y, size);
  for (const MapPixel& pixel : pixels) {
    map.At(pixel.x, pixel.y) += glm::vec3(float(irradiance / area_sr));
  }
}

// A glow of Gaussian profile.
void AddGlow(const glm::dvec3& centre, double sigma_deg, double peak, RgbImage& map) {
  for (const MapPixel& pixel :
       MapPixelsAround(centre, RadFromDeg(6.0 * sigma_deg), {map.width, map.height})) {
    const double z = DegFromRad(pixel.angle_rad) / sigma_deg;
    map.At(pixel.x, pixel.y) += glm::vec3(float(peak * std::exp(-0.5 * z * z)));
  }
}

void Cut(float level, RgbImage& map) {
  for (glm::vec3& pixel : map.pixels) pixel = glm::min(pixel, glm::vec3(level));
}

// The sky's light on a horizontal plane is 7 pi / 9 = 2.44; a clear sun's some six times that.
constexpr double kClearSun = 15.0;

// The places where a lat-long map is awkward: its seam (south), near the zenith, at the horizon.
const std::vector<std::pair<double, double>> kPlaces = {
    {35.0, 40.0}, {179.9, 30.0}, {-179.9, 30.0}, {10.0, 89.0}, {250.0, 1.5}, {0.0, 7.9}};

void ExpectSun(const RgbImage& map, const glm::dvec3& sun, MapSunKind kind, double within_deg) {
  const std::optional<MapSun> found = FindMapSun(map);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->kind, kind);
  EXPECT_LT(AngleDeg(found->direction_enu, sun), within_deg);
  EXPECT_LE(AngleDeg(found->direction_enu, sun), DegFromRad(found->uncertain_rad));
}

TEST(MapSun, IsTheDiscWhereverItStands) {
  for (const auto& [azimuth_deg, elevation_deg] : kPlaces) {
    SCOPED_TRACE(std::to_string(azimuth_deg) + ", " + std::to_string(elevation_deg));
    const glm::dvec3 sun = Direction(azimuth_deg, elevation_deg);
    RgbImage map = Map(Overcast);
    AddDisc(sun, 0.27, kClearSun, map);
    ExpectSun(map, sun, MapSunKind::kDisc, kPixelDeg);
  }
}

// With its glare, cut at six times the sky, as a phone's panorama or a short bracket leaves it.
TEST(MapSun, IsTheMiddleOfWhatIsCutOff) {
  for (const auto& [azimuth_deg, elevation_deg] : kPlaces) {
    if (elevation_deg < 5.0) continue;  // Half the glare is under the horizon.
    SCOPED_TRACE(std::to_string(azimuth_deg) + ", " + std::to_string(elevation_deg));
    const glm::dvec3 sun = Direction(azimuth_deg, elevation_deg);
    RgbImage map = Map(Overcast);
    AddDisc(sun, 0.27, kClearSun, map);
    AddGlow(sun, 2.0, 12.0, map);
    AddGlow(sun, 6.0, 1.0, map);
    Cut(6.0f, map);
    ExpectSun(map, sun, MapSunKind::kGlow, 1.0);
  }
}

TEST(MapSun, IsASmallDiscCutAtOneLevel) {
  const glm::dvec3 sun = Direction(144.0, 52.6);
  RgbImage map = Map(Overcast);
  AddDisc(sun, 0.6, kClearSun, map);
  Cut(5.0f, map);
  ExpectSun(map, sun, MapSunKind::kFlatTop, 2.0 * kPixelDeg);
}

// The glare is cut at hardly more than the sky beside it: 5 degrees and more around are level.
TEST(MapSun, IsTheMiddleOfAWidePlateau) {
  for (const auto& [azimuth_deg, elevation_deg] : kPlaces) {
    if (elevation_deg < 20.0) continue;  // Half the glare is under the horizon.
    SCOPED_TRACE(std::to_string(azimuth_deg) + ", " + std::to_string(elevation_deg));
    const glm::dvec3 sun = Direction(azimuth_deg, elevation_deg);
    RgbImage map = Map([](const glm::dvec3& d) { return d.z > 0.0 ? 0.5 : 0.1; });
    AddDisc(sun, 0.27, kClearSun, map);
    AddGlow(sun, 3.0, 20.0, map);
    AddGlow(sun, 12.0, 2.0, map);
    Cut(3.0f, map);
    ExpectSun(map, sun, MapSunKind::kPlateau, 1.0);
    EXPECT_GT(ShareCutOff(map), 0.008);
  }
}

TEST(MapSun, IsNotAmongSeveralPlateaus) {
  RgbImage map = Map([](const glm::dvec3& d) { return d.z > 0.0 ? 0.5 : 0.1; });
  for (const double azimuth_deg : {0.0, 60.0, 200.0}) {
    AddGlow(Direction(azimuth_deg, 40.0), 4.0, 6.0, map);
  }
  Cut(2.0f, map);
  EXPECT_FALSE(FindMapSun(map));
  EXPECT_GT(ShareCutOff(map), 0.02);
  EXPECT_EQ(ShareCutOff(Map(Overcast)), 0.0);
  EXPECT_EQ(ShareCutOff(RgbImage(64, 32, glm::vec3(1.0f))), 0.0) << "an evenly white sky";
}

// Behind thin cloud the disc itself is gone.
TEST(MapSun, IsTheMiddleOfItsGlowBehindThinCloud) {
  for (const double sigma_deg : {1.0, 2.0, 3.0}) {
    SCOPED_TRACE(sigma_deg);
    const glm::dvec3 sun = Direction(-160.0, 25.0);
    RgbImage map = Map(Overcast);
    AddGlow(sun, sigma_deg, 60.0 / (sigma_deg * sigma_deg), map);
    AddGlow(sun, 4.0 * sigma_deg, 0.8, map);
    ExpectSun(map, sun, MapSunKind::kGlow, 1.0);
  }
}

TEST(MapSun, IsNotInAnOvercastSky) {
  EXPECT_FALSE(FindMapSun(Map(Overcast)));
  // Noise of 2 %, and the bright part of the clouds that the sun is behind.
  std::mt19937 random(3);
  std::normal_distribution<double> noise(1.0, 0.02);
  for (const double sigma_deg : {6.0, 12.0, 30.0}) {
    RgbImage map = Map([&](const glm::dvec3& d) { return noise(random) * Overcast(d); });
    AddGlow(Direction(120.0, 30.0), sigma_deg, 1.5, map);
    EXPECT_FALSE(FindMapSun(map)) << sigma_deg;
  }
}

// Ragged patches up to four times the sky's radiance, the brightest of them cut off.
TEST(MapSun, IsNotAmongCloudsThatHideIt) {
  for (const float cut : {1e3f, 2.5f}) {
    RgbImage map = Map([](const glm::dvec3& d) {
      const double wave =
          std::sin(9.0 * d.x + 2.0) * std::sin(11.0 * d.y) + 0.6 * std::sin(31.0 * d.z);
      return d.z > 0.0 ? 0.6 + 2.0 * std::max(wave, 0.0) : 0.2;
    });
    Cut(cut, map);
    EXPECT_FALSE(FindMapSun(map)) << cut;
  }
}

// A lamp has 6 % of a room's light; a window ends where a glow would go on.
TEST(MapSun, IsNotALampOrAWindow) {
  const auto room = [](const glm::dvec3& d) { return d.z > 0.0 ? 0.3 : 0.2; };
  RgbImage lamp = Map(room);
  AddDisc(Direction(190.0, 28.0), 0.4, 0.06, lamp);
  EXPECT_FALSE(FindMapSun(lamp));
  RgbImage bright_lamp = Map(room);
  AddDisc(Direction(190.0, 28.0), 0.6, 0.02, bright_lamp);
  AddGlow(Direction(190.0, 28.0), 1.5, 1.0, bright_lamp);
  Cut(60.0f, bright_lamp);
  EXPECT_FALSE(FindMapSun(bright_lamp)) << "even, with a halo";
  RgbImage lamps = Map(room);
  for (const double azimuth_deg : {10.0, 130.0, 250.0}) {
    AddDisc(Direction(azimuth_deg, 45.0), 0.6, 1.0, lamps);
  }
  Cut(20.0f, lamps);
  EXPECT_FALSE(FindMapSun(lamps)) << "several, cut at one level";
  const auto with_window = [&](const glm::dvec3& d) {
    const double azimuth_deg = DegFromRad(std::atan2(d.x, d.y));
    const double elevation_deg = DegFromRad(std::asin(d.z));
    return std::abs(azimuth_deg - 40.0) < 3.5 && std::abs(elevation_deg - 20.0) < 3.0 ? 25.0
                                                                                      : room(d);
  };
  EXPECT_FALSE(FindMapSun(Map(with_window)));
}

TEST(MapSunHardCases, BlackFlatAndTinyMapsHaveNone) {
  EXPECT_FALSE(FindMapSun(RgbImage(64, 32, glm::vec3(0.0f))));
  EXPECT_FALSE(FindMapSun(RgbImage(64, 32, glm::vec3(1e30f))));
  EXPECT_FALSE(FindMapSun(RgbImage(16, 8, glm::vec3(1.0f))));
  EXPECT_FALSE(FindMapSun(RgbImage()));
}

TEST(MapSunHardCases, ADiscIsFoundInMapsOfAnySize) {
  for (const LatLongSize size :
       {LatLongSize{64, 32}, LatLongSize{256, 128}, LatLongSize{2048, 1024}}) {
    const glm::dvec3 sun = Direction(77.0, 33.0);
    RgbImage map = Map(Overcast, size);
    AddDisc(sun, 0.27, kClearSun, map);
    ExpectSun(map, sun, MapSunKind::kDisc, 180.0 / size.height);
  }
}

TEST(MapSunHardCases, ASunUnderTheHorizonIsNone) {
  RgbImage map = Map(Overcast);
  AddDisc(Direction(200.0, -20.0), 0.27, kClearSun, map);
  EXPECT_FALSE(FindMapSun(map)) << "a mirror image in water";
}

// Real panoramas as they are, and cut at 20 times and less the sky's 99th percentile.
TEST(MapSunOfPanoramas, IsFoundWhereThereIsOneAndNotWhereThereIsNone) {
  const std::filesystem::path folder =
      std::filesystem::path(PLEINAIR_SHARED_DIR) / "data/hdr_panoramas";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << folder << " is absent";
  struct Case {
    const char* name;
    std::optional<glm::dvec3> sun;  // The brightest pixel, by eye the disc.
  };
  for (const Case& panorama : {Case{"kloofendal_48d_partly_cloudy", Direction(34.3, 48.0)},
                               Case{"kloppenheim_05", Direction(36.0, 74.7)},
                               Case{"modern_buildings_2", Direction(36.4, 33.9)},
                               Case{"spruit_sunrise", Direction(35.7, 7.9)},
                               Case{"potsdamer_platz", std::nullopt},
                               Case{"lebombo", std::nullopt},
                               Case{"blouberg_sunrise_2", std::nullopt},
                               Case{"st_fagans_interior", std::nullopt}}) {
    SCOPED_TRACE(panorama.name);
    RgbImage map = ReadRadianceImage(folder / (panorama.name + std::string("_1k.hdr")));
    const std::optional<MapSun> whole = FindMapSun(map);
    ASSERT_EQ(whole.has_value(), panorama.sun.has_value());
    std::vector<float> sky;
    for (std::size_t i = 0; i < map.pixels.size() / 2; ++i) {
      sky.push_back(std::max({map.pixels[i].x, map.pixels[i].y, map.pixels[i].z}));
    }
    const auto rank = sky.begin() + static_cast<std::ptrdiff_t>(0.99 * double(sky.size()));
    std::nth_element(sky.begin(), rank, sky.end());
    for (const float times : {20.0f, 6.0f, 3.0f, 1.5f, 1.0f}) {
      SCOPED_TRACE(times);
      Cut(times * *rank, map);
      const std::optional<MapSun> cut = FindMapSun(map);
      // A low sun's plateau ends at the horizon, and is no longer round.
      const bool is_lost = panorama.sun && panorama.sun->z < 0.2 && times < 3.0f;
      ASSERT_EQ(cut.has_value(), panorama.sun.has_value() && !is_lost);
      if (!cut) continue;
      EXPECT_LE(AngleDeg(cut->direction_enu, *panorama.sun), times < 3.0f ? 2.7 : 2.0);
      EXPECT_LE(AngleDeg(cut->direction_enu, *panorama.sun), DegFromRad(cut->uncertain_rad));
    }
    if (!panorama.sun) continue;
    EXPECT_EQ(whole->kind, MapSunKind::kDisc);
    EXPECT_LT(AngleDeg(whole->direction_enu, *panorama.sun), 2.0 * kPixelDeg);
  }
}

}  // namespace
}  // namespace pleinair::map_sun_test
