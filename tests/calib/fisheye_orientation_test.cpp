#include "calib/fisheye_orientation.h"

#include <cmath>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "sunmodel/angles.h"
#include "sunmodel/time_text.h"

namespace pleinair::fisheye_orientation_test {
namespace {

glm::dmat3 SomeOrientation(bool mirrored) {
  const glm::dmat4 turned = glm::rotate(
      glm::rotate(glm::dmat4(1.0), 2.1, glm::dvec3(0, 0, 1)), 0.3, glm::dvec3(1, 0.4, 0));
  glm::dmat3 matrix(turned);
  if (mirrored) matrix[0] = -matrix[0];
  return matrix;
}

double Apart(const glm::dmat3& a, const glm::dmat3& b) {
  double worst = 0.0;
  for (int c = 0; c < 3; ++c) worst = std::max(worst, glm::distance(a[c], b[c]));
  return worst;
}

std::vector<DirectionPair> Marks(const glm::dmat3& world_from_camera, int count, double noise_rad) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<DirectionPair> marks;
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 camera =
        glm::normalize(glm::dvec3(normal(random), normal(random), std::abs(normal(random))));
    const glm::dvec3 noise(normal(random), normal(random), normal(random));
    marks.push_back({3.0 * camera, world_from_camera * camera + noise_rad * noise});
  }
  return marks;
}

TEST(FisheyeOrientation, IsFoundFromMarksEitherWayRound) {
  for (const bool mirrored : {false, true}) {
    for (const int count : {2, 3, 20}) {
      const glm::dmat3 truth = SomeOrientation(mirrored);
      const OrientationFit fit = FitOrientation(
          Marks(truth, count, 0.0), {mirrored ? Handedness::kMirrored : Handedness::kRightHanded});
      EXPECT_LT(Apart(fit.world_from_camera, truth), 1e-9) << count;
      EXPECT_LT(fit.rms_rad, 1e-9);
    }
  }
}

// 20 marks to 0.2 degrees across: each axis to 0.2 / sqrt(20 * 2/3) = 0.055 degrees, three sigma.
TEST(FisheyeOrientation, AveragesOverMarks) {
  const glm::dmat3 truth = SomeOrientation(false);
  const OrientationFit fit = FitOrientation(Marks(truth, 20, RadFromDeg(0.2)));
  EXPECT_LT(Apart(fit.world_from_camera, truth), RadFromDeg(3.0 * 0.055));
  EXPECT_NEAR(fit.rms_rad, RadFromDeg(0.2 * std::sqrt(2.0)), RadFromDeg(0.08));
}

TEST(FisheyeOrientationHardCases, LeavesOutWrongMarks) {
  const glm::dmat3 truth = SomeOrientation(false);
  std::vector<DirectionPair> marks = Marks(truth, 20, RadFromDeg(0.1));
  for (std::size_t i = 0; i < 6; ++i)
    marks[3 * i].direction_world = glm::dvec3(0.1 * static_cast<double>(i), 1, 0.2);
  const OrientationFit fit = FitOrientation(marks);
  EXPECT_LT(Apart(fit.world_from_camera, truth), RadFromDeg(0.2));
  for (std::size_t i = 0; i < 20; ++i) EXPECT_EQ(fit.counts[i], !(i % 3 == 0 && i < 18)) << i;
}

TEST(FisheyeOrientationHardCases, SaysWhatCannotBeDetermined) {
  const glm::dvec3 up(0.0, 0.0, 1.0);
  const glm::dvec3 side(1.0, 0.0, 0.0);
  const glm::dvec3 near_up(0.01, 0.0, 1.0);
  EXPECT_THROW(FitOrientation({}), std::invalid_argument);
  EXPECT_THROW(FitOrientation(std::vector<DirectionPair>{{up, up}}), std::invalid_argument);
  EXPECT_THROW(FitOrientation(std::vector<DirectionPair>{{up, up}, {glm::dvec3(0.0), side}}),
               std::invalid_argument);
  // One line, both ends.
  EXPECT_THROW(FitOrientation(std::vector<DirectionPair>{{up, up}, {near_up, near_up}, {-up, -up}}),
               std::runtime_error);
  // 90 degrees in the camera, 45 in the world.
  EXPECT_THROW(FitOrientation(std::vector<DirectionPair>{{up, up}, {side, up + side}}),
               std::runtime_error);
  EXPECT_THROW(OrientationFromUp(up, {near_up, near_up}), std::runtime_error);
  EXPECT_THROW(OrientationFromUp(up, {side, near_up}), std::runtime_error);
}

TEST(FisheyeOrientation, TakesNorthFromOneSunAndUpAsGiven) {
  for (const bool mirrored : {false, true}) {
    // Levelled: the axis is up; turned by 40 degrees.
    glm::dmat3 truth(glm::rotate(glm::dmat4(1.0), RadFromDeg(40.0), glm::dvec3(0, 0, 1)));
    if (mirrored) truth[0] = -truth[0];
    const glm::dvec3 sun = glm::normalize(glm::dvec3(-0.3, -0.8, 0.6));
    const OrientationFit fit =
        OrientationFromUp({0.0, 0.0, 1.0},
                          {glm::transpose(truth) * sun, sun},
                          mirrored ? Handedness::kMirrored : Handedness::kRightHanded);
    EXPECT_LT(Apart(fit.world_from_camera, truth), 1e-12);
    // A sun seen a degree too high is reported, and turns nothing.
    const glm::dvec3 higher = glm::dvec3(
        glm::rotate(glm::dmat4(1.0), RadFromDeg(1.0), glm::cross(sun, glm::dvec3(0, 0, 1))) *
        glm::dvec4(sun, 0.0));
    const OrientationFit off =
        OrientationFromUp({0.0, 0.0, 1.0},
                          {glm::transpose(truth) * higher, sun},
                          mirrored ? Handedness::kMirrored : Handedness::kRightHanded);
    EXPECT_LT(Apart(off.world_from_camera, truth), 1e-12);
    EXPECT_NEAR(off.residual_rad[0], RadFromDeg(1.0), 1e-9);
  }
}

// A sky with a disc painted at a known direction; on the rim of the picture's circle it may be cut.
RgbImage Sky(const FisheyeLens& lens,
             const glm::dvec3& sun,
             double radius_rad,
             float sun_radiance,
             float sky_radiance = 100.0f) {
  RgbImage sky(lens.Intrinsics().width_px, lens.Intrinsics().height_px);
  for (int y = 0; y < sky.height; ++y) {
    for (int x = 0; x < sky.width; ++x) {
      const auto centre = lens.DirectionFromPixel({x, y});
      if (!centre) continue;
      glm::vec3 sum(0.0f);
      // Sixteen samples a pixel at the disc's limb.
      const bool near_limb = std::abs(glm::distance(*centre, sun) - radius_rad) < RadFromDeg(1.5);
      const int side = near_limb ? 4 : 1;
      for (int s = 0; s < side * side; ++s) {
        const auto direction = lens.DirectionFromPixel(
            {x + (s % side + 0.5) / side - 0.5, y + (s / side + 0.5) / side - 0.5});
        const bool in_disc = direction && glm::distance(*direction, sun) < radius_rad;
        sum += glm::vec3(in_disc ? sun_radiance : sky_radiance) / static_cast<float>(side * side);
      }
      sky.At(x, y) = sum;
    }
  }
  return sky;
}

// 512 px over 180 degrees: the centre of light of a disc of 1.5 px is known to a tenth of a pixel.
TEST(SunImage, IsFoundWhereItIs) {
  for (const FisheyeModel model :
       {FisheyeModel::kEquidistant, FisheyeModel::kEquisolid, FisheyeModel::kStereographic}) {
    const FisheyeLens lens(CentredFisheye(model, RadFromDeg(180.0), 512, 512));
    for (const double angle_deg : {0.0, 31.0, 60.0, 85.0}) {
      const double angle = RadFromDeg(angle_deg);
      const glm::dvec3 sun(std::sin(angle) * 0.6, std::sin(angle) * 0.8, std::cos(angle));
      const auto found = FindSunImage(Sky(lens, sun, RadFromDeg(0.27), 1e7f), lens);
      ASSERT_TRUE(found) << angle_deg;
      EXPECT_LT(glm::distance(found->direction_camera, sun), RadFromDeg(0.06)) << angle_deg;
    }
  }
}

TEST(SunImage, IsFoundClipped) {
  const FisheyeLens lens(CentredFisheye(FisheyeModel::kEquidistant, RadFromDeg(180.0), 512, 512));
  const glm::dvec3 sun = glm::normalize(glm::dvec3(0.5, -0.3, 0.7));
  const auto found = FindSunImage(Sky(lens, sun, RadFromDeg(2.0), 1000.0f), lens);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->clipped);
  EXPECT_NEAR(found->angular_radius_rad, RadFromDeg(2.0), RadFromDeg(0.2));
  EXPECT_LT(glm::distance(found->direction_camera, sun), RadFromDeg(0.05));
}

TEST(SunImage, IsNotMadeUp) {
  const FisheyeLens lens(CentredFisheye(FisheyeModel::kEquidistant, RadFromDeg(180.0), 256, 256));
  const glm::dvec3 sun(0.0, 0.0, 1.0);
  EXPECT_FALSE(FindSunImage(Sky(lens, sun, 0.0, 0.0f), lens)) << "a uniform sky";
  EXPECT_FALSE(FindSunImage(Sky(lens, sun, RadFromDeg(20.0), 1e5f), lens)) << "a bright cloud";
  EXPECT_FALSE(FindSunImage(RgbImage(256, 256), lens)) << "night";
  RgbImage two = Sky(lens, sun, RadFromDeg(1.0), 1e5f);
  const RgbImage other = Sky(lens, glm::normalize(glm::dvec3(1, 0, 1)), RadFromDeg(1.0), 1e5f);
  for (std::size_t i = 0; i < two.pixels.size(); ++i) two.pixels[i] += other.pixels[i];
  EXPECT_FALSE(FindSunImage(two, lens)) << "two equal ones";
  RgbImage broken = Sky(lens, sun, RadFromDeg(1.0), 1e5f);
  broken.At(10, 128) = glm::vec3(std::nanf(""));
  EXPECT_TRUE(FindSunImage(broken, lens));
}

// Sunrise to evening at one site, the orientation unknown: the suns' own images give it back.
TEST(FisheyeOrientation, IsFoundFromTheSunsOfADay) {
  const Site site{RadFromDeg(50.36), RadFromDeg(7.59), 70.0};
  const FisheyeLens lens(CentredFisheye(FisheyeModel::kEquidistant, RadFromDeg(190.0), 512, 512));
  const glm::dmat3 truth = SomeOrientation(false);
  std::vector<DirectionPair> pairs;
  for (const char* time :
       {"2007-03-20T09:40:00Z", "2007-03-20T11:50:00Z", "2007-03-20T14:20:00Z"}) {
    const glm::dvec3 sun = ApparentSunDirectionEnu(site, ParseUtcTime(time));
    const auto image =
        FindSunImage(Sky(lens, glm::transpose(truth) * sun, RadFromDeg(0.27), 1e7f), lens);
    ASSERT_TRUE(image);
    pairs.push_back({image->direction_camera, sun});
  }
  const OrientationFit fit = FitOrientation(pairs);
  EXPECT_LT(Apart(fit.world_from_camera, truth), RadFromDeg(0.1));
  EXPECT_LT(fit.rms_rad, RadFromDeg(0.06));
}

}  // namespace
}  // namespace pleinair::fisheye_orientation_test
