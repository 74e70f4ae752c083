// Which light counts as known.
#include "estimation/lighting_source.h"

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
  // (1 - 600 / 800) of what the sun is off by, and its whole share of what the sky is off by.
  EXPECT_TRUE(LightIsKnown(OffBy(1000.0, 0.0, 0.0)));
  EXPECT_FALSE(LightIsKnown(OffBy(1100.0, 0.0, 0.0)));
  EXPECT_TRUE(LightIsKnown(OffBy(0.0, 200.0, 150.0)));
  EXPECT_FALSE(LightIsKnown(OffBy(0.0, 200.0, 160.0)));
  // Sun taken for sky.
  EXPECT_TRUE(LightIsKnown(OffBy(260.0, -160.0, -100.0)));
  EXPECT_FALSE(LightIsKnown(OffBy(270.0, -170.0, -100.0)));
}

// What the albedos' scale makes of it says nothing of how sun and sky share the light, nor does
// what one part of the sky has of the other's.
TEST(LightIsKnown, WhateverItsScale) {
  EXPECT_TRUE(LightIsKnown(OffBy(6000.0, 1500.0, 500.0)));
  EXPECT_TRUE(LightIsKnown(OffBy(0.0, 1500.0, -1500.0)));
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
