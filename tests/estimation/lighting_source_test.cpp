// Which light counts as known.
#include "estimation/lighting_source.h"

#include <cmath>

#include <gtest/gtest.h>

namespace pleinair::lighting_source_test {
namespace {

// A sun of 600 over a sky of 200 in two parts, whose parts of all nine differ from what is true by
// these, all at once.
Lighting OffBy(double sun, double first, double second) {
  Lighting lighting;
  lighting.sun.irradiance_rgb = glm::dvec3(600.0);
  lighting.sky = {{"uniform", glm::dvec3(150.0)}, {"clear", glm::dvec3(50.0)}};
  const double off[] = {sun, sun, sun, first, first, first, second, second, second};
  for (const double a : off) {
    for (const double b : off) lighting.covariance.push_back(a * b);
  }
  return lighting;
}

TEST(LightIsKnown, WhereTheSunIsKnownToAThirdOfAllLight) {
  EXPECT_TRUE(LightIsKnown(OffBy(260.0, 0.0, 0.0)));
  EXPECT_FALSE(LightIsKnown(OffBy(270.0, 0.0, 0.0)));
  EXPECT_TRUE(LightIsKnown(OffBy(0.0, 1500.0, 500.0)));
}

// What the albedos' scale makes of it says nothing of how sun and sky share the light.
TEST(LightIsKnown, WhateverItsScale) {
  Lighting lighting = OffBy(900.0, 225.0, 75.0);
  EXPECT_FALSE(LightIsKnown(lighting));
  lighting.common_stddev_rgb = glm::dvec3(1.5);
  EXPECT_TRUE(LightIsKnown(lighting));
  lighting = OffBy(std::hypot(900.0, 270.0), 225.0, 75.0);
  lighting.common_stddev_rgb = glm::dvec3(1.5);
  EXPECT_FALSE(LightIsKnown(lighting)) << "there is another error";
}

TEST(LightIsKnown, WhereItsSourceDoesNotDoubtItAndNotInDarkness) {
  Lighting lighting = OffBy(1.0, 0.0, 0.0);
  lighting.covariance.clear();
  EXPECT_TRUE(LightIsKnown(lighting));
  Lighting dark = OffBy(1.0, 0.0, 0.0);
  dark.sun.irradiance_rgb = glm::dvec3(0.0);
  dark.sky[0].irradiance_rgb = dark.sky[1].irradiance_rgb = glm::dvec3(0.0);
  EXPECT_FALSE(LightIsKnown(dark));
}

}  // namespace
}  // namespace pleinair::lighting_source_test
