#include "estimation/lighting_filter.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <glm/common.hpp>

#include "estimation/outdoor_lighting_source.h"
#include "tests/estimation/synthetic_stream.h"

namespace pleinair::lighting_filter_test {
namespace {

using testing::EstimateStream;
using testing::Flicker;
using testing::Mean;
using testing::SyntheticPicture;
using testing::TrueLight;

struct Levels {
  std::vector<double> sun;
  std::vector<double> sky;
};

Levels LevelsOf(const std::vector<Lighting>& stream) {
  Levels levels;
  for (const Lighting& lighting : stream) {
    levels.sun.push_back(Mean(lighting.sun.irradiance_rgb));
    levels.sky.push_back(Mean(lighting.SkyIrradianceRgb()));
  }
  return levels;
}

std::vector<Lighting> Filter(const std::vector<Lighting>& stream) {
  LightingFilter filter;
  std::vector<Lighting> filtered;
  filtered.reserve(stream.size());
  for (const Lighting& lighting : stream) filtered.push_back(filter.Apply(lighting).lighting);
  return filtered;
}

double MeanOf(const std::vector<double>& values, std::size_t begin, std::size_t end) {
  return std::accumulate(values.begin() + static_cast<std::ptrdiff_t>(begin),
                         values.begin() + static_cast<std::ptrdiff_t>(end),
                         0.0) /
         static_cast<double>(end - begin);
}

TrueLight WithSun(double share) {
  TrueLight light;
  light.sun *= share;
  light.sky *= 1.6 - 0.6 * share;  // A cloud is brighter than the blue that it covers.
  return light;
}

// Of the sun's share.
struct Step {
  double from;
  double to;
};

const double kRates[] = {10.0, 30.0};

// Estimates that flicker by 1.5 %: their means over a second and more, by less than 0.5 %. The
// first frames have no others to go by.
TEST(LightingFilter, SteadiesANoisyStream) {
  for (const double rate : kRates) {
    EstimateStream stream;
    stream.frames_per_second = rate;
    stream.noise = 0.015 * std::sqrt(3.0);  // Of each channel.
    const auto raw = stream.Make(300, [](int) { return TrueLight(); });
    const Levels before = LevelsOf(raw);
    Levels after = LevelsOf(Filter(raw));
    EXPECT_NEAR(Flicker(before.sun), 0.015, 0.003);
    const auto settled = static_cast<std::ptrdiff_t>(1.5 * rate);
    after.sun.erase(after.sun.begin(), after.sun.begin() + settled);
    after.sky.erase(after.sky.begin(), after.sky.begin() + settled);
    EXPECT_LT(Flicker(after.sun), 0.005) << rate;
    EXPECT_LT(Flicker(after.sky), 0.005) << rate;
  }
}

TEST(LightingFilter, FollowsACloudWithinThreeFramesAndWithoutBias) {
  for (const double rate : kRates) {
    for (const double noise : {0.0, 0.003, 0.01, 0.02}) {
      for (const Step& cloud :
           {Step{1.0, 0.2}, Step{0.2, 1.0}, Step{1.0, 0.0}, Step{0.0, 1.0}, Step{1.0, 0.8}}) {
        EstimateStream stream;
        stream.frames_per_second = rate;
        stream.noise = noise;
        const int step = 60;
        const auto raw =
            stream.Make(120, [&](int i) { return WithSun(i < step ? cloud.from : cloud.to); });
        const Levels own = LevelsOf(raw);
        const Levels followed = LevelsOf(Filter(raw));
        for (const auto& [before, after] :
             {std::pair{&own.sun, &followed.sun}, {&own.sky, &followed.sky}}) {
          const double old_level = MeanOf(*before, 30, 60);
          const double new_level = MeanOf(*before, 60, 120);
          const double size = std::abs(new_level - old_level);
          // The third frame of the new light; three deviations of its noise beside the tenth.
          const double noise_of_frame = 3.0 * noise * std::max(old_level, new_level);
          EXPECT_LT(std::abs((*after)[step + 2] - new_level), 0.1 * size + noise_of_frame)
              << rate << " " << noise << " " << cloud.from << " " << cloud.to;
          // The mean's own noise over a second is noise / sqrt(3 rate). Cut off at 0, noise around
          // no sun is no Gaussian: a tenth of the step stands for its size.
          const double scale = std::max(new_level, 0.1 * size);
          const double left = std::abs(MeanOf(*after, step + 3, 120) - new_level);
          EXPECT_LT(left, 0.003 * scale + 2.0 * noise * scale / std::sqrt(rate))
              << rate << " " << noise << " " << cloud.from << " " << cloud.to;
        }
      }
    }
  }
}

// A cloud's soft edge over one second, from full sun to a fifth: behind by two frames at most.
TEST(LightingFilter, FollowsARamp) {
  for (const double rate : kRates) {
    EstimateStream stream;
    stream.frames_per_second = rate;
    stream.noise = 0.003;
    const int begin = 40;
    const auto share = [&](int i) { return 1.0 - 0.8 * std::clamp((i - begin) / rate, 0.0, 1.0); };
    const auto raw = stream.Make(120, [&](int i) { return WithSun(share(i)); });
    const Levels own = LevelsOf(raw);
    const Levels followed = LevelsOf(Filter(raw));
    const double slope = 0.8 * own.sun[0] / rate;
    for (std::size_t i = 40; i < 120; ++i) {
      EXPECT_LT(std::abs(followed.sun[i] - own.sun[i]), 2.2 * slope + 4.0 * 0.003 * own.sun[0])
          << rate << " " << i;
    }
    EXPECT_NEAR(MeanOf(followed.sun, 100, 120), MeanOf(own.sun, 100, 120), 0.003 * own.sun[0]);
  }
}

// Other surfaces come into view, and their errors with them: 1.5 % of the sky within a frame, the
// noise being less. No step of it is seen, and half a second later hardly anything of the old sky
// is left. In recordings of a frame a second it is all there.
TEST(LightingFilter, FadesWhatIsTooSmallForACloud) {
  for (const double rate : {1.0, 30.0}) {
    EstimateStream stream;
    stream.frames_per_second = rate;
    stream.noise = 0.002;
    const auto raw = stream.Make(120, [](int i) {
      TrueLight light;
      if (i >= 60) light.sky *= 1.015;
      return light;
    });
    const Levels own = LevelsOf(raw);
    const Levels followed = LevelsOf(Filter(raw));
    const double old_level = MeanOf(own.sky, 30, 60);
    const double new_level = MeanOf(own.sky, 60, 120);
    double largest_step = 0.0;
    for (std::size_t i = 30; i < 120; ++i) {
      largest_step = std::max(largest_step, std::abs(followed.sky[i] / followed.sky[i - 1] - 1.0));
    }
    if (rate > 1.0) {
      EXPECT_LT(largest_step, 0.005);
    }
    const auto later = static_cast<std::size_t>(62 + std::lround(0.5 * rate));
    EXPECT_NEAR(followed.sky[later], new_level, 0.2 * (new_level - old_level)) << rate;
  }
}

// What surfaces that both frames show have of the change between two lights.
LightChange Seen(const TrueLight& before, const TrueLight& after) {
  return {before.sun,
          before.sky,
          after.sun,
          after.sky,
          0.001 * glm::max(before.sun, after.sun),
          0.001 * glm::max(before.sky, after.sky),
          glm::dvec3(0.0)};
}

constexpr LightUnits kBothUnits[] = {LightUnits::kAbsolute, LightUnits::kRelativePerFrame};

// A step that the same surfaces show is no glitch: the frame that shows it has the new light.
TEST(LightingFilter, FollowsAtOnceWhatTheSameSurfacesShow) {
  EstimateStream stream;
  stream.noise = 0.003;
  const auto light_of = [](int i) { return WithSun(i >= 30 && i < 60 ? 0.3 : 1.0); };
  const auto raw = stream.Make(90, light_of);
  for (const LightUnits units : kBothUnits) {
    LightingFilter filter;
    for (std::size_t i = 0; i < raw.size(); ++i) {
      FrameFit fit;
      const auto frame = static_cast<int>(i);
      if (i > 0) fit.change = Seen(light_of(frame - 1), light_of(frame));
      const FilteredLighting filtered = filter.Apply(raw[i], units, fit);
      if (i != 30 && i != 60) continue;
      EXPECT_FALSE(filtered.sun.held) << i;
      EXPECT_FALSE(filtered.sky.held) << i;
      EXPECT_NEAR(Mean(filtered.lighting.sun.irradiance_rgb),
                  Mean(raw[i].sun.irradiance_rgb),
                  0.01 * Mean(raw[i].sun.irradiance_rgb));
      EXPECT_NEAR(Mean(filtered.lighting.SkyIrradianceRgb()),
                  Mean(raw[i].SkyIrradianceRgb()),
                  0.01 * Mean(raw[i].SkyIrradianceRgb()));
    }
  }
}

// A camera turns to surfaces on which the sky is 15 % more, while those that stay in view show that
// the light is as it was. In the second case a hand is before the lens in between, which these show
// as well; in the third a cloud comes with the other surfaces.
TEST(LightingFilter, FadesWhatTheSameSurfacesDoNotShow) {
  enum class Case { kSurfaces, kHand, kCloud };
  EstimateStream stream;
  stream.noise = 0.002;
  for (const LightUnits units : kBothUnits) {
    for (const Case which : {Case::kSurfaces, Case::kHand, Case::kCloud}) {
      const auto is_hand = [which](int i) { return which == Case::kHand && i >= 50 && i < 56; };
      const auto light_of = [&](int i) {
        TrueLight light;
        if (which == Case::kCloud && i >= 60) light.sun *= 0.5;
        if (is_hand(i)) light.sky *= 0.1;
        return light;
      };
      const auto raw = stream.Make(150, [&](int i) {
        TrueLight light = light_of(i);
        if (i >= 60) light.sky *= 1.15;
        return light;
      });
      LightingFilter filter;
      std::vector<Lighting> filtered;
      for (std::size_t i = 0; i < raw.size(); ++i) {
        const auto frame = static_cast<int>(i);
        FrameFit fit{.misfit = is_hand(frame) ? 0.5 : 0.05};
        if (i > 0) fit.change = Seen(light_of(frame - 1), light_of(frame));
        filtered.push_back(filter.Apply(raw[i], units, fit).lighting);
      }
      const Levels followed = LevelsOf(filtered);
      const Levels own = LevelsOf(raw);
      for (std::size_t i = 61; i < 150; ++i) {
        EXPECT_LT(std::abs(followed.sky[i] / followed.sky[i - 1] - 1.0), 0.008) << i;
        EXPECT_NEAR(followed.sun[i], own.sun[i], 0.03 * own.sun[0]) << i;
      }
      // The brightness of a relative light is that of its picture; a change of shares that is seen
      // for the most part is followed completely.
      const double most = units == LightUnits::kAbsolute ? 1.03
                          : which == Case::kCloud        ? 1.2
                                                         : 1.06;
      EXPECT_LT(followed.sky[60], most * own.sky[40]);
      EXPECT_GT(followed.sky[149], 1.13 * own.sky[40]);
    }
  }
}

// Errors of albedo and model are the same in every frame: a hundred frames know no more of them.
TEST(LightingFilter, DoesNotGrowSurerByWaiting) {
  const EstimateStream stream;
  const auto raw = stream.Make(100, [](int) { return TrueLight(); });
  const auto filtered = Filter(raw);
  for (std::size_t u = 0; u < 9; ++u) {
    EXPECT_NEAR(filtered.back().covariance[u * 10],
                raw.back().covariance[u * 10],
                1e-6 * raw.back().covariance[u * 10]);
  }
}

// A frame in which a bus hides the sunlit wall is less sure, and counts less.
TEST(LightingFilter, WeighsFramesByWhatTheyKnow) {
  EstimateStream stream;
  stream.noise = 0.0;
  stream.stated_deviation = 0.02;
  auto raw = stream.Make(10, [](int) { return TrueLight(); });
  const double sure = raw[0].sun.irradiance_rgb.x;
  for (std::size_t i = 5; i < 10; ++i) {
    raw[i].sun.irradiance_rgb *= 1.15;
    for (std::size_t u = 0; u < 3; ++u) raw[i].covariance[u * 10] *= 10000.0;
  }
  const auto filtered = Filter(raw);
  EXPECT_NEAR(filtered.back().sun.irradiance_rgb.x, sure, 1e-4 * sure);
  EXPECT_LT(filtered.back().covariance[0], 5.0 * raw[0].covariance[0]);
}

struct CameraStream {
  Levels raw;
  Levels filtered;
};

// The outdoor estimate from a noisy 8-bit camera's frames; the sun's share as given.
CameraStream SeeStream(double rate, int frames, const std::function<double(int)>& sun_share) {
  SyntheticPicture picture;
  picture.width = 96;
  picture.height = 72;
  const SurfaceView view = testing::MakeView(picture);
  const auto source = MakeOutdoorLightingSource({});
  std::mt19937_64 random(3);
  LightingFilter filter;
  std::vector<Lighting> raw;
  std::vector<Lighting> filtered;
  for (int i = 0; i < frames; ++i) {
    const TrueLight light = WithSun(sun_share(i));
    picture.sun = light.sun;
    picture.sky = light.sky;
    Frame frame = testing::SeenByCamera(testing::MakeFrame(picture, view), 0.006, random);
    frame.time = testing::StreamTime(i, rate);
    const auto estimate = source->Estimate(testing::Observe(frame, view));
    raw.push_back(estimate.value().lighting);
    filtered.push_back(filter.Apply(raw.back()).lighting);
  }
  return {LevelsOf(raw), LevelsOf(filtered)};
}

TEST(LightingFilter, SteadiesWhatACameraSees) {
  for (const double rate : kRates) {
    const CameraStream stream = SeeStream(rate, 60, [](int) { return 1.0; });
    EXPECT_LT(Flicker(stream.filtered.sun), 0.005);
    EXPECT_LT(Flicker(stream.filtered.sky), 0.005);
    EXPECT_LT(Flicker(stream.filtered.sun), 0.7 * Flicker(stream.raw.sun));
    EXPECT_LT(Flicker(stream.filtered.sky), 0.7 * Flicker(stream.raw.sky));
  }
}

TEST(LightingFilter, FollowsACloudThatACameraSees) {
  for (const double rate : kRates) {
    for (const Step& cloud : {Step{1.0, 0.15}, Step{0.15, 1.0}}) {
      const int step = 20;
      const CameraStream stream =
          SeeStream(rate, 50, [&](int i) { return i < step ? cloud.from : cloud.to; });
      for (const auto& [raw, filtered] : {std::pair{&stream.raw.sun, &stream.filtered.sun},
                                          {&stream.raw.sky, &stream.filtered.sky}}) {
        const double before = MeanOf(*raw, 10, step);
        const double after = MeanOf(*raw, step, 50);
        EXPECT_LT(std::abs((*filtered)[step + 2] - after), 0.1 * std::abs(after - before));
        EXPECT_NEAR(MeanOf(*filtered, step + 3, 50), after, 0.003 * after);
      }
    }
  }
}

// One frame has all the say: each is reported as it is.
TEST(LightingFilter, OfOneFrameIsThatFrame) {
  EstimateStream stream;
  LightingFilter filter({.most_frames = 1});
  for (const Lighting& raw : stream.Make(5, [](int) { return TrueLight(); })) {
    EXPECT_EQ(filter.Apply(raw).lighting.sun.irradiance_rgb, raw.sun.irradiance_rgb);
  }
}

TEST(LightingFilter, RefusesImpossibleOptions) {
  EXPECT_THROW(LightingFilter({.memory_s = 0.0}), std::invalid_argument);
  EXPECT_THROW(LightingFilter({.memory_s = std::nan("")}), std::invalid_argument);
  EXPECT_THROW(LightingFilter({.most_frames = 0}), std::invalid_argument);
  EXPECT_THROW(LightingFilter({.change_sigmas = -1.0}), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::lighting_filter_test
