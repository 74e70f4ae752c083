#include "estimation/given_lighting_source.h"

#include <chrono>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimation/outdoor_lighting_source.h"
#include "sunmodel/sky_shapes.h"
#include "sunmodel/time_text.h"
#include "tests/estimation/synthetic_view.h"

namespace pleinair::given_lighting_source_test {
namespace {

using testing::MakeFrame;
using testing::MakeView;
using testing::Observe;
using testing::SyntheticPicture;

std::unique_ptr<LightingSource> SourceOf(const GivenLight& light) {
  return MakeGivenLightingSource({{0, light}}, MakeOutdoorLightingSource({}));
}

GivenLight SomeLight() {
  GivenLight light;
  light.sun_irradiance_rgb = {800.0, 700.0, 600.0};
  light.sky_irradiance_rgb = {100.0, 120.0, 150.0};
  return light;
}

TEST(GivenLighting, IsTheLightThatWasGiven) {
  GivenLight light = SomeLight();
  light.sky_shares = {{"uniform", glm::dvec3(0.25)}, {"overcast", glm::dvec3(0.75)}};
  const SurfaceView view = MakeView({});
  const Frame frame = MakeFrame({}, view);
  const auto source = SourceOf(light);
  const auto basis = source->BasisFor(frame, {view.sun_direction_enu});
  ASSERT_TRUE(basis.has_value()) << basis.error().reason;
  ASSERT_EQ(basis->size(), 2u);
  const auto estimate = source->Estimate(Observe(frame, view));
  ASSERT_TRUE(estimate.has_value()) << estimate.error().reason;
  const Lighting& lighting = estimate->lighting;
  EXPECT_EQ(lighting.sun.irradiance_rgb, light.sun_irradiance_rgb);
  ASSERT_EQ(lighting.sky.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) EXPECT_EQ(lighting.sky[k].shape, (*basis)[k]->Name());
  for (int c = 0; c < 3; ++c) {
    EXPECT_DOUBLE_EQ(lighting.sky[0].irradiance_rgb[c], 0.25 * light.sky_irradiance_rgb[c]);
    EXPECT_DOUBLE_EQ(lighting.sky[1].irradiance_rgb[c], 0.75 * light.sky_irradiance_rgb[c]);
  }
  EXPECT_TRUE(lighting.covariance.empty()) << "nobody said how sure it is";
}

TEST(GivenLighting, IsOfItsFramesTime) {
  GivenLight light = SomeLight();
  const SurfaceView view = MakeView({});
  Frame frame = MakeFrame({}, view);
  light.time = frame.time;
  const auto source = SourceOf(light);
  frame.time += std::chrono::minutes(59);
  EXPECT_TRUE(source->BasisFor(frame, {view.sun_direction_enu}).has_value());
  frame.time += std::chrono::minutes(2);
  const auto refused = source->BasisFor(frame, {view.sun_direction_enu});
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(
      refused.error().reason,
      ::testing::AllOf(::testing::HasSubstr("expected light of " + FormatUtcTime(frame.time)),
                       ::testing::HasSubstr("found light of " + FormatUtcTime(*light.time))));
}

TEST(GivenLighting, KeepsShapesThatDoNotTurn) {
  GivenLight light = SomeLight();
  light.sky_shares = {{"clear", glm::dvec3(0.5)}, {"uniform", glm::dvec3(0.5)}};
  const Frame frame = MakeFrame({}, MakeView({}));
  const auto source = SourceOf(light);
  const auto first = source->BasisFor(frame, {{0.0, -0.6, 0.8}});
  const auto uniform = (*first)[0];
  const auto clear = (*first)[1];
  const auto second = source->BasisFor(frame, {{0.0, -0.8, 0.6}});
  EXPECT_EQ((*second)[0], uniform);
  EXPECT_NE((*second)[1], clear);
}

// Light that is summed in another order rounds otherwise: a picture would differ from the one that
// the light was estimated with.
TEST(GivenLighting, HasItsShapesInTheOrderOfAnEstimate) {
  GivenLight light = SomeLight();
  for (const SkyShapeKind kind : kAllSkyShapeKinds) {
    light.sky_shares.emplace(NameOf(kind), glm::dvec3(1.0 / std::size(kAllSkyShapeKinds)));
  }
  const SurfaceView view = MakeView({});
  const Frame frame = MakeFrame({}, view);
  const auto names = [&](LightingSource& source) {
    std::vector<std::string> shapes;
    const auto basis = source.BasisFor(frame, {view.sun_direction_enu});
    EXPECT_TRUE(basis.has_value());
    for (const auto& shape : *basis) shapes.push_back(shape->Name());
    return shapes;
  };
  EXPECT_EQ(names(*SourceOf(light)), names(*MakeOutdoorLightingSource({})));
}

// The picture is of half the light that is given: with both held, only the shape is the picture's.
TEST(GivenLighting, FitsTheShapeAloneWhereNoneIsGiven) {
  SyntheticPicture picture;
  picture.sun *= 0.5;
  const SurfaceView view = MakeView(picture);
  const Frame frame = MakeFrame(picture, view);
  const GivenLight light = SomeLight();
  OutdoorLightingOptions one_shape;
  one_shape.sky_shapes = {SkyShapeKind::kUniform};
  const auto source = MakeGivenLightingSource({{0, light}}, MakeOutdoorLightingSource(one_shape));
  ASSERT_TRUE(source->BasisFor(frame, {view.sun_direction_enu}).has_value());
  const auto estimate = source->Estimate(Observe(frame, view));
  ASSERT_TRUE(estimate.has_value()) << estimate.error().reason;
  EXPECT_EQ(estimate->lighting.sun.irradiance_rgb, light.sun_irradiance_rgb);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(estimate->lighting.SkyIrradianceRgb()[c], light.sky_irradiance_rgb[c], 1e-9);
  }
}

TEST(GivenLighting, FailsAFrameThatItHasNoLineFor) {
  Frame frame = MakeFrame({}, MakeView({}));
  frame.index = 3;
  const auto source = SourceOf(SomeLight());
  const auto basis = source->BasisFor(frame, {});
  ASSERT_FALSE(basis.has_value());
  EXPECT_NE(basis.error().reason.find("no line for this frame"), std::string::npos);
}

TEST(GivenLighting, RefusesWhatIsNoLight) {
  const auto refuses = [](auto&& spoil) {
    GivenLight light = SomeLight();
    light.sky_shares = {{"uniform", glm::dvec3(1.0)}};
    EXPECT_NO_THROW(light.Validate());
    spoil(light);
    EXPECT_THROW(light.Validate(), std::invalid_argument);
  };
  refuses([](GivenLight& light) { light.sun_irradiance_rgb.y = -1.0; });
  refuses([](GivenLight& light) { light.sky_irradiance_rgb.x = std::nan(""); });
  refuses([](GivenLight& light) { light.sky_shares["uniform"].z = 0.5; });
  refuses([](GivenLight& light) { light.sky_shares = {{"plaid", glm::dvec3(1.0)}}; });
  refuses([](GivenLight& light) { light.sky_image = "sky.hdr"; });
}

}  // namespace
}  // namespace pleinair::given_lighting_source_test
