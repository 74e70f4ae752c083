#include "sunmodel/local_frame.h"

#include <cmath>

#include <gtest/gtest.h>

#include "sunmodel/angles.h"

namespace pleinair::local_frame_test {
namespace {

const Site kOrigin{RadFromDeg(45.0), RadFromDeg(10.0), 100.0};

// WGS84's radii of curvature at 45 degrees: 6 367 381.8 m along the meridian, 6 388 838.3 m across
// it; 100 m are added.
TEST(LocalFrame, HasTheEllipsoidsRadii) {
  const glm::dvec3 north = EnuOf({RadFromDeg(45.001), RadFromDeg(10.0), 100.0}, kOrigin);
  EXPECT_NEAR(north.y, RadFromDeg(0.001) * 6367481.8, 1e-3);
  EXPECT_NEAR(north.x, 0.0, 1e-9);
  const glm::dvec3 east = EnuOf({RadFromDeg(45.0), RadFromDeg(10.001), 100.0}, kOrigin);
  EXPECT_NEAR(east.x, RadFromDeg(0.001) * 6388938.3 * std::sqrt(0.5), 1e-3);
  EXPECT_NEAR(EnuOf({kOrigin.latitude_rad, kOrigin.longitude_rad, 130.0}, kOrigin).z, 30.0, 1e-9);
}

TEST(LocalFrame, ThereAndBackIsTheSame) {
  const glm::dvec3 enu(1200.0, -3400.0, 56.0);
  const glm::dvec3 back = EnuOf(PlaceAt(enu, kOrigin), kOrigin);
  EXPECT_NEAR(back.x, enu.x, 1e-6);
  EXPECT_NEAR(back.y, enu.y, 1e-6);
  EXPECT_NEAR(back.z, enu.z, 1e-6);
}

TEST(LocalFrame, RefusesABadPlace) {
  EXPECT_THROW(EnuOf({2.0, 0.0, 0.0}, kOrigin), std::invalid_argument);
  EXPECT_THROW(PlaceAt({}, {NAN, 0.0, 0.0}), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::local_frame_test
