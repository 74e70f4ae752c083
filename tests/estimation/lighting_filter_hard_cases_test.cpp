#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include "estimation/lighting_filter.h"
#include "tests/estimation/synthetic_stream.h"

namespace pleinair::lighting_filter_hard_cases_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::EstimateStream;
using testing::TrueLight;

bool SameLight(const Lighting& a, const Lighting& b) {
  for (std::size_t k = 0; k < a.sky.size(); ++k) {
    if (a.sky[k].irradiance_rgb != b.sky[k].irradiance_rgb) return false;
  }
  return a.sun.irradiance_rgb == b.sun.irradiance_rgb && a.covariance == b.covariance;
}

// Relative difference of the sun's red.
double SunOff(const Lighting& a, const Lighting& b) {
  return std::abs(a.sun.irradiance_rgb.x / b.sun.irradiance_rgb.x - 1.0);
}

TEST(LightingFilterHardCases, AFrameAfterAGapStandsAlone) {
  for (const auto gap : {milliseconds(2001), milliseconds(600'000), milliseconds(26 * 60'000)}) {
    EstimateStream stream;
    stream.noise = 0.02;
    auto raw = stream.Make(60, [](int) { return TrueLight(); });
    LightingFilter filter;
    for (std::size_t i = 0; i < 40; ++i) filter.Apply(raw[i]);
    for (std::size_t i = 40; i < raw.size(); ++i) {
      raw[i].time = raw[i - 1].time + gap;
      const FilteredLighting filtered = filter.Apply(raw[i]);
      EXPECT_TRUE(SameLight(filtered.lighting, raw[i]));
      EXPECT_EQ(filtered.sun.frames, 1);
      EXPECT_EQ(filtered.sky.frames, 1);
    }
  }
}

TEST(LightingFilterHardCases, OneBadFrameIsLeftOut) {
  for (const double factor : {0.0, 0.5, 1.3, 40.0}) {
    EstimateStream stream;
    stream.noise = 0.003;
    auto raw = stream.Make(60, [](int) { return TrueLight(); });
    auto clean = raw;
    raw[30].sun.irradiance_rgb *= factor;
    for (SkyComponent& sky : raw[30].sky) sky.irradiance_rgb *= factor;
    LightingFilter filter;
    for (std::size_t i = 0; i < raw.size(); ++i) {
      const FilteredLighting filtered = filter.Apply(raw[i]);
      EXPECT_EQ(filtered.sun.held, i == 30) << factor;
      EXPECT_EQ(filtered.sky.held, i == 30) << factor;
      if (i < 25) continue;
      EXPECT_LT(SunOff(filtered.lighting, clean[i]), 0.012) << factor << " " << i;
      if (i == 30) {
        // What is held may yet be true, and the deviation says so.
        const double off = raw[i].sun.irradiance_rgb.x - filtered.lighting.sun.irradiance_rgb.x;
        EXPECT_GE(filtered.lighting.covariance[0], off * off);
      }
    }
  }
}

// The surfaces show it, too: a camera that states a new exposure a frame late.
TEST(LightingFilterHardCases, AWrongExposureIsHeldThoughAllSurfacesShowIt) {
  EstimateStream stream;
  stream.noise = 0.003;
  auto raw = stream.Make(60, [](int) { return TrueLight(); });
  const auto clean = raw;
  const auto factor_of = [](std::size_t i) { return i == 30 ? 2.0 : 1.0; };
  raw[30].sun.irradiance_rgb *= factor_of(30);
  for (SkyComponent& sky : raw[30].sky) sky.irradiance_rgb *= factor_of(30);
  LightingFilter filter;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    FrameFit fit;
    if (i > 0) {
      const TrueLight light;
      fit.change = {factor_of(i - 1) * light.sun,
                    factor_of(i - 1) * light.sky,
                    factor_of(i) * light.sun,
                    factor_of(i) * light.sky,
                    0.001 * light.sun,
                    0.001 * light.sky,
                    glm::dvec3(0.0)};
    }
    const FilteredLighting filtered = filter.Apply(raw[i], LightUnits::kAbsolute, fit);
    EXPECT_EQ(filtered.sun.held, i == 30) << i;
    if (i >= 25) {
      EXPECT_LT(SunOff(filtered.lighting, clean[i]), 0.012) << i;
    }
  }
}

// Every fourth frame is bad, and each time another way.
TEST(LightingFilterHardCases, FrequentBadFramesAreLeftOut) {
  EstimateStream stream;
  stream.noise = 0.003;
  auto raw = stream.Make(80, [](int) { return TrueLight(); });
  const auto clean = raw;
  for (std::size_t i = 20; i < 80; i += 4) {
    raw[i].sun.irradiance_rgb *= i % 8 == 0 ? 0.4 : 2.0;
  }
  LightingFilter filter;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const FilteredLighting filtered = filter.Apply(raw[i]);
    if (i >= 10) {
      EXPECT_LT(SunOff(filtered.lighting, clean[i]), 0.012) << i;
    }
  }
}

constexpr double kMisfit = 0.04;

// Half a second of frames that fit their model three times less well, as badly posed ones do. They
// are all wrong in the same way.
TEST(LightingFilterHardCases, FramesThatFitLessMoveNothing) {
  EstimateStream stream;
  stream.noise = 0.01;
  auto raw = stream.Make(90, [](int) { return TrueLight(); });
  const auto clean = raw;
  const auto is_bad = [](std::size_t i) { return i >= 40 && i < 55; };
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (!is_bad(i)) continue;
    raw[i].sun.irradiance_rgb *= 1.02;
    for (SkyComponent& sky : raw[i].sky) sky.irradiance_rgb *= 0.96;
  }
  LightingFilter filter;
  LightingFilter undisturbed;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const FilteredLighting filtered =
        filter.Apply(raw[i], LightUnits::kAbsolute, {is_bad(i) ? 3.0 * kMisfit : kMisfit});
    const FilteredLighting expected = undisturbed.Apply(clean[i], LightUnits::kAbsolute, {kMisfit});
    EXPECT_LT(SunOff(filtered.lighting, expected.lighting), 0.004) << i;
    EXPECT_NEAR(
        filtered.lighting.SkyIrradianceRgb().x / expected.lighting.SkyIrradianceRgb().x, 1.0, 0.01)
        << i;
  }
}

// But a cloud in just these frames is followed like any other, at whatever deviation and level of
// the light; a small change too, once half of what the filter remembers is such frames.
TEST(LightingFilterHardCases, FramesThatFitLessFollowACloud) {
  for (const double deviation : {0.03, 0.26}) {
    for (const double misfit : {1.1 * kMisfit, 3.0 * kMisfit, 4.9 * kMisfit}) {
      for (const std::pair<double, double>& shares : {std::pair{1.0, 0.5},
                                                      std::pair{0.5, 1.0},
                                                      std::pair{0.2, 0.02},
                                                      std::pair{0.02, 0.2},
                                                      std::pair{1.0, 0.95}}) {
        const double from = shares.first;
        const double to = shares.second;
        EstimateStream stream;
        stream.noise = 0.003;
        stream.stated_deviation = deviation;
        const auto raw = stream.Make(130, [&](int i) {
          TrueLight light;
          light.sun *= i < 50 ? from : to;
          return light;
        });
        const std::size_t followed = std::max(from, to) < 2.0 * std::min(from, to) ? 80 : 52;
        LightingFilter filter;
        for (std::size_t i = 0; i < raw.size(); ++i) {
          const FilteredLighting filtered =
              filter.Apply(raw[i], LightUnits::kAbsolute, {i < 45 ? kMisfit : misfit});
          if (i <= followed) continue;
          EXPECT_LT(SunOff(filtered.lighting, raw[i]), 0.015)
              << deviation << " " << misfit << " " << from << " " << to << " " << i;
        }
      }
    }
  }
}

// A hand before the lens, a wrong pose: what such frames show is no light of the scene, and their
// end is no change of it.
TEST(LightingFilterHardCases, FramesThatDoNotFitAtAllChangeNothing) {
  for (const LightUnits units : {LightUnits::kAbsolute, LightUnits::kRelativePerFrame}) {
    for (const double factor : {0.0, 0.2, 6.0}) {
      EstimateStream stream;
      stream.noise = 0.01;
      auto raw = stream.Make(90, [](int) { return TrueLight(); });
      const auto clean = raw;
      const auto is_bad = [](std::size_t i) { return i >= 40 && i < 55; };
      LightingFilter filter;
      LightingFilter undisturbed;
      for (std::size_t i = 0; i < raw.size(); ++i) {
        if (is_bad(i)) {
          raw[i].sun.irradiance_rgb *= 0.0;
          for (SkyComponent& sky : raw[i].sky) sky.irradiance_rgb *= factor;
        }
        const FilteredLighting filtered = filter.Apply(raw[i], units, {is_bad(i) ? 0.5 : kMisfit});
        const FilteredLighting expected = undisturbed.Apply(clean[i], units, {kMisfit});
        EXPECT_EQ(filtered.sun.held, is_bad(i)) << i;
        EXPECT_EQ(filtered.sky.held, is_bad(i)) << i;
        const auto ratio = [](const FilteredLighting& light) {
          return light.lighting.sun.irradiance_rgb.x / light.lighting.SkyIrradianceRgb().x;
        };
        if (factor > 0.0 || !is_bad(i)) {
          EXPECT_NEAR(ratio(filtered) / ratio(expected), 1.0, 0.02) << i;
        }
        if (is_bad(i) && units == LightUnits::kAbsolute) {
          EXPECT_LT(SunOff(filtered.lighting, expected.lighting), 0.01) << i;
          EXPECT_GT(std::sqrt(filtered.lighting.covariance[0]),
                    0.9 * expected.lighting.sun.irradiance_rgb.x)
              << "both answers are possible";
        }
      }
    }
  }
}

// But not for ever: after nearly 2 s hardly anything else is remembered. The light that then comes
// back is a step like any other.
TEST(LightingFilterHardCases, FramesThatDoNotFitAreTheLightOnceNoOtherIsRemembered) {
  EstimateStream stream;
  stream.noise = 0.01;
  const auto raw = stream.Make(180, [](int i) {
    TrueLight light;
    if (i >= 40 && i < 140) light.sun *= 0.1;
    return light;
  });
  LightingFilter filter;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const bool is_bad = i >= 40 && i < 140;
    const FilteredLighting filtered =
        filter.Apply(raw[i], LightUnits::kAbsolute, {is_bad ? 0.5 : kMisfit});
    const bool is_misfit = i >= 40 && i < 98;
    EXPECT_EQ(filtered.sun.held, is_misfit || i == 140) << i;
    EXPECT_LT(SunOff(filtered.lighting, is_misfit ? raw[0] : raw[i == 140 ? 139 : i]), 0.1) << i;
  }
}

// Nor is one frame enough, that fits by chance, to hold others: at a site whose mesh lacks much, or
// at the start. And guessed albedos leave a residual that is to be trusted.
TEST(LightingFilterHardCases, OneFrameThatFitsByChanceHoldsNoOthers) {
  EstimateStream stream;
  stream.noise = 0.01;
  const auto raw = stream.Make(90, [](int) { return TrueLight(); });
  LightingFilter filter;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const bool fits = i == 0 || i == 40;
    EXPECT_FALSE(filter.Apply(raw[i], LightUnits::kAbsolute, {fits ? 0.05 : 0.4}).sun.held) << i;
  }
  LightingFilter of_guesses;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const double misfit = i < 40 ? 0.1 : 0.25;
    EXPECT_FALSE(of_guesses.Apply(raw[i], LightUnits::kAbsolute, {misfit, 0.3}).sun.held) << i;
  }
}

// Two frames that are swapped: the late one is reported as it is, the others are as if it had never
// been.
TEST(LightingFilterHardCases, ALateFrameChangesNothing) {
  EstimateStream stream;
  stream.noise = 0.01;
  const auto raw = stream.Make(40, [](int) { return TrueLight(); });
  LightingFilter with;
  LightingFilter without;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (i % 10 == 8) continue;  // Comes after the next one.
    EXPECT_TRUE(SameLight(with.Apply(raw[i]).lighting, without.Apply(raw[i]).lighting));
    if (i % 10 == 9) {
      EXPECT_TRUE(SameLight(with.Apply(raw[i - 1]).lighting, raw[i - 1]));
    }
  }
}

TEST(LightingFilterHardCases, AClockThatIsSetBackRestartsIt) {
  for (const auto back : {milliseconds(500), milliseconds(3'600'000)}) {
    EstimateStream stream;
    stream.noise = 0.01;
    auto raw = stream.Make(60, [](int) { return TrueLight(); });
    for (std::size_t i = 30; i < raw.size(); ++i) raw[i].time -= back;
    LightingFilter filter;
    int frames = 0;
    for (std::size_t i = 0; i < raw.size(); ++i) frames = filter.Apply(raw[i]).sun.frames;
    EXPECT_GE(frames, 25);  // Those of the last second, but for the first two after it.
    EXPECT_LE(frames, 30);
  }
}

TEST(LightingFilterHardCases, FramesOfOneTimeAreInOrder) {
  EstimateStream stream;
  auto raw = stream.Make(20, [](int) { return TrueLight(); });
  for (Lighting& lighting : raw) lighting.time = raw[0].time;
  LightingFilter filter;
  int frames = 0;
  for (const Lighting& lighting : raw) frames = filter.Apply(lighting).sun.frames;
  EXPECT_GE(frames, 15);
}

// Frames that failed are not there at all: a second without them is a gap in the run, no more.
TEST(LightingFilterHardCases, FailedFramesAreBridged) {
  EstimateStream stream;
  stream.noise = 0.01;
  const auto raw = stream.Make(60, [](int) { return TrueLight(); });
  LightingFilter filter;
  for (std::size_t i = 0; i < 20; ++i) filter.Apply(raw[i]);
  EXPECT_GE(filter.Apply(raw[50]).sun.frames, 10);
}

TEST(LightingFilterHardCases, OvercastStaysAtNoSun) {
  EstimateStream stream;
  stream.noise = 0.02;
  TrueLight overcast;
  overcast.sun = glm::dvec3(0.0);
  const auto raw = stream.Make(200, [&](int) { return overcast; });
  LightingFilter filter;
  for (const Lighting& lighting : raw) {
    const Lighting filtered = filter.Apply(lighting).lighting;
    for (int c = 0; c < 3; ++c) {
      EXPECT_GE(filtered.sun.irradiance_rgb[c], 0.0);
      EXPECT_LE(filtered.sun.irradiance_rgb[c], 0.02 * overcast.sky[c]);
    }
  }
}

// Whatever comes: no negative light, no share outside those of the frames, no indefinite
// covariance.
TEST(LightingFilterHardCases, NeverNegativeAndNeverIndefinite) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform;
  for (int run = 0; run < 50; ++run) {
    LightingFilter filter;
    UtcTime time{};
    double level = 100.0;
    for (int i = 0; i < 60; ++i) {
      if (uniform(random) < 0.1) level = std::pow(10.0, 6.0 * uniform(random) - 3.0);
      time += milliseconds(uniform(random) < 0.05 ? -50 : static_cast<int>(100 * uniform(random)));
      Lighting raw;
      raw.time = time;
      raw.sun.direction_enu = testing::SyntheticSunDirection();
      raw.sky = {{"uniform", {}}, {"clear", {}}};
      Eigen::Matrix<double, 9, 9> root;
      for (int u = 0; u < 9; ++u) {
        double value = uniform(random) < 0.2 ? 0.0 : level * uniform(random);
        (u < 3 ? raw.sun.irradiance_rgb
               : raw.sky[static_cast<std::size_t>(u / 3 - 1)].irradiance_rgb)[u % 3] = value;
        for (int v = 0; v < 9; ++v) root(u, v) = 0.1 * level * (uniform(random) - 0.5);
      }
      const Eigen::Matrix<double, 9, 9> covariance = root * root.transpose();
      raw.covariance.assign(covariance.data(), covariance.data() + 81);
      const auto units = run % 2 == 0 ? LightUnits::kAbsolute : LightUnits::kRelativePerFrame;
      const Lighting filtered = filter.Apply(raw, units).lighting;
      double largest = 0.0;
      for (int c = 0; c < 3; ++c) {
        EXPECT_GE(filtered.sun.irradiance_rgb[c], 0.0);
        for (const SkyComponent& sky : filtered.sky) EXPECT_GE(sky.irradiance_rgb[c], 0.0);
        largest = std::max(largest, filtered.covariance[static_cast<std::size_t>(c) * 10]);
      }
      EXPECT_TRUE(std::isfinite(filtered.SkyIrradianceRgb().x + filtered.sun.irradiance_rgb.x));
      const Eigen::Map<const Eigen::Matrix<double, 9, 9>> matrix(filtered.covariance.data());
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> eigen(matrix);
      EXPECT_GE(eigen.eigenvalues().minCoeff(), -1e-9 * eigen.eigenvalues().maxCoeff());
    }
  }
}

TEST(LightingFilterHardCases, IsFreeOfScale) {
  EstimateStream stream;
  const auto raw = stream.Make(60, [](int i) {
    TrueLight light;
    light.sun *= i < 30 ? 1.0 : 0.3;
    return light;
  });
  LightingFilter reference;
  LightingFilter scaled;
  for (const Lighting& lighting : raw) {
    Lighting larger = lighting;
    larger.sun.irradiance_rgb *= 1e8;
    for (SkyComponent& sky : larger.sky) sky.irradiance_rgb *= 1e8;
    for (double& value : larger.covariance) value *= 1e16;
    const double sun = reference.Apply(lighting).lighting.sun.irradiance_rgb.y;
    EXPECT_NEAR(scaled.Apply(larger).lighting.sun.irradiance_rgb.y * 1e-8, sun, 1e-9 * sun);
  }
}

// Exposure doubles, and white balance changes with it: the shares of the light don't move, its size
// is the picture's.
TEST(LightingFilterHardCases, AnUnknownExposureIsNoChangeOfLight) {
  EstimateStream stream;
  stream.noise = 0.003;
  auto raw = stream.Make(90, [](int) { return TrueLight(); });
  const auto ratio = [](const Lighting& lighting) {
    return lighting.sun.irradiance_rgb / lighting.SkyIrradianceRgb();
  };
  LightingFilter filter;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const glm::dvec3 gain = i < 30   ? glm::dvec3(1e-3)
                            : i < 60 ? glm::dvec3(2e-3)
                                     : glm::dvec3(2.2e-3, 2e-3, 1.7e-3);
    raw[i].sun.irradiance_rgb *= gain;
    for (SkyComponent& sky : raw[i].sky) sky.irradiance_rgb *= gain;
    for (std::size_t u = 0; u < 9; ++u) {
      for (std::size_t v = 0; v < 9; ++v) {
        raw[i].covariance[u * 9 + v] *=
            gain[static_cast<int>(u % 3)] * gain[static_cast<int>(v % 3)];
      }
    }
    const FilteredLighting filtered = filter.Apply(raw[i], LightUnits::kRelativePerFrame);
    EXPECT_FALSE(filtered.sun.held || filtered.sky.held) << i;
    EXPECT_EQ(filtered.sun.frames, static_cast<int>(std::min<std::size_t>(i + 1, 61))) << i;
    const double up = raw[i].sun.direction_enu.z;
    for (int c = 0; c < 3; ++c) {
      const double total = up * raw[i].sun.irradiance_rgb[c] + raw[i].SkyIrradianceRgb()[c];
      EXPECT_NEAR(
          up * filtered.lighting.sun.irradiance_rgb[c] + filtered.lighting.SkyIrradianceRgb()[c],
          total,
          1e-12 * total);
      if (i >= 10) {
        EXPECT_NEAR(ratio(filtered.lighting)[c] / ratio(raw[5])[c], 1.0, 0.02) << i;
      }
    }
  }
}

// A cloud under an exposure that makes up for it: the split of the light changes, and is followed.
TEST(LightingFilterHardCases, ACloudIsSeenWhateverTheExposureDoes) {
  EstimateStream stream;
  stream.noise = 0.003;
  auto raw = stream.Make(60, [](int i) {
    TrueLight light;
    light.sun *= i < 30 ? 1.0 : 0.2;
    return light;
  });
  LightingFilter filter;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const double gain = 1.0 / raw[i].SkyIrradianceRgb().y / (i < 30 ? 5.0 : 2.0);
    raw[i].sun.irradiance_rgb *= gain;
    for (SkyComponent& sky : raw[i].sky) sky.irradiance_rgb *= gain;
    for (double& value : raw[i].covariance) value *= gain * gain;
    const Lighting filtered = filter.Apply(raw[i], LightUnits::kRelativePerFrame).lighting;
    if (i >= 32) {
      EXPECT_NEAR(filtered.sun.irradiance_rgb.x / raw[i].sun.irradiance_rgb.x, 1.0, 0.02);
    }
  }
}

TEST(LightingFilterHardCases, OtherSkyShapesOrUnitsRestartIt) {
  EstimateStream stream;
  stream.noise = 0.01;
  auto raw = stream.Make(40, [](int) { return TrueLight(); });
  LightingFilter filter;
  for (std::size_t i = 0; i < 20; ++i) filter.Apply(raw[i]);
  EXPECT_EQ(filter.Apply(raw[20], LightUnits::kRelativePerFrame).sun.frames, 1);
  raw[21].sky[1].shape = "clear";
  EXPECT_EQ(filter.Apply(raw[21], LightUnits::kRelativePerFrame).sun.frames, 1);
  raw[22].sky.pop_back();
  raw[22].covariance.clear();  // Cannot know.
  const FilteredLighting alone = filter.Apply(raw[22], LightUnits::kRelativePerFrame);
  EXPECT_EQ(alone.sun.frames, 1);
  EXPECT_TRUE(alone.lighting.covariance.empty());
}

TEST(LightingFilterHardCases, WhatIsNotFiniteIsPassedOn) {
  EstimateStream stream;
  auto raw = stream.Make(20, [](int) { return TrueLight(); });
  LightingFilter filter;
  for (std::size_t i = 0; i < 20; ++i) {
    Lighting bad = raw[i];
    bad.sun.irradiance_rgb.y = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(std::isnan(filter.Apply(bad).lighting.sun.irradiance_rgb.y));
    EXPECT_TRUE(std::isfinite(filter.Apply(raw[i]).lighting.sun.irradiance_rgb.y));
  }
}

TEST(LightingFilterHardCases, DarknessIsADefinedAnswer) {
  EstimateStream stream;
  TrueLight dark;
  dark.sun = dark.sky = glm::dvec3(0.0);
  const auto raw = stream.Make(20, [&](int) { return dark; });
  for (const auto units : {LightUnits::kAbsolute, LightUnits::kRelativePerFrame}) {
    LightingFilter filter;
    for (const Lighting& lighting : raw) {
      const FilteredLighting filtered = filter.Apply(lighting, units);
      EXPECT_EQ(filtered.lighting.sun.irradiance_rgb, glm::dvec3(0.0));
      EXPECT_EQ(filtered.lighting.SkyIrradianceRgb(), glm::dvec3(0.0));
    }
  }
}

}  // namespace
}  // namespace pleinair::lighting_filter_hard_cases_test
