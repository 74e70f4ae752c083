#include "relight/daylight/window_sampling.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "relight/transport/transport.h"
#include "scene/low_discrepancy.h"
#include "scene/ray_caster.h"
#include "tests/relight/seed_spread.h"
#include "tests/relight/window_rooms.h"

namespace pleinair::window_sampling_test {
namespace {

using ::testing::HasSubstr;

const BoundingSphere kObject{{3.2, 2.2, 0.5}, 0.35};

// Blue overhead, white low down, twice as bright to the south-west, and a spot 3 deg wide that
// outshines all the rest: a sun behind thin cloud. It stands above the
// window's cone, and lights the floor before the window.
std::vector<glm::vec3> SkyWithASpot(float spot = 3000.0f) {
  const glm::dvec3 sun = glm::normalize(glm::dvec3(-0.2, -1.0, 1.3));
  std::vector<glm::vec3> sky(SkyTable::kCells);
  for (std::size_t cell = 0; cell < sky.size(); ++cell) {
    const glm::dvec3 d = SkyTable::DirectionOfCell(cell);
    const auto low = static_cast<float>(1.0 - d.z);
    const auto turned = static_cast<float>(1.5 - 0.35 * (d.x + d.y));
    sky[cell] = turned * (glm::vec3(0.5f, 0.8f, 1.6f) + low * glm::vec3(1.5f, 1.3f, 0.8f));
    if (glm::dot(sun, d) > std::cos(1.5 * std::numbers::pi / 180.0)) {
      sky[cell] += spot * glm::vec3(1.0f, 0.9f, 0.7f);
    }
  }
  return sky;
}

std::vector<Receiver> OnObject(int count) {
  std::vector<Receiver> receivers;
  for (int i = 0; i < count; ++i) {
    const glm::dvec2 at = FibonacciPoint(i, count, {0.0, 0.0});
    const double z = 1.0 - 2.0 * at.x;
    const glm::dvec3 normal(std::sqrt(1.0 - z * z) * std::cos(2.0 * std::numbers::pi * at.y),
                            std::sqrt(1.0 - z * z) * std::sin(2.0 * std::numbers::pi * at.y),
                            z);
    receivers.push_back(
        {glm::vec3(kObject.centre_m + kObject.radius_m * normal), glm::vec3(normal)});
  }
  return receivers;
}

glm::dvec3 FromSample(const RayCaster& caster,
                      const Receiver& receiver,
                      const glm::vec3& direction,
                      const glm::vec3& irradiance) {
  const float cosine = glm::dot(receiver.normal, direction);
  if (!(cosine > 0.0f) || caster.Occluded(receiver.position_m, direction)) return glm::dvec3(0.0);
  return static_cast<double>(cosine) * glm::dvec3(irradiance);
}

glm::dvec3 FromSamples(const RayCaster& caster,
                       const Receiver& receiver,
                       const DaylightSamples& drawn) {
  glm::dvec3 sum(0.0);
  for (const DaylightSample& sample : drawn.samples) {
    sum += FromSample(caster, receiver, sample.direction_enu, sample.irradiance_rgb);
  }
  return sum;
}

// Nine points of every cell of the entire sky.
glm::dvec3 Reference(const RayCaster& caster,
                     const Receiver& receiver,
                     const std::vector<glm::vec3>& sky) {
  glm::dvec3 sum(0.0);
  for (std::size_t cell = 0; cell < sky.size(); ++cell) {
    const auto part = static_cast<float>(SkyTable::SolidAngleSr(cell) / 9.0);
    if (part == 0.0f || sky[cell] == glm::vec3(0.0f)) continue;
    const double column = static_cast<double>(cell % SkyTable::kSide);
    const double row = static_cast<double>(cell / SkyTable::kSide);
    for (int i = 0; i < 9; ++i) {
      const double x = (column + (i % 3 + 0.5) / 3.0) * 2.0 / SkyTable::kSide - 1.0;
      const double y = (row + (i / 3 + 0.5) / 3.0) * 2.0 / SkyTable::kSide - 1.0;
      const double radius2 = x * x + y * y;
      if (!(radius2 < 1.0)) continue;
      const double level = std::sqrt(2.0 - radius2);
      sum += FromSample(
          caster, receiver, glm::vec3(level * x, level * y, 1.0 - radius2), part * sky[cell]);
    }
  }
  return sum;
}

struct LitRoom {
  const RayCaster& caster;
  std::span<const Window> windows;
  std::span<const Receiver> receivers;
};

SeedSpread SpreadOf(const LitRoom& room,
                    const std::vector<glm::vec3>& sky,
                    const DaylightSamplingOptions& options,
                    int seeds) {
  return SpreadOverSeeds(
      {room.windows, kObject, sky}, options, seeds, [&](const DaylightSamples& drawn) {
        std::vector<double> values;
        for (const Receiver& receiver : room.receivers) {
          const glm::dvec3 rgb = FromSamples(room.caster, receiver, drawn);
          values.push_back(rgb.x + rgb.y + rgb.z);
        }
        return values;
      });
}

// The solid angle of the sky that may reach the object: its light under a sky of radiance 1.
float OpenSolidAngleSr(const DaylightSampler& sampler) {
  return sampler.LargestIrradiance(std::vector<glm::vec3>(SkyTable::kCells, glm::vec3(1.0f))).x;
}

double MeanReference(const RayCaster& caster,
                     std::span<const Receiver> receivers,
                     const std::vector<glm::vec3>& sky) {
  double mean = 0.0;
  for (const Receiver& receiver : receivers) {
    const glm::dvec3 rgb = Reference(caster, receiver, sky);
    mean += (rgb.x + rgb.y + rgb.z) / static_cast<double>(receivers.size());
  }
  return mean;
}

class WindowSampling : public ::testing::Test {
 protected:
  const RayCaster room_{SheetRoom({kSouthHole})};
  const std::vector<Window> windows_{SouthWindow(kSouthHole)};
  const std::vector<glm::vec3> sky_ = SkyWithASpot();
  const std::vector<Receiver> receivers_ = OnObject(12);
  const LitRoom lit_room_{room_, windows_, receivers_};
};

// The bar: an object in shade gets at least 4 times less variance at equal samples, and a mean
// within 1 % of the converged one. 1 % is 3 standard deviations of the mean over seeds here.
TEST_F(WindowSampling, HasAQuarterOfTheVarianceOrLessInShade) {
  const double reference = MeanReference(room_, receivers_, sky_);
  const SeedSpread windows =
      SpreadOf(lit_room_, sky_, {.samples = 64, .restriction = DaylightRestriction::kWindows}, 100);
  const SeedSpread whole = SpreadOf(
      lit_room_, sky_, {.samples = 64, .restriction = DaylightRestriction::kWholeSky}, 100);
  EXPECT_NEAR(windows.mean, reference, 0.01 * reference);
  EXPECT_LT(3.0 * windows.MeanStddev(receivers_.size()), 0.01 * reference);
  EXPECT_GE(whole.variance, 4.0 * windows.variance);
  RecordProperty("variance_ratio", std::to_string(whole.variance / windows.variance));
  RecordProperty("mean_ratio", std::to_string(windows.mean / reference));
}

// The same without the spot: importance alone does not do it.
TEST_F(WindowSampling, HasAQuarterOfTheVarianceOrLessUnderAnEvenSky) {
  const std::vector<glm::vec3> sky = SkyWithASpot(0.0f);
  const SeedSpread windows =
      SpreadOf(lit_room_, sky, {.samples = 64, .restriction = DaylightRestriction::kWindows}, 60);
  const SeedSpread whole =
      SpreadOf(lit_room_, sky, {.samples = 64, .restriction = DaylightRestriction::kWholeSky}, 60);
  EXPECT_GE(whole.variance, 4.0 * windows.variance);
}

// Each setting estimates one and the same light: to 4 standard deviations of its own mean, and 0.5
// % for the reference's grid in a cell at the windows' rims.
TEST_F(WindowSampling, HasTheSameMeanBySetting) {
  const std::vector<glm::vec3> sky = SkyWithASpot(0.0f);
  const double reference = MeanReference(room_, receivers_, sky);
  for (const auto restriction : {DaylightRestriction::kWindows,
                                 DaylightRestriction::kRejection,
                                 DaylightRestriction::kWholeSky}) {
    const SeedSpread spread =
        SpreadOf(lit_room_, sky, {.samples = 64, .restriction = restriction}, 60);
    EXPECT_NEAR(
        spread.mean, reference, 4.0 * spread.MeanStddev(receivers_.size()) + 0.005 * reference)
        << static_cast<int>(restriction);
  }
}

// A sun that comes out behind the wall: what is seen through the window does not change, and its
// samples don't. Rejection has thrown its draws again.
TEST_F(WindowSampling, DoesNotFlickerWithASkyThatIsNotSeen) {
  const std::vector<glm::vec3> dim = SkyWithASpot(0.0f);
  const auto largest_move = [&](DaylightRestriction restriction) {
    const DaylightSampler sampler(windows_, kObject, {.restriction = restriction});
    const DaylightSamples before = sampler.Draw(dim);
    const DaylightSamples after = sampler.Draw(sky_);
    float largest = 0.0f;
    for (std::size_t i = 0; i < before.samples.size(); ++i) {
      largest = std::max(
          largest, glm::distance(before.samples[i].direction_enu, after.samples[i].direction_enu));
    }
    return largest;
  };
  EXPECT_EQ(largest_move(DaylightRestriction::kWindows), 0.0f);
  EXPECT_GT(largest_move(DaylightRestriction::kRejection), 0.1f);
}

TEST_F(WindowSampling, IsUnbiasedForAnyNumberOfSamples) {
  const std::vector<glm::vec3> sky = SkyWithASpot(0.0f);
  const double reference = MeanReference(room_, receivers_, sky);
  for (const int samples : {1, 2, 7, 256}) {
    const int seeds = std::max(10, 400 / samples);
    const SeedSpread spread = SpreadOf(
        lit_room_, sky, {.samples = samples, .restriction = DaylightRestriction::kWindows}, seeds);
    EXPECT_NEAR(
        spread.mean, reference, 4.0 * spread.MeanStddev(receivers_.size()) + 0.005 * reference)
        << samples;
  }
}

// Samples in low discrepancy: independent ones would gain a factor of 4.
TEST_F(WindowSampling, FallsFasterThanOneOverTheNumberOfSamples) {
  const std::vector<glm::vec3> sky = SkyWithASpot(0.0f);
  const auto variance = [&](int samples) {
    return SpreadOf(lit_room_,
                    sky,
                    {.samples = samples, .restriction = DaylightRestriction::kWindows},
                    60)
        .variance;
  };
  EXPECT_GT(variance(32), 6.0 * variance(128));
}

TEST_F(WindowSampling, CountsASkySeenThroughTwoWindowsOnce) {
  const std::vector<glm::vec3> sky = SkyWithASpot(0.0f);
  // The window, its left half and its right half again.
  std::vector<Window> overlapping = windows_;
  const float middle = 0.5f * (kSouthHole.lower.x + kSouthHole.upper.x);
  overlapping.push_back(SouthWindow({kSouthHole.lower, {middle, kSouthHole.upper.y}}));
  overlapping.push_back(SouthWindow({{middle, kSouthHole.lower.y}, kSouthHole.upper}));
  const DaylightSampler once(windows_, kObject, {});
  const DaylightSampler thrice(overlapping, kObject, {});
  EXPECT_EQ(OpenSolidAngleSr(once), OpenSolidAngleSr(thrice));
  EXPECT_DOUBLE_EQ(once.Draw(sky).sky_share, thrice.Draw(sky).sky_share);
}

TEST_F(WindowSampling, AddsUpSeveralWindows) {
  const RayCaster room(SheetRoom({kSouthHole}, {kEastHole}));
  const std::vector<Window> windows{SouthWindow(kSouthHole), EastWindow(kEastHole)};
  const std::vector<glm::vec3> sky = SkyWithASpot(0.0f);
  const double reference = MeanReference(room, receivers_, sky);
  const SeedSpread spread = SpreadOf({room, windows, receivers_},
                                     sky,
                                     {.samples = 64, .restriction = DaylightRestriction::kWindows},
                                     40);
  EXPECT_NEAR(
      spread.mean, reference, 4.0 * spread.MeanStddev(receivers_.size()) + 0.005 * reference);
}

// No daylight is missing: whatever direction reaches the sky from anywhere in the sphere is kept.
// Spheres before the window, beside it against the same wall, below it, and in its opening.
TEST_F(WindowSampling, KeepsEveryDirectionThatCanReachTheObject) {
  std::vector<glm::vec3> sky(SkyTable::kCells, glm::vec3(0.0f));
  for (const BoundingSphere& object : {kObject,
                                       BoundingSphere{{4.2, 0.3, 1.2}, 0.29},
                                       BoundingSphere{{1.9, 0.35, 0.4}, 0.3},
                                       BoundingSphere{{0.9, 0.4, 1.5}, 0.35},
                                       BoundingSphere{{1.9, 0.1, 1.5}, 0.3}}) {
    const DaylightSampler sampler(windows_, object, {.samples = 1});
    int reached = 0;
    for (int i = 0; i < 20000; ++i) {
      const std::uint64_t bits = HashBits(static_cast<std::uint64_t>(i));
      const glm::dvec2 a = RotationOf(bits, 1);
      const glm::dvec2 b = RotationOf(bits, 2);
      const double z = 2.0 * a.x - 1.0;
      const glm::dvec3 off(std::sqrt(1.0 - z * z) * std::cos(2.0 * std::numbers::pi * a.y),
                           std::sqrt(1.0 - z * z) * std::sin(2.0 * std::numbers::pi * a.y),
                           z);
      const glm::vec3 from(object.centre_m + object.radius_m * off);
      if (from.y < 0.01f) continue;
      const double rise = b.x;
      const glm::vec3 direction(std::sqrt(1.0 - rise * rise) * std::cos(6.283185307 * b.y),
                                std::sqrt(1.0 - rise * rise) * std::sin(6.283185307 * b.y),
                                rise);
      if (room_.Occluded(from, direction)) continue;
      ++reached;
      const std::size_t cell = SkyTable::CellOf(direction);
      if (SkyTable::SolidAngleSr(cell) == 0.0) continue;
      sky[cell] = glm::vec3(1.0f);
      EXPECT_TRUE(sampler.Draw(sky).why_none.empty())
          << object.centre_m.x << " " << direction.x << " " << direction.y << " " << direction.z;
      sky[cell] = glm::vec3(0.0f);
      if (reached == 200) break;
    }
    EXPECT_GT(reached, 20);
  }
}

TEST_F(WindowSampling, RestrictsTheSkyToLittleMoreThanTheWindowsCone) {
  const DaylightSampler sampler(windows_, kObject, {});
  // The window as seen from the object's centre, and a band around it as wide as the object seen
  // from the window (0.35 m in 2.2 m).
  EXPECT_LT(OpenSolidAngleSr(sampler), 1.2f);
  EXPECT_GT(OpenSolidAngleSr(sampler), 0.3f);
  const DaylightSampler whole(windows_, kObject, {.restriction = DaylightRestriction::kWholeSky});
  // Cells at the rim of the table count completely or not at all.
  EXPECT_NEAR(OpenSolidAngleSr(whole), 2.0 * std::numbers::pi, 1e-3);
}

TEST_F(WindowSampling, HasNoSampleWithoutAWindowAndSaysWhy) {
  for (const auto restriction : {DaylightRestriction::kWindows, DaylightRestriction::kRejection}) {
    const DaylightSamples drawn =
        DaylightSampler({}, kObject, {.restriction = restriction}).Draw(sky_);
    EXPECT_TRUE(drawn.samples.empty());
    EXPECT_THAT(drawn.why_none, HasSubstr("no window"));
    EXPECT_EQ(drawn.sky_share, 0.0);
  }
}

TEST_F(WindowSampling, HasNoSampleUnderABlackSkyAndSaysWhy) {
  std::vector<glm::vec3> sky(SkyTable::kCells, glm::vec3(0.0f));
  const DaylightSampler sampler(windows_, kObject, {});
  EXPECT_THAT(sampler.Draw(sky).why_none, HasSubstr("black"));
  // Light to the north alone: none of it through the window.
  for (std::size_t cell = 0; cell < sky.size(); ++cell) {
    if (SkyTable::DirectionOfCell(cell).y > 0.5) sky[cell] = glm::vec3(1.0f);
  }
  EXPECT_THAT(sampler.Draw(sky).why_none, HasSubstr("black"));
}

// One cell that shines: every sample goes there, and they add up to its light.
TEST_F(WindowSampling, FindsASingleBrightCell) {
  std::vector<glm::vec3> sky(SkyTable::kCells, glm::vec3(0.0f));
  const glm::dvec3 to_window = glm::normalize(glm::dvec3(1.9, 0.0, 1.9) - kObject.centre_m);
  const std::size_t cell = SkyTable::CellOf(glm::vec3(to_window));
  sky[cell] = glm::vec3(1e6f, 2e6f, 0.0f);
  for (const auto restriction : {DaylightRestriction::kWindows,
                                 DaylightRestriction::kRejection,
                                 DaylightRestriction::kWholeSky}) {
    const DaylightSamples drawn =
        DaylightSampler(windows_, kObject, {.samples = 16, .restriction = restriction}).Draw(sky);
    ASSERT_EQ(drawn.samples.size(), 16u);
    glm::dvec3 sum(0.0);
    for (const DaylightSample& sample : drawn.samples) {
      sum += glm::dvec3(sample.irradiance_rgb);
      EXPECT_EQ(SkyTable::CellOf(sample.direction_enu), cell);
      EXPECT_NEAR(glm::length(sample.direction_enu), 1.0f, 1e-6f);
    }
    // Float sums of 16 terms.
    EXPECT_NEAR(sum.y / (2e6 * SkyTable::SolidAngleSr(cell)), 1.0, 1e-5);
    EXPECT_EQ(sum.z, 0.0);
    EXPECT_NEAR(drawn.sky_share, 1.0, 1e-12);
  }
}

// A picture's noise of 1 %, and light that goes up by a tenth in the west: samples stay where they
// are or nearly so.
TEST_F(WindowSampling, KeepsItsPiecesOfSkyWhileThePictureChangesLittle) {
  const std::vector<glm::vec3> before = SkyWithASpot(0.0f);
  std::vector<glm::vec3> after = before;
  for (std::size_t cell = 0; cell < after.size(); ++cell) {
    const auto noise = static_cast<float>(UnitFromHash(HashBits(cell)) - 0.5);
    const float west = SkyTable::DirectionOfCell(cell).x < 0.0 ? 1.1f : 1.0f;
    after[cell] *= west * (1.0f + 0.02f * noise);
  }
  const DaylightSampler sampler(windows_, kObject, {});
  const DaylightSamples a = sampler.Draw(before);
  const DaylightSamples b = sampler.Draw(after);
  ASSERT_EQ(a.samples.size(), b.samples.size());
  std::vector<double> moved_deg;
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    const glm::vec3 from = a.samples[i].direction_enu;
    const glm::vec3 to = b.samples[i].direction_enu;
    moved_deg.push_back(
        static_cast<double>(std::atan2(glm::length(glm::cross(from, to)), glm::dot(from, to))) *
        180.0 / std::numbers::pi);
  }
  std::sort(moved_deg.begin(), moved_deg.end());
  // The window is some 40 deg wide: a sample has a piece of 5 deg.
  EXPECT_LT(moved_deg[moved_deg.size() / 2], 2.0);
  EXPECT_LT(moved_deg[moved_deg.size() * 9 / 10], 5.0);
  // The same picture gives the same samples.
  const DaylightSamples again = sampler.Draw(before);
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    EXPECT_EQ(a.samples[i].direction_enu, again.samples[i].direction_enu);
  }
}

TEST_F(WindowSampling, RefusesBadInputByName) {
  const auto message = [](const auto& call) {
    try {
      call();
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message([&] { DaylightSampler(windows_, kObject, {.samples = 0}); }),
              HasSubstr("samples is 0"));
  EXPECT_THAT(message([&] {
                DaylightSampler(windows_, {{0, nan, 0}, 1.0}, {});
              }),
              HasSubstr("bounding sphere"));
  EXPECT_THAT(message([&] {
                DaylightSampler(windows_, {{0, 0, 0}, -1.0}, {});
              }),
              HasSubstr("radius -1"));
  const DaylightSampler sampler(windows_, kObject, {});
  EXPECT_THAT(message([&] { sampler.Draw(std::vector<glm::vec3>(3)); }), HasSubstr("3 cells"));
  std::vector<glm::vec3> sky = sky_;
  sky[100].y = -1.0f;
  EXPECT_THAT(message([&] { sampler.Draw(sky); }), HasSubstr("cell 100 channel 1"));
  sky[100].y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(message([&] { sampler.Draw(sky); }), HasSubstr("cell 100 channel 1"));
  EXPECT_THAT(message([&] { BoundingSphereOf({}); }), HasSubstr("no points"));
  EXPECT_THAT(message([&] { SkyRadianceTable(Lighting{}, std::vector{MakeUniformSkyShape()}); }),
              HasSubstr("1 shapes"));
}

TEST(SkyRadianceTable, AddsUpTheLightingsSky) {
  Lighting lighting;
  lighting.sky = {{"uniform", glm::dvec3(std::numbers::pi)},
                  {"uniform", glm::dvec3(0.0, 1.0, 0.0)}};
  const std::vector<glm::vec3> table =
      SkyRadianceTable(lighting, std::vector{MakeUniformSkyShape(), MakeUniformSkyShape()});
  const std::size_t zenith = SkyTable::CellOf({0.0f, 0.0f, 1.0f});
  EXPECT_NEAR(table[zenith].x, 1.0f, 1e-6f);
  EXPECT_NEAR(table[zenith].y, 1.0f + std::numbers::inv_pi_v<float>, 1e-6f);
}

}  // namespace
}  // namespace pleinair::window_sampling_test
