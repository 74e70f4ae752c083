#include "estimation/fisheye_sky.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "scene/angle_between.h"
#include "tests/estimation/synthetic_fisheye.h"
#include "tests/scene/region_light.h"

namespace pleinair::fisheye_sky_test {
namespace {

using testing::FisheyePicture;
using testing::MakeFisheyePicture;
using testing::SkyCamera;

constexpr double kSunRadius = kMeanSunAngularRadiusRad;

FisheyeSky ReadPicture(const FisheyePicture& picture, const RgbImage& radiance) {
  FisheyeSky sky(SkyCamera(picture.side_px), SkyRegions());
  sky.Read(radiance, picture.sun_direction_enu, kSunRadius);
  return sky;
}

// 1 %: pixels on a region's border.
TEST(FisheyeSky, AveragesEachRegionOverItsSolidAngle) {
  FisheyePicture picture;
  picture.sun_radiance = glm::dvec3(0.0);
  const FisheyeSky sky = ReadPicture(picture, MakeFisheyePicture(picture));
  const SkyRegions regions;
  for (std::size_t region = 0; region < regions.Count(); ++region) {
    glm::dvec3 mean(0.0);
    constexpr int kSide = 32;
    for (int i = 0; i < kSide * kSide; ++i) {
      const int row = i / kSide;
      const glm::dvec2 point((i % kSide + 0.5) / kSide, (row + 0.5) / kSide);
      mean += picture.Sky(regions.DirectionIn(region, point)) / double{kSide * kSide};
    }
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(sky.RegionRadiance()[region][c], mean[c], 0.01 * mean[c]) << region;
    }
  }
}

// 2 %: the disc is 1.5 pixels wide, its picture has 16 samples along a pixel's side.
TEST(FisheyeSky, MeasuresTheDiscAboveTheSkyAroundIt) {
  for (const double elevation_deg : {12.0, 35.0, 63.0, 88.0}) {
    FisheyePicture picture;
    picture.PutSunAt(140.0, elevation_deg);
    const FisheyeSky sky = ReadPicture(picture, MakeFisheyePicture(picture));
    const double disc_sr = std::numbers::pi * kSunRadius * kSunRadius;
    for (int c = 0; c < 3; ++c) {
      const double expected = disc_sr * picture.sun_radiance[c];
      EXPECT_NEAR(sky.Sun().irradiance_rgb[c], expected, 0.02 * expected) << elevation_deg;
    }
    EXPECT_FALSE(sky.Sun().clipped);
  }
}

TEST(FisheyeSky, WithoutADiscTheSunIsZero) {
  FisheyePicture picture;
  picture.sun_radiance = glm::dvec3(0.0);
  const FisheyeSky sky = ReadPicture(picture, MakeFisheyePicture(picture));
  EXPECT_EQ(sky.Sun().irradiance_rgb, glm::dvec3(0.0));
  EXPECT_FALSE(sky.Sun().clipped);
}

// The disc itself would double the sky's irradiance.
TEST(FisheyeSky, TheDiscIsNotInTheSky) {
  FisheyePicture with;
  FisheyePicture without;
  without.sun_radiance = glm::dvec3(0.0);
  const FisheyeSky sky = ReadPicture(with, MakeFisheyePicture(with));
  const FisheyeSky expected = ReadPicture(without, MakeFisheyePicture(without));
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(sky.SkyIrradianceRgb()[c],
                expected.SkyIrradianceRgb()[c],
                1e-3 * expected.SkyIrradianceRgb()[c]);
  }
  for (std::size_t region = 0; region < sky.RegionRadiance().size(); ++region) {
    EXPECT_NEAR(sky.RegionRadiance()[region].y,
                expected.RegionRadiance()[region].y,
                1e-3 * expected.RegionRadiance()[region].y);
  }
}

// An image of the model at the shape's own cells is the model; between cells a few per cent.
TEST(FisheyeSky, TheShapeIsThePicturesOwn) {
  FisheyePicture picture;
  const FisheyeSky sky = ReadPicture(picture, MakeFisheyePicture(picture));
  const auto shape = sky.Shape();
  for (double azimuth = 5.0; azimuth < 360.0; azimuth += 40.0) {
    const glm::dvec3 direction = testing::DirectionEnu(azimuth, 25.0);
    const glm::dvec3 radiance =
        glm::dvec3(shape->Radiance(glm::vec3(direction))) * sky.SkyIrradianceRgb();
    EXPECT_NEAR(radiance.y, picture.Sky(direction).y, 0.03 * picture.Sky(direction).y);
  }
}

// grosch-2007's sky: within a region every direction is alike, and the regions' light adds up.
TEST(FisheyeSky, TheShapeMayBeThatOfTheRegionsAlone) {
  FisheyePicture picture;
  const SkyRegions regions;
  FisheyeSky sky(testing::SkyCamera(picture.side_px), regions, SkyDetail::kRegions);
  sky.Read(MakeFisheyePicture(picture), picture.sun_direction_enu, kSunRadius);
  glm::dvec3 horizontal(0.0);
  for (std::size_t region = 0; region < regions.Count(); ++region) {
    const glm::dvec3& mean = sky.RegionRadiance()[region];
    horizontal += HorizontalIrradiance(regions, region) * mean;
    for (const glm::dvec2 point : {glm::dvec2(0.2, 0.5), glm::dvec2(0.8, 0.7)}) {
      const glm::dvec3 radiance =
          glm::dvec3(sky.Shape()->Radiance(glm::vec3(regions.DirectionIn(region, point)))) *
          sky.SkyIrradianceRgb();
      // Single precision of the shape's scale.
      EXPECT_NEAR(radiance.y, mean.y, 1e-5 * mean.y) << "region " << region;
    }
  }
  // A cell of the shape's table at a region's edge belongs to one of the two.
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(sky.SkyIrradianceRgb()[c], horizontal[c], 2e-3 * horizontal[c]);
  }
}

// So that nothing is recomputed for it.
TEST(FisheyeSky, KeepsItsShapeWhileTheSkyStaysTheSame) {
  FisheyePicture picture;
  const RgbImage radiance = MakeFisheyePicture(picture);
  FisheyeSky sky = ReadPicture(picture, radiance);
  const auto shape = sky.Shape();
  sky.Read(radiance, picture.sun_direction_enu, kSunRadius);
  EXPECT_EQ(sky.Shape(), shape);
  RgbImage brighter = radiance;
  for (glm::vec3& pixel : brighter.pixels) pixel *= 1.5f;
  sky.Read(brighter, picture.sun_direction_enu, kSunRadius);
  EXPECT_NE(sky.Shape(), shape);
}

// A lens spreads a twentieth of the disc over 4 degrees, 30 to 2000 times as bright as the sky.
TEST(FisheyeSkyHardCases, GlareIsTheSunsAndNotTheSkys) {
  FisheyePicture picture;
  RgbImage radiance = MakeFisheyePicture(picture);
  const FisheyeSky clean = ReadPicture(picture, radiance);
  const FisheyeCamera camera = SkyCamera(picture.side_px);
  const FisheyeLens lens(camera.intrinsics);
  const double disc = 1.1e7 * std::numbers::pi * kSunRadius * kSunRadius;
  const double falls_off_rad = 0.01;
  double added = 0.0;
  for (int y = 0; y < radiance.height; ++y) {
    for (int x = 0; x < radiance.width; ++x) {
      const auto direction = lens.DirectionFromPixel({x, y});
      if (!direction) continue;
      const double angle_rad =
          AngleBetweenRad(camera.world_from_camera * *direction, picture.sun_direction_enu);
      const double glare = 0.05 * disc * std::exp(-angle_rad / falls_off_rad) /
                           (2.0 * std::numbers::pi * falls_off_rad * falls_off_rad);
      radiance.At(x, y) += glm::vec3(static_cast<float>(glare));
      added += glare * lens.PixelSolidAngleSr({x, y});
    }
  }
  const FisheyeSky sky = ReadPicture(picture, radiance);
  EXPECT_NEAR(
      sky.SkyIrradianceRgb().y, clean.SkyIrradianceRgb().y, 0.01 * clean.SkyIrradianceRgb().y);
  EXPECT_NEAR(sky.Sun().irradiance_rgb.y, clean.Sun().irradiance_rgb.y + added, 0.01 * disc);
  EXPECT_LT(std::abs(sky.Sun().irradiance_rgb.y - clean.Sun().irradiance_rgb.y - added),
            sky.Sun().stddev_rgb.y);
  // Nothing is left that a single ray could hit.
  float brightest = 0.0f;
  for (double azimuth = 150.0; azimuth < 170.0; azimuth += 0.2) {
    for (double elevation = 30.0; elevation < 50.0; elevation += 0.2) {
      const glm::vec3 direction(testing::DirectionEnu(azimuth, elevation));
      brightest = std::max(brightest, sky.Shape()->Radiance(direction).y);
    }
  }
  const glm::dvec3 towards = testing::DirectionEnu(160.0, 40.0);
  EXPECT_LT(brightest * sky.SkyIrradianceRgb().y, 2.5 * picture.Sky(towards).y);
}

// Whatever the lens makes of the disc, its light is the sun's: to 1 % of sun and sky. A blur of a
// degree may be an aureole of up to ten times the sky: 6 % of the sun.
TEST(FisheyeSkyHardCases, LosesNoLightBetweenSunAndSky) {
  for (const double spread_px : {0.0, 1.0, 2.0, 3.0}) {
    FisheyePicture picture;
    picture.spread_px = spread_px;
    const FisheyeSky with = ReadPicture(picture, MakeFisheyePicture(picture));
    const double disc = picture.sun_radiance.y * std::numbers::pi * kSunRadius * kSunRadius;
    EXPECT_NEAR(with.Sun().irradiance_rgb.y, disc, 0.01 * disc) << spread_px;
    EXPECT_LT(with.Sun().stddev_rgb.y, 0.08 * disc) << spread_px;
    picture.sun_radiance = glm::dvec3(0.0);
    const FisheyeSky without = ReadPicture(picture, MakeFisheyePicture(picture));
    EXPECT_NEAR(with.SkyIrradianceRgb().y,
                without.SkyIrradianceRgb().y,
                0.01 * without.SkyIrradianceRgb().y)
        << spread_px;
  }
}

// Where it is looked for there is only the slope of its glare.
TEST(FisheyeSkyHardCases, ASunAFewDegreesOffIsNotTakenForItsSlope) {
  for (const double spread_px : {0.0, 2.0, 4.0}) {
    for (const double off_deg : {3.0, 4.0, 5.0, 8.0}) {
      FisheyePicture picture;
      picture.spread_px = spread_px;
      picture.PutSunAt(160.0, 40.0);
      const RgbImage radiance = MakeFisheyePicture(picture);
      const double shown = ReadPicture(picture, radiance).Sun().irradiance_rgb.y;
      picture.PutSunAt(160.0, 40.0 + off_deg);
      const SunDiscReading sun = ReadPicture(picture, radiance).Sun();
      // A pixel is 0.35 deg: a blurred disc reaches into where it is looked for.
      if (off_deg > 2.5 + 2.0 * 0.35 * spread_px) {
        EXPECT_TRUE(sun.elsewhere_enu) << spread_px << " " << off_deg;
      }
      EXPECT_NEAR(sun.irradiance_rgb.y, shown, 1e-2 * shown) << spread_px << " " << off_deg;
    }
  }
}

// A camera that is turned, or another lens: the disc's strength is right all the same, and the sky
// is the same object from picture to picture.
TEST(FisheyeSkyHardCases, ASunThatIsNotWhereItShouldBeIsFoundAndSaid) {
  FisheyePicture picture;
  const RgbImage radiance = MakeFisheyePicture(picture);
  const FisheyeSky right = ReadPicture(picture, radiance);
  EXPECT_FALSE(right.Sun().elsewhere_enu);
  const glm::dvec3 shown = picture.sun_direction_enu;
  picture.PutSunAt(250.0, 30.0);
  FisheyeSky wrong = ReadPicture(picture, radiance);
  ASSERT_TRUE(wrong.Sun().elsewhere_enu);
  EXPECT_LT(AngleBetweenRad(*wrong.Sun().elsewhere_enu, shown), 0.01);
  EXPECT_NEAR(wrong.Sun().irradiance_rgb.y,
              right.Sun().irradiance_rgb.y,
              1e-3 * right.Sun().irradiance_rgb.y);
  EXPECT_NEAR(
      wrong.SkyIrradianceRgb().y, right.SkyIrradianceRgb().y, 1e-3 * right.SkyIrradianceRgb().y);
}

// A lamp, the sun in a window, and a disc that a cloud all but hides, are none.
TEST(FisheyeSkyHardCases, AFaintSpotElsewhereIsNoSun) {
  FisheyePicture picture;
  picture.sun_radiance = glm::dvec3(7e5);  // Half of the sky's light.
  const RgbImage radiance = MakeFisheyePicture(picture);
  picture.PutSunAt(250.0, 30.0);
  const FisheyeSky sky = ReadPicture(picture, radiance);
  EXPECT_FALSE(sky.Sun().elsewhere_enu);
  EXPECT_EQ(sky.Sun().irradiance_rgb, glm::dvec3(0.0));
}

// Blown out around the sun, at hardly more than the sky: what the disc holds is not known.
TEST(FisheyeSkyHardCases, ASkyThatIsBlownOutHasAClippedSun) {
  FisheyePicture picture;
  picture.spread_px = 6.0;
  RgbImage radiance = MakeFisheyePicture(picture);
  for (glm::vec3& pixel : radiance.pixels) pixel = glm::min(pixel, glm::vec3(80.0f));
  EXPECT_TRUE(ReadPicture(picture, radiance).Sun().clipped);
  // Nor where all of the sky is white.
  for (glm::vec3& pixel : radiance.pixels) pixel = glm::min(pixel, glm::vec3(15.0f));
  EXPECT_TRUE(ReadPicture(picture, radiance).Sun().clipped);
  // A bright cloud there is not level.
  picture.sun_radiance = glm::dvec3(4e4);
  EXPECT_FALSE(ReadPicture(picture, MakeFisheyePicture(picture)).Sun().clipped);
}

// Cut off at a level that the disc passes and the sky does not: the flat top is wider than a disc
// once the lens has spread the light.
TEST(FisheyeSkyHardCases, SaysThatTheDiscIsClipped) {
  FisheyePicture picture;
  picture.spread_px = 2.0;
  RgbImage radiance = MakeFisheyePicture(picture);
  for (glm::vec3& pixel : radiance.pixels) pixel = glm::min(pixel, glm::vec3(200.0f));
  const FisheyeSky sky = ReadPicture(picture, radiance);
  EXPECT_TRUE(sky.Sun().clipped);
  const double disc_sr = std::numbers::pi * kSunRadius * kSunRadius;
  EXPECT_LT(sky.Sun().irradiance_rgb.y, 0.1 * disc_sr * picture.sun_radiance.y);
}

// Half floats end at 65504: a sun beyond is infinite in such a file.
TEST(FisheyeSkyHardCases, ASunBeyondTheFilesNumbersIsClipped) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  FisheyePicture picture;
  RgbImage radiance = MakeFisheyePicture(picture);
  const FisheyeSky whole = ReadPicture(picture, radiance);
  for (glm::vec3& pixel : radiance.pixels) {
    if (pixel.y > 65504.0f) pixel = glm::vec3(kInfinity);
  }
  const FisheyeSky sky = ReadPicture(picture, radiance);
  EXPECT_TRUE(sky.Sun().clipped);
  EXPECT_EQ(sky.Sun().irradiance_rgb, glm::dvec3(0.0));  // No bound is known.
  EXPECT_NEAR(
      sky.SkyIrradianceRgb().y, whole.SkyIrradianceRgb().y, 0.01 * whole.SkyIrradianceRgb().y);
  // A hot pixel elsewhere does not make the sun doubtful.
  RgbImage hot = MakeFisheyePicture(picture);
  hot.At(200, 300) = glm::vec3(kInfinity);
  EXPECT_FALSE(ReadPicture(picture, hot).Sun().clipped);
}

// Cut off so low that the lens has not spread it: a sharp disc of two by two pixels.
TEST(FisheyeSkyHardCases, ADiscOfFourLevelPixelsIsClipped) {
  for (const float limit : {150.0f, 3000.0f}) {
    FisheyePicture picture;
    picture.side_px = 512;
    RgbImage radiance = MakeFisheyePicture(picture);
    const FisheyeLens lens(SkyCamera(picture.side_px).intrinsics);
    const auto at = lens.ProjectToPixel(
        glm::transpose(SkyCamera(picture.side_px).world_from_camera) * picture.sun_direction_enu);
    for (int i = 0; i < 4; ++i) {
      radiance.At(static_cast<int>(at->x) + i % 2, static_cast<int>(at->y) + i / 2) =
          glm::vec3(1e6f);
    }
    for (glm::vec3& pixel : radiance.pixels) pixel = glm::min(pixel, glm::vec3(limit));
    EXPECT_TRUE(ReadPicture(picture, radiance).Sun().clipped) << limit;
  }
}

// Water on the dome: no disc is left, and the light around its place is the sun's.
TEST(FisheyeSkyHardCases, ASunThatWaterSpreadsIsStillTheSun) {
  FisheyePicture picture;
  const FisheyeSky sharp = ReadPicture(picture, MakeFisheyePicture(picture));
  picture.spread_px = 8.0;
  const FisheyeSky spread = ReadPicture(picture, MakeFisheyePicture(picture));
  EXPECT_NEAR(spread.Sun().irradiance_rgb.y,
              sharp.Sun().irradiance_rgb.y,
              0.2 * sharp.Sun().irradiance_rgb.y);
  EXPECT_NEAR(
      spread.SkyIrradianceRgb().y, sharp.SkyIrradianceRgb().y, 0.15 * sharp.SkyIrradianceRgb().y);
}

TEST(FisheyeSkyHardCases, LeavesDefectsOut) {
  FisheyePicture picture;
  const RgbImage clean = MakeFisheyePicture(picture);
  RgbImage dirty = clean;
  for (std::size_t i = 0; i < dirty.pixels.size(); i += 37) {
    dirty.pixels[i] = i % 2 == 0 ? glm::vec3(std::numeric_limits<float>::quiet_NaN())
                                 : glm::vec3(-1.0f, 1.0f, 1.0f);
  }
  const FisheyeSky sky = ReadPicture(picture, dirty);
  const FisheyeSky expected = ReadPicture(picture, clean);
  for (std::size_t region = 0; region < sky.RegionRadiance().size(); ++region) {
    const double value = sky.RegionRadiance()[region].y;
    EXPECT_NEAR(value, expected.RegionRadiance()[region].y, 0.02 * value);
  }
}

TEST(FisheyeSkyHardCases, TheSunBelowTheHorizonAndABlackPictureAreZero) {
  FisheyePicture picture;
  picture.PutSunAt(100.0, -3.0);
  picture.sun_radiance = glm::dvec3(0.0);
  const FisheyeSky set = ReadPicture(picture, MakeFisheyePicture(picture));
  EXPECT_EQ(set.Sun().irradiance_rgb, glm::dvec3(0.0));
  const FisheyeSky black =
      ReadPicture(picture, RgbImage(picture.side_px, picture.side_px, glm::vec3(0.0f)));
  EXPECT_EQ(black.SkyIrradianceRgb(), glm::dvec3(0.0));
  EXPECT_EQ(black.Shape()->Radiance({0.0f, 0.0f, 1.0f}), glm::vec3(0.0f));
}

TEST(FisheyeSkyHardCases, RefusesAPictureOfAnotherSize) {
  FisheyeSky sky(SkyCamera(64), SkyRegions());
  EXPECT_THROW(sky.Read(RgbImage(32, 64), {0.0, 0.0, 1.0}, kSunRadius), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::fisheye_sky_test
