#include "estimation/exposure_change.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "estimation/lighting_filter.h"
#include "estimation/outdoor_lighting_source.h"
#include "tests/estimation/synthetic_stream.h"

namespace pleinair::exposure_change_test {
namespace {

using Kind = ExposureChange::Kind;
using testing::SyntheticPicture;

// Two frames of an 8-bit camera, a thirtieth of a second apart.
struct Pair {
  SyntheticPicture first;
  SyntheticPicture second;
  double first_exposure = 0.003;
  double second_exposure = 0.003;
  glm::vec3 second_balance{1.0f};

  ExposureChange Change(std::chrono::nanoseconds gap = std::chrono::milliseconds(33)) const {
    const SurfaceView view = testing::MakeView(first);
    std::mt19937_64 random(3);
    ExposureWatch watch;
    Frame frame = testing::MakeFrame(first, view);
    watch.Compare(testing::SeenByCamera(frame, first_exposure, random, false), view);
    frame = testing::MakeFrame(second, view);
    frame.time += gap;
    for (glm::vec3& pixel : frame.radiance.pixels) pixel *= second_balance;
    return watch.Compare(testing::SeenByCamera(frame, second_exposure, random, false), view);
  }
};

TEST(ExposureChange, AStillFrameIsNone) {
  const ExposureChange change = Pair().Change();
  EXPECT_EQ(change.kind, Kind::kNone);
  EXPECT_NEAR(change.factor_rgb.x, 1.0, 0.01);
}

TEST(ExposureChange, StepsOfExposureAndBalanceAreRecognised) {
  for (const double step : {-1.0, -0.3, 0.1, 0.5, 1.0}) {
    Pair pair;
    pair.second_exposure *= std::exp2(step);
    pair.second_balance = {1.1f, 1.0f, 0.85f};
    const ExposureChange change = pair.Change();
    EXPECT_EQ(change.kind, Kind::kExposure) << step;
    for (int c = 0; c < 3; ++c) {
      // Medians of noise and rounding.
      EXPECT_NEAR(
          change.factor_rgb[c] / (std::exp2(step) * double{pair.second_balance[c]}), 1.0, 0.01);
    }
  }
}

TEST(ExposureChange, CloudsAreLightWhateverTheExposureDoes) {
  for (const double sun : {0.0, 0.3, 0.8}) {
    for (const double exposure : {1.0, 2.0, 0.5}) {
      Pair pair;
      pair.second.sun *= sun;
      pair.second.sky *= 1.6 - 0.6 * sun;
      pair.second_exposure *= exposure;
      EXPECT_EQ(pair.Change().kind, Kind::kLight) << sun << " " << exposure;
    }
  }
}

TEST(ExposureChange, KnowsNothingOfOtherViewsOrAfterAGap) {
  EXPECT_EQ(Pair().Change(std::chrono::seconds(3)).kind, Kind::kUnknown);
  EXPECT_EQ(Pair().Change(-std::chrono::hours(3)).kind, Kind::kUnknown);
  Pair shaded;
  shaded.first.shadow_share = shaded.second.shadow_share = 1.0;
  shaded.second_exposure *= 2.0;
  EXPECT_EQ(shaded.Change().kind, Kind::kUnknown);
  // All clipped, all black.
  for (const double exposure : {1.0, 1e-9}) {
    Pair blind;
    blind.second_exposure = exposure;
    EXPECT_EQ(blind.Change().kind, Kind::kUnknown);
  }
}

// The outdoor estimate through a step of one EV up or down in the middle of a stream.
struct Stream {
  std::vector<LightingEstimate> estimates;
  std::vector<Lighting> filtered;
};

Stream SeeExposureStep(double ev, bool exposure_is_known) {
  SyntheticPicture picture;
  picture.width = 96;
  picture.height = 72;
  const SurfaceView view = testing::MakeView(picture);
  const auto source = MakeOutdoorLightingSource({});
  std::mt19937_64 random(3);
  LightingFilter filter;
  Stream stream;
  for (int i = 0; i < 40; ++i) {
    const double exposure = 0.003 * (i < 20 ? 1.0 : std::exp2(ev));
    Frame frame = testing::SeenByCamera(
        testing::MakeFrame(picture, view), exposure, random, exposure_is_known);
    frame.time = testing::StreamTime(i, 30.0);
    stream.estimates.push_back(source->Estimate(testing::Observe(frame, view)).value());
    stream.filtered.push_back(
        filter.Apply(stream.estimates.back().lighting, stream.estimates.back().units).lighting);
  }
  return stream;
}

TEST(ExposureChange, AKnownStepDoesNotMoveTheLight) {
  for (const double ev : {-1.0, 1.0}) {
    const Stream stream = SeeExposureStep(ev, true);
    for (std::size_t i = 10; i < stream.filtered.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(
            stream.filtered[i].sun.irradiance_rgb[c] / stream.filtered[19].sun.irradiance_rgb[c],
            1.0,
            0.02)
            << ev << " " << i;
        EXPECT_NEAR(
            stream.filtered[i].SkyIrradianceRgb()[c] / stream.filtered[19].SkyIrradianceRgb()[c],
            1.0,
            0.02)
            << ev << " " << i;
      }
    }
  }
}

TEST(ExposureChange, AnUnknownStepIsRecognisedAndKeepsSunToSky) {
  for (const double ev : {-1.0, 1.0}) {
    const Stream stream = SeeExposureStep(ev, false);
    const auto ratio = [&](std::size_t i, int c) {
      return stream.filtered[i].sun.irradiance_rgb[c] / stream.filtered[i].SkyIrradianceRgb()[c];
    };
    for (std::size_t i = 1; i < stream.filtered.size(); ++i) {
      EXPECT_EQ(stream.estimates[i].units, LightUnits::kRelativePerFrame);
      EXPECT_EQ(stream.estimates[i].exposure_change.kind, i == 20 ? Kind::kExposure : Kind::kNone);
      if (i < 10) continue;
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(ratio(i, c) / ratio(19, c), 1.0, 0.02) << ev << i;
    }
    // The light is in the units of each frame's picture.
    EXPECT_NEAR(stream.filtered[25].sun.irradiance_rgb.x / stream.filtered[15].sun.irradiance_rgb.x,
                std::exp2(ev),
                0.02 * std::exp2(ev));
  }
}

}  // namespace
}  // namespace pleinair::exposure_change_test
