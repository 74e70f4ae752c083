// Light that is carried from the survey and from picture to picture, where no picture decides it.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/common.hpp>

#include "estimation/outdoor_estimator.h"
#include "sunmodel/angles.h"
#include "sunmodel/clear_sky.h"
#include "tests/estimation/synthetic_scene.h"

namespace pleinair::carried_light_hard_cases_test {
namespace {

using std::chrono::hours;
using std::chrono::seconds;
using testing::MakeSamples;
using testing::SyntheticClearSky;
using testing::SyntheticScene;

const UtcTime kNoon{hours(12)};
const std::vector<std::string> kShapes{"uniform"};
// White balance and exposure that nobody knows.
const glm::dvec3 kPhone{0.0031, 0.0026, 0.0021};

struct Day {
  const char* name;
  glm::dvec3 sun;
  glm::dvec3 sky;
};

const Day kOvercast{"overcast", glm::dvec3(0.0), {190.0, 196.0, 206.0}};
const Day kDrizzle{"drizzle", glm::dvec3(0.0), {45.0, 47.0, 50.0}};
const Day kBroken{"broken", {640.0, 600.0, 530.0}, {160.0, 175.0, 195.0}};
const Day kClear{"clear", {820.0, 780.0, 700.0}, {85.0, 100.0, 125.0}};

struct Carried {
  glm::dvec3 sun;
  glm::dvec3 sky;
};

double Mean(const glm::dvec3& rgb) { return (rgb.r + rgb.g + rgb.b) / 3.0; }

// The clear sky in the survey's units, as a survey ties them: a clear or broken sky by its own sun
// and sky, an overcast one roughly, by what clouds leave of a clear day's light.
ClearSkyExpectation ClearSkyOf(const Day& day) {
  ClearSkyExpectation clear_sky = SyntheticClearSky();
  if (day.sun.g > 0.0) {
    clear_sky.beam_rgb = day.sun;
    clear_sky.diffuse_rgb = day.sky;
    clear_sky.gain_stddev = 0.05;
    return clear_sky;
  }
  constexpr double kCloudedShare = 0.35;
  const double global =
      clear_sky.beam_rgb.g * clear_sky.sine_of_elevation + clear_sky.diffuse_rgb.g;
  const double gain = day.sky.g / (kCloudedShare * global);
  clear_sky.beam_rgb *= gain;
  clear_sky.diffuse_rgb *= gain;
  clear_sky.gain_stddev = 0.5;
  return clear_sky;
}

// What an estimator reports that knows a survey of `day` and then sees the same ground, all of it
// open to the sun that shines or does not, so long after it. Phone: 8 bit, exposure withheld.
class Survey {
 public:
  Survey(const Day& day, std::uint64_t seed, bool is_phone) : is_phone_(is_phone) {
    SyntheticScene scene;
    scene.seed = seed;
    scene.one_plane = true;
    scene.lit_share = 1.0;
    scene.albedo_noise = 0.03;
    scene.sun = day.sun;
    scene.sky = day.sky;
    samples_ = MakeSamples(scene);
    if (is_phone) {
      for (DiffuseSample& sample : samples_) sample.radiance_rgb *= kPhone;
    }
    surveyed_ = {.time = kNoon,
                 .sun_rgb = day.sun,
                 .sun_stddev_rgb = 0.01 * day.sun,
                 .sky_rgb = day.sky,
                 .clear_sky = ClearSkyOf(day)};
  }

  void RecordVideo() { is_video_ = true; }

  // From here on the model has parts of the ground in less sky, and parts in more, than the picture
  // shows: the same error in every frame, which looks like light of the sun.
  void MistakeTheSky() {
    constexpr double kError = 0.002;
    constexpr int kTilePx = 120;
    for (DiffuseSample& sample : samples_) {
      const bool is_open = (sample.pixel.x / kTilePx + sample.pixel.y / kTilePx) % 2 == 0;
      sample.sky_transport_rgb[0] *= is_open ? 1.0 + kError : 1.0 - kError;
    }
  }

  Carried LightAfter(UtcTime::duration after) {
    OutdoorConditions conditions;
    conditions.time = kNoon + after;
    conditions.sun.direction_enu = {0.8, 0.0, 0.6};
    conditions.clear_sky = surveyed_.clear_sky;
    conditions.sky_shape_names = kShapes;
    conditions.surveyed = surveyed_;
    if (is_phone_) conditions.units = LightUnits::kRelativePerFrame;
    // A phone that stands still keeps its exposure from picture to picture.
    if (is_phone_ && is_video_ && has_seen_) {
      conditions.exposure_change.kind = ExposureChange::Kind::kNone;
    }
    has_seen_ = true;
    std::vector<DiffuseSample> samples = samples_;
    const Lighting light = estimator_.Estimate(samples, conditions).value().lighting;
    return {light.sun.irradiance_rgb, light.SkyIrradianceRgb()};
  }

 private:
  bool is_phone_;
  bool is_video_ = false;
  bool has_seen_ = false;
  std::vector<DiffuseSample> samples_;
  SurveyedLight surveyed_;
  OutdoorEstimator estimator_{LightingFitOptions{}};
};

constexpr seconds kRepeats[] = {seconds(0), seconds(1), seconds(10), seconds(600), seconds(3600)};
constexpr std::uint64_t kSeeds = 5;

// Calls `check` with each of some surveys, linear and of a phone.
template <typename Check>
void ForEachSurvey(const Day& day, Check check) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    for (const bool is_phone : {false, true}) {
      SCOPED_TRACE(std::string(day.name) + ", seed " + std::to_string(seed) +
                   (is_phone ? ", phone" : ""));
      check(Survey(day, seed, is_phone), is_phone);
    }
  }
}

// The picture shows neither sun patch nor shadow.
constexpr double kMayMove = 0.25;

// No cyan object, no hard shadow after a minute.
TEST(CarriedLightHardCases, AnOvercastPictureSeenAgainGetsNoSun) {
  for (const Day& day : {kOvercast, kDrizzle}) {
    ForEachSurvey(day, [&](Survey survey, bool is_phone) {
      for (const seconds after : kRepeats) {
        const Carried light = survey.LightAfter(after);
        EXPECT_LE(Mean(light.sun), 0.03 * Mean(light.sky)) << after.count() << " s";
        const glm::dvec3 truth = is_phone ? day.sky * kPhone : day.sky;
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(light.sky[c] / truth[c], 1.0, kMayMove) << after.count() << " s";
        }
      }
    });
  }
}

TEST(CarriedLightHardCases, ASunnyPictureSeenAgainKeepsItsSunAndTheColourOfItsSky) {
  for (const Day& day : {kBroken, kClear}) {
    ForEachSurvey(day, [&](Survey survey, bool) {
      const Carried first = survey.LightAfter(seconds(0));
      const double ratio = Mean(first.sun) / Mean(first.sky);
      EXPECT_NEAR(ratio / (Mean(day.sun) / Mean(day.sky)), 1.0, kMayMove);
      for (const seconds after : kRepeats) {
        const Carried light = survey.LightAfter(after);
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(light.sun[c] / first.sun[c], 1.0, kMayMove) << after.count() << " s";
          EXPECT_NEAR(light.sky[c] / first.sky[c], 1.0, kMayMove) << after.count() << " s";
        }
      }
    });
  }
}

// An error that every frame repeats is no news: it must not add up, frame by frame.
void ExpectKeepsItsLight(const Day& day, std::chrono::milliseconds step, double may_move) {
  constexpr int kFrames = 300;
  ForEachSurvey(day, [&](Survey survey, bool is_phone) {
    survey.MistakeTheSky();
    survey.RecordVideo();
    const Carried first = survey.LightAfter(seconds(0));
    Carried last = first;
    for (int i = 1; i <= kFrames; ++i) last = survey.LightAfter(i * step);
    const bool is_sunny = day.sun.g > 0.0;
    EXPECT_LE(Mean(last.sun),
              is_sunny ? (1.0 + may_move) * Mean(first.sun) : 0.03 * Mean(last.sky));
    const glm::dvec3 unit = is_phone ? kPhone : glm::dvec3(1.0);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(last.sky[c] / (day.sky[c] * unit[c]), 1.0, kMayMove);
      EXPECT_NEAR(last.sky[c] / first.sky[c], 1.0, may_move);
      if (!is_sunny) continue;
      EXPECT_NEAR(last.sun[c] / first.sun[c], 1.0, may_move);
    }
  });
}

TEST(CarriedLightHardCases, AVideoOfOnePictureKeepsItsLight) {
  for (const Day& day : {kOvercast, kDrizzle, kBroken, kClear}) {
    ExpectKeepsItsLight(day, std::chrono::milliseconds(33), 0.05);
  }
}

TEST(CarriedLightHardCases, APictureRepeatedForMinutesKeepsItsLight) {
  for (const Day& day : {kOvercast, kDrizzle, kBroken, kClear}) {
    ExpectKeepsItsLight(day, seconds(1), kMayMove);
  }
}

// A thin cloud: the carried light must not hold what the picture no longer shows. Tolerances are
// some of what the planes' own errors of 5 % leave of a difference: they are the same before and
// after.
TEST(CarriedLightHardCases, ASunThatDimsInAVideoIsFollowed) {
  for (const double share : {0.9, 0.7, 0.4}) {
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      SCOPED_TRACE(std::to_string(share) + " of the sun, seed " + std::to_string(seed));
      SyntheticScene scene;
      scene.seed = seed;
      scene.albedo_noise = 0.03;
      scene.region_noise = 0.05;
      scene.lit_share = 1.0;
      scene.regions = 3;
      scene.sun = kClear.sun;
      scene.sky = kClear.sky;
      const std::vector<DiffuseSample> before = MakeSamples(scene);
      scene.sun *= share;
      const std::vector<DiffuseSample> after = MakeSamples(scene);
      OutdoorEstimator estimator{LightingFitOptions{}};
      OutdoorConditions conditions;
      conditions.sun.direction_enu = {0.8, 0.0, 0.6};
      conditions.clear_sky = ClearSkyOf(kClear);
      conditions.sky_shape_names = kShapes;
      conditions.surveyed = SurveyedLight{.time = kNoon,
                                          .sun_rgb = kClear.sun,
                                          .sun_stddev_rgb = 0.01 * kClear.sun,
                                          .sky_rgb = kClear.sky,
                                          .clear_sky = ClearSkyOf(kClear)};
      const auto light_of = [&](const std::vector<DiffuseSample>& seen, double at_s) {
        conditions.time = kNoon + std::chrono::milliseconds(std::lround(1000.0 * at_s));
        std::vector<DiffuseSample> samples = seen;
        return estimator.Estimate(samples, conditions).value().lighting;
      };
      Lighting clear;
      for (int i = 0; i < 30; ++i) clear = light_of(before, i / 10.0);
      Lighting dimmed;
      for (int i = 0; i < 30; ++i) dimmed = light_of(after, 3.0 + i / 10.0);
      EXPECT_NEAR(Mean(dimmed.sun.irradiance_rgb) / Mean(clear.sun.irradiance_rgb), share, 0.04);
      EXPECT_NEAR(Mean(dimmed.SkyIrradianceRgb()) / Mean(clear.SkyIrradianceRgb()), 1.0, 0.06);
    }
  }
}

// Nothing came between: the survey is all that is known.
TEST(CarriedLightHardCases, OneFrameTenMinutesAfterAnOvercastSurveyHasNoSun) {
  for (const Day& day : {kOvercast, kDrizzle}) {
    ForEachSurvey(day, [&](Survey survey, bool) {
      const Carried light = survey.LightAfter(seconds(600));
      EXPECT_LE(Mean(light.sun), 0.03 * Mean(light.sky));
      const double largest = std::max({light.sky.r, light.sky.g, light.sky.b});
      const double smallest = std::min({light.sky.r, light.sky.g, light.sky.b});
      EXPECT_GE(smallest, 0.4 * largest);  // White balance: 0.21 over 0.31.
    });
  }
}

// From sunrise to dusk, every 20 minutes of a spring day: walls and ground of a guessed albedo,
// half of them in the sun while it is up, seen by a webcam that sets its own exposure.
struct WebcamFrame {
  double elevation_rad = 0.0;
  glm::dvec3 sun{0.0};
  glm::dvec3 sky{0.0};
  LightingEstimate estimate;
};

std::vector<WebcamFrame> WebcamsClearDay(std::uint64_t seed) {
  constexpr double kPerFrame = 0.4;  // Of the exposure, up and down.
  OutdoorEstimator estimator{LightingFitOptions{}};
  std::vector<WebcamFrame> day;
  for (int i = 0; i < 36; ++i) {
    WebcamFrame& frame = day.emplace_back();
    const double noon = (i - 17) / 18.0;
    frame.elevation_rad = RadFromDeg(2.0 + 48.0 * std::cos(0.5 * std::numbers::pi * noon));
    if (i > 33) frame.elevation_rad = RadFromDeg(-1.0 - (i - 34));
    const ClearSkyIrradiance truth =
        ComputeClearSky(Site{}, frame.elevation_rad, {.aerosol_optical_depth_500nm = 0.15});
    frame.sun = truth.beam_rgb;
    frame.sky = truth.diffuse_rgb;

    SyntheticScene scene;
    scene.seed = seed;
    scene.albedo_noise = 0.05;
    scene.region_noise = 0.1;
    scene.lit_share = frame.sun.g > 0.0 ? 0.5 : 0.0;
    scene.sun = frame.sun;
    scene.sky = frame.sky;
    std::vector<DiffuseSample> samples = MakeSamples(scene);
    const double exposure = std::exp(kPerFrame * std::sin(1.7 * i)) / frame.sky.g;
    for (DiffuseSample& sample : samples) sample.radiance_rgb *= exposure;

    const ClearSkyIrradiance model = ComputeClearSky(Site{}, frame.elevation_rad);
    OutdoorConditions conditions;
    conditions.time = kNoon + std::chrono::minutes(20 * (i - 17));
    conditions.sun.direction_enu = {
        std::cos(frame.elevation_rad), 0.0, std::sin(frame.elevation_rad)};
    conditions.clear_sky = {.beam_rgb = model.beam_rgb,
                            .diffuse_rgb = model.diffuse_rgb,
                            .sine_of_elevation = std::sin(frame.elevation_rad),
                            .absolute = false};
    conditions.sky_shape_names = kShapes;
    conditions.units = LightUnits::kRelativePerFrame;
    conditions.plane_albedo_stddev = 0.25;
    frame.estimate = estimator.Estimate(samples, conditions).value();
  }
  return day;
}

double LogSunOverSky(const glm::dvec3& sun, const glm::dvec3& sky) {
  return std::log(Mean(sun) / Mean(sky));
}

TEST(CarriedLightHardCases, AWebcamsClearDayIsSmoothAndItsSunIsSeen) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    double last_error = 0.0;
    int sunny = 0;
    for (const WebcamFrame& frame : WebcamsClearDay(seed)) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", sun at " +
                   std::to_string(DegFromRad(frame.elevation_rad)) + " deg");
      const Lighting& light = frame.estimate.lighting;
      const glm::dvec3 sky = light.SkyIrradianceRgb();
      // Colours of guessed albedos are right here: the sky's is the truth's, at dusk, too.
      EXPECT_NEAR(std::log(sky.b / sky.r), std::log(frame.sky.b / frame.sky.r), std::log(1.3));
      if (frame.sun.g <= 0.0) {
        EXPECT_LE(Mean(light.sun.irradiance_rgb), 0.03 * Mean(sky));
        continue;
      }
      EXPECT_TRUE(frame.estimate.sun_observable);
      const double error =
          LogSunOverSky(light.sun.irradiance_rgb, sky) - LogSunOverSky(frame.sun, frame.sky);
      EXPECT_LE(std::abs(error), std::log(1.4));
      if (sunny++ > 0) {
        EXPECT_LE(std::abs(error - last_error), std::log(1.1));
      }
      last_error = error;
    }
    EXPECT_EQ(sunny, 34);
  }
}

// Surfaces that are all in the sun, all in the shade or both, patchy and too colourful, as phones
// take them: whatever cannot be seen keeps the colours of daylight.
TEST(CarriedLightHardCases, NoChannelVanishesFromADirtyPicture) {
  constexpr double kSaturation = 1.3;
  for (const Day& day : {kOvercast, kBroken, kClear}) {
    for (const double lit_share : {0.0, 0.5, 1.0}) {
      for (std::uint64_t seed = 1; seed <= 4 * kSeeds; ++seed) {
        SCOPED_TRACE(std::string(day.name) + ", lit share " + std::to_string(lit_share) +
                     ", seed " + std::to_string(seed));
        SyntheticScene scene;
        scene.seed = seed;
        scene.lit_share = lit_share;
        scene.albedo_noise = 0.1;
        scene.channel_noise = 0.05;
        scene.region_noise = 0.15;
        scene.tile_noise = 0.1;
        scene.sun = day.sun;
        scene.sky = day.sky;
        std::vector<DiffuseSample> samples = MakeSamples(scene);
        for (DiffuseSample& sample : samples) {
          const glm::dvec3 grey(Mean(sample.radiance_rgb));
          sample.radiance_rgb =
              glm::max(grey + kSaturation * (sample.radiance_rgb - grey), glm::dvec3(0.0));
        }
        OutdoorConditions conditions;
        conditions.time = kNoon;
        conditions.sun.direction_enu = {0.8, 0.0, 0.6};
        conditions.clear_sky = SyntheticClearSky();
        conditions.sky_shape_names = kShapes;
        const Lighting light =
            OutdoorEstimator(LightingFitOptions{}).Estimate(samples, conditions).value().lighting;
        const glm::dvec3 sky = light.SkyIrradianceRgb();
        for (glm::dvec3 rgb : {light.sun.irradiance_rgb, sky}) {
          if (Mean(rgb) <= 0.03 * Mean(sky)) continue;  // There is no sun.
          std::sort(&rgb[0], &rgb[0] + 3);
          EXPECT_GE(rgb[0], 0.25 * rgb[1]);
          EXPECT_GE(rgb[1], 0.25 * rgb[2]);
        }
      }
    }
  }
}

}  // namespace
}  // namespace pleinair::carried_light_hard_cases_test
