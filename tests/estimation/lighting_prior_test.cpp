#include "estimation/lighting_prior.h"

#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/estimation/synthetic_scene.h"

namespace pleinair::lighting_prior_test {
namespace {

using testing::SyntheticClearSky;

TEST(LightingPrior, HoldsEveryStateOfTheSkyOnce) {
  const LightingPrior prior = MakeClimatePrior(SyntheticClearSky(), 3);
  double share = 0.0;
  for (const WeatherLight& weather : prior.weathers) share += weather.share;
  EXPECT_EQ(prior.weathers.size(), std::size_t{kSkyStates});
  EXPECT_NEAR(share, 1.0, 1e-12);
  EXPECT_TRUE(prior.SaysSomething());
  EXPECT_FALSE(prior.gain_is_free);
}

TEST(LightingPrior, OfUnknownUnitsLeavesTheGainFree) {
  ClearSkyExpectation clear_sky = SyntheticClearSky();
  clear_sky.absolute = false;
  const LightingPrior prior = MakeClimatePrior(clear_sky, 1);
  EXPECT_TRUE(prior.gain_is_free);
  EXPECT_FALSE(prior.SaysSomething());  // Without a picture there is no light to speak of.
}

TEST(LightingPrior, OfABlackSkySaysNothing) {
  const LightingPrior prior = MakeClimatePrior({}, 1);
  EXPECT_TRUE(prior.weathers.empty());
  EXPECT_FALSE(prior.SaysSomething());
}

TEST(LightingPrior, HeldLightReplacesTheWeathers) {
  LightingPrior prior = MakeClimatePrior(SyntheticClearSky(), 2);
  HoldIrradiance({100.0, 90.0, 0.0}, {50.0, 60.0, 0.0}, prior);
  EXPECT_TRUE(prior.weathers.empty());
  EXPECT_GT(prior.information(0, 0), 0.0);
  EXPECT_GT(prior.information(2, 2), 0.0);  // Of the usual size: not rigid, not free.
}

TEST(LightingPrior, TheClearShapeIsTheOneThatNeedsABeam) {
  LightingPrior prior = MakeClimatePrior(SyntheticClearSky(), 2);
  const std::vector<std::string> names{"overcast", "clear"};
  SetBeamShape(names, SyntheticClearSky(), prior);
  EXPECT_EQ(prior.beam_shape, 1);
  EXPECT_DOUBLE_EQ(prior.clear_sun_to_sky_rgb.x, 850.0 / 70.0);
}

TEST(LightingPrior, RefusesShapesThatTheFitHasNoRoomFor) {
  EXPECT_THROW(LightingPrior::Nothing(0), std::invalid_argument);
  EXPECT_THROW(LightingPrior::Nothing(kMaxSkyShapes + 1), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::lighting_prior_test
