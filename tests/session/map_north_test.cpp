#include "session/map_north.h"

#include <cmath>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "pipeline/sun_state.h"
#include "scene/image_io.h"
#include "scene/lat_long.h"
#include "sunmodel/angles.h"
#include "sunmodel/north.h"
#include "sunmodel/time_text.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::map_north_test {
namespace {

// A place at a time with the sun 45 degrees high, and a map whose model is turned.
class TurnedModel : public testing::Test {
 protected:
  void SetUp() override {
    sequence_.folder = folder_.Path();
    sequence_.site = Site{.latitude_rad = RadFromDeg(50.0), .longitude_rad = RadFromDeg(8.0)};
    EnvironmentEntry& map = sequence_.environment.emplace();
    map.image = "map.exr";
    map.time = ParseUtcTime("2026-06-21T08:40:00Z");
  }

  void WriteMap(double north_deg, double raised_deg = 0.0) {
    const glm::dvec3 computed =
        SunOverSite(*sequence_.site, sequence_.environment->time).direction_enu;
    glm::dvec3 shown = TurnedClockwise(computed, -RadFromDeg(north_deg));
    const double height_rad = std::asin(shown.z) + RadFromDeg(raised_deg);
    const glm::dvec2 level = glm::normalize(glm::dvec2(shown)) * std::cos(height_rad);
    shown = {level, std::sin(height_rad)};
    constexpr LatLongSize kSize{512, 256};
    RgbImage map(kSize.width, kSize.height, glm::vec3(0.1f));
    for (int y = 0; y < kSize.height / 2; ++y) {
      for (int x = 0; x < kSize.width; ++x) map.At(x, y) = glm::vec3(0.5f);
    }
    const glm::ivec2 sun = LatLongPixelFromDirection(shown, kSize);
    map.At(sun.x, sun.y) = glm::vec3(1e5f);
    WriteExr(folder_.Path() / "map.exr", map, ExrPrecision::kFloat);
  }

  TemporaryFolder folder_;
  Sequence sequence_;
};

TEST_F(TurnedModel, HasTheNorthThatItsMapShows) {
  for (const double north_deg : {5.0, 20.0, -130.0, 179.0}) {
    WriteMap(north_deg);
    const auto north = NorthOfMap(sequence_);
    ASSERT_TRUE(north) << north_deg;
    const double error_rad =
        std::remainder(north->azimuth_rad - RadFromDeg(north_deg), RadFromDeg(360.0));
    EXPECT_LT(std::abs(error_rad), RadFromDeg(0.6)) << north_deg;
    EXPECT_LT(std::abs(error_rad), north->stddev_rad);
    EXPECT_LT(north->stddev_rad, RadFromDeg(1.5));
  }
}

// Such a map may have been turned to true north, whatever the model's is.
TEST_F(TurnedModel, IsNotFoundWhereTheMapStandsToTrueNorth) {
  WriteMap(1.0);
  EXPECT_FALSE(NorthOfMap(sequence_));
}

TEST_F(TurnedModel, IsNotFoundWhereTheMapsSunIsAtAnotherHeight) {
  WriteMap(20.0, 10.0);
  EXPECT_FALSE(NorthOfMap(sequence_)) << "the time is wrong";
}

TEST_F(TurnedModel, IsNotFoundWithoutASunAPlaceOrAMap) {
  WriteMap(20.0);
  const Sequence good = sequence_;
  sequence_.environment->sun_direction_enu = glm::dvec3(0.0, 0.0, 1.0);
  EXPECT_FALSE(NorthOfMap(sequence_)) << "it is stated in the model's frame";
  sequence_ = good;
  sequence_.site.reset();
  EXPECT_FALSE(NorthOfMap(sequence_));
  sequence_ = good;
  sequence_.environment.reset();
  EXPECT_FALSE(NorthOfMap(sequence_));
  sequence_ = good;
  WriteExr(folder_.Path() / "map.exr", RgbImage(512, 256, glm::vec3(0.5f)), ExrPrecision::kFloat);
  EXPECT_FALSE(NorthOfMap(sequence_)) << "overcast";
}

}  // namespace
}  // namespace pleinair::map_north_test
