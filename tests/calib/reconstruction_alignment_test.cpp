// Planes, up, position and north of reconstructions.
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/gtc/quaternion.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/reconstruction/geo_alignment.h"
#include "calib/reconstruction/plane_fit.h"
#include "calib/reconstruction/up_direction.h"
#include "tests/calib/reconstructed_yard.h"

namespace pleinair::reconstruction_alignment_test {
namespace {

double AngleDeg(const glm::dvec3& a, const glm::dvec3& b) {
  return DegFromRad(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
}

// Points of a plane, and half as many anywhere.
std::vector<glm::dvec3> PlaneAmongOthers(const glm::dvec3& normal, double offset, double noise) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-5.0, 5.0);
  std::normal_distribution<double> off(0.0, noise);
  const auto level = LevelBelow(normal, 1.0);
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 200; ++i) {
    points.push_back((offset + off(random)) * normal + place(random) * level[0].direction +
                     place(random) * level[1].direction);
  }
  for (int i = 0; i < 100; ++i) points.emplace_back(place(random), place(random), place(random));
  return points;
}

TEST(FitPlane, FindsThePlaneAmongWrongPoints) {
  const glm::dvec3 normal = glm::normalize(glm::dvec3(1.0, -2.0, 0.5));
  PlaneFitOptions options;
  options.tolerance = 0.05;
  const auto fit = FitPlane(PlaneAmongOthers(normal, 2.0, 0.01), options);
  ASSERT_TRUE(fit.has_value());
  const double sign = glm::dot(fit->plane.normal, normal) < 0.0 ? -1.0 : 1.0;
  // 0.01 over a spread of 2.9 and 200 points: 0.014 deg of each axis; wrong points within the
  // tolerance add as much.
  EXPECT_LT(AngleDeg(sign * fit->plane.normal, normal), 6 * 0.014);
  EXPECT_NEAR(sign * fit->plane.offset, 2.0, 6 * 0.01 / std::sqrt(200.0));
  EXPECT_GE(fit->members.size(), 200u);
  EXPECT_LT(fit->members.size(), 215u);
  EXPECT_NEAR(DegFromRad(fit->normal_sigma_rad), 0.014, 0.007);
}

TEST(FitPlane, HoldsItsKind) {
  PlaneFitOptions options;
  options.tolerance = 0.5;
  options.kind = PlaneKind::kVertical;
  const glm::dvec3 leaning = glm::normalize(glm::dvec3(1.0, 1.0, 0.05));
  const auto wall = FitPlane(PlaneAmongOthers(leaning, 2.0, 0.01), options);
  ASSERT_TRUE(wall.has_value());
  EXPECT_EQ(wall->plane.normal.z, 0.0);
  EXPECT_LT(AngleDeg(wall->plane.normal * (wall->plane.normal.x < 0.0 ? -1.0 : 1.0),
                     glm::normalize(glm::dvec3(1.0, 1.0, 0.0))),
            1.0);
  options.kind = PlaneKind::kKnownNormal;
  options.tolerance = 0.05;
  const auto level = FitPlane(PlaneAmongOthers({0.0, 0.0, 1.0}, -1.0, 0.01), options);
  ASSERT_TRUE(level.has_value());
  EXPECT_EQ(level->plane.normal, glm::dvec3(0.0, 0.0, 1.0));
  EXPECT_NEAR(level->plane.offset, -1.0, 0.005);
}

TEST(FitPlaneHardCases, LinesAndFewPointsAreNoPlane) {
  PlaneFitOptions options;
  std::vector<glm::dvec3> line;
  for (int i = 0; i < 50; ++i) line.push_back(static_cast<double>(i) * glm::dvec3(1.0, 2.0, 3.0));
  EXPECT_FALSE(FitPlane(line, options).has_value());
  EXPECT_FALSE(FitPlane(std::vector<glm::dvec3>(50, {1.0, 2.0, 3.0}), options).has_value());
  EXPECT_FALSE(FitPlane(std::vector<glm::dvec3>{}, options).has_value());
  EXPECT_FALSE(FitPlaneToAll(line, options).has_value());
  options.tolerance = 0.0;
  EXPECT_THROW(FitPlane(line, options), std::invalid_argument);
}

TEST(EstimateUp, IsRobust) {
  const glm::dvec3 up = glm::normalize(glm::dvec3(0.2, -0.5, 1.0));
  const auto level = LevelBelow(up, 1.0);
  std::vector<LevelDirection> evidence;
  for (int i = 0; i < 20; ++i) {
    const double angle = 0.3 * i;
    evidence.push_back(
        {std::cos(angle) * level[0].direction + std::sin(angle) * level[1].direction, 0.01});
  }
  for (int i = 0; i < 5; ++i) evidence.push_back({up, 0.01});
  const UpEstimate estimate = EstimateUp(evidence, up);
  EXPECT_LT(AngleDeg(estimate.up, up), 0.1);
  EXPECT_LT(AngleDeg(EstimateUp(evidence, -up).up, -up), 0.1);
  EXPECT_THROW(EstimateUp({}, up), std::invalid_argument);
}

// Nothing states the second axis: that is said.
TEST(EstimateUp, StatesWhatIsNotKnown) {
  const std::vector<LevelDirection> evidence = {{{1.0, 0.0, 0.0}, 0.01}, {{1.0, 0.0, 0.0}, 0.01}};
  EXPECT_GT(DegFromRad(EstimateUp(evidence, {0.0, 0.0, 1.0}).sigma_rad), 45.0);
}

// Cameras that look up by 25 degrees, in a model that is turned anyhow: planes say what is up.
TEST(SearchUp, FindsUpByPlanesWhereCamerasLookUp) {
  reconstructed_yard::Options options;
  options.pitch_rad = RadFromDeg(25.0);
  Reconstruction yard = reconstructed_yard::MakeYard(options);
  const glm::dmat3 turn = glm::mat3_cast(glm::normalize(glm::dquat(0.3, -0.5, 0.7, 0.2)));
  Transform({0.37, turn, {1.0, 2.0, 3.0}}, yard);
  const glm::dvec3 truth = turn[2];
  const std::vector<int> upright(yard.pictures.size(), 1);
  const glm::dvec3 sense = UpInPictures(yard, upright);
  const glm::dvec3 held = EstimateUp(LevelOfCameras(yard, upright), sense).up;
  EXPECT_GT(AngleDeg(held, truth), 15.0);
  const auto planes = FindPlaneNormals(yard, 0.37 * 0.1);
  const auto found = SearchUp({}, planes, held, RightInPictures(yard, upright));
  ASSERT_TRUE(found.has_value());
  EXPECT_LT(AngleDeg(*found, truth), 1.5);  // The search's step, and the half of it.
  EXPECT_LT(AngleDeg(EstimateUp(LevelOfPlanes(planes, *found), *found).up, truth), 0.2);
}

// EXIF orientations turn what is up in the stored picture.
TEST(LevelOfCameras, FollowsTheOrientation) {
  Reconstruction one;
  one.cameras.push_back({"1", reconstructed_yard::YardCamera()});
  one.pictures.push_back({"a.jpg", 0, glm::dmat4(1.0), {}});
  const auto up_at = [&](int orientation) {
    return UpInPictures(one, std::vector<int>{orientation});
  };
  EXPECT_EQ(up_at(1), glm::dvec3(0.0, -1.0, 0.0));
  EXPECT_EQ(up_at(3), glm::dvec3(0.0, 1.0, 0.0));
  EXPECT_EQ(up_at(6), glm::dvec3(-1.0, 0.0, 0.0));
  EXPECT_EQ(up_at(8), glm::dvec3(1.0, 0.0, 0.0));
}

// A picture of posts and of a facade's ledges, and a slanting bar.
Gray8Image EdgesDrawn(const Lens& lens, const glm::dmat4& pose, double facade_rad) {
  Gray8Image picture(lens.Intrinsics().width_px, lens.Intrinsics().height_px, 40);
  cv::Mat canvas(picture.height, picture.width, CV_8UC1, picture.pixels.data());
  const auto pixel_of = [&](const glm::dvec3& p) {
    const auto pixel = lens.ProjectToPixel(glm::dvec3(pose * glm::dvec4(p, 1.0)));
    constexpr double kSubPixels = 16.0;
    return pixel ? cv::Point(static_cast<int>(std::lround(kSubPixels * pixel->x)),
                             static_cast<int>(std::lround(kSubPixels * pixel->y)))
                 : cv::Point(0, 0);
  };
  const glm::dvec3 along(std::cos(facade_rad), std::sin(facade_rad), 0.0);
  const auto draw = [&](const glm::dvec3& a, const glm::dvec3& b) {
    cv::line(canvas, pixel_of(a), pixel_of(b), cv::Scalar(220), 5, cv::LINE_AA, 4);
  };
  const glm::dvec3 middle(0.0, 15.0, 3.0);
  for (int i = -4; i <= 4; ++i) {
    const glm::dvec3 foot = middle + 1.5 * i * along - glm::dvec3(0.0, 0.0, 2.5);
    draw(foot, foot + glm::dvec3(0.0, 0.0, 7.0));
    const glm::dvec3 ledge = middle + glm::dvec3(0.0, 0.0, 1.1 * i);
    draw(ledge - 6.5 * along, ledge + 6.5 * along);
  }
  draw(middle - 6.0 * along, middle + 6.0 * along + glm::dvec3(0.0, 0.0, 4.0));
  return picture;
}

TEST(FindEdges, GivesUpAndTheDirectionOfAFacade) {
  const Lens lens(reconstructed_yard::YardCamera());
  constexpr double kFacadeRad = RadFromDeg(17.0);
  std::vector<PictureEdge> edges;
  for (const double right_deg : {-15.0, 0.0, 12.0}) {
    const glm::dmat4 pose = reconstructed_yard::CameraAt(
        {-0.2 * right_deg, 0.0, 1.6}, RadFromDeg(right_deg), RadFromDeg(20.0));
    for (const PictureEdge& edge :
         FindEdges(EdgesDrawn(lens, pose, kFacadeRad), lens.Intrinsics(), pose)) {
      edges.push_back(edge);
    }
  }
  const glm::dvec3 held = glm::normalize(glm::dvec3(0.0, -std::sin(RadFromDeg(20.0)), 1.0));
  const auto found = SearchUp(edges, {}, held, {1.0, 0.0, 0.0});
  ASSERT_TRUE(found.has_value());
  const glm::dvec3 up = EstimateUp(LevelOfEdges(edges, *found, 3), *found).up;
  EXPECT_LT(AngleDeg(up, {0.0, 0.0, 1.0}), 0.2);
  const auto facade = LevelEdgeDirection(edges, up);
  ASSERT_TRUE(facade.has_value());
  const double off_deg = DegFromRad(std::atan2(facade->y, facade->x)) - 17.0;
  EXPECT_NEAR(std::remainder(off_deg, 90.0), 0.0, 0.2);
}

TEST(FindEdges, APictureWithoutEdgesSaysNothing) {
  const CameraIntrinsics camera = reconstructed_yard::YardCamera();
  const auto edges = FindEdges(Gray8Image(camera.width_px, camera.height_px, 128),
                               camera,
                               reconstructed_yard::CameraAt({}, 0.0, 0.0));
  EXPECT_TRUE(edges.empty());
  EXPECT_FALSE(SearchUp(edges, {}, {0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}).has_value());
  EXPECT_FALSE(LevelEdgeDirection(edges, {0.0, 0.0, 1.0}).has_value());
}

// Cameras on a walk, with what a receiver says of a model that is turned, shrunk and moved.
std::vector<GeoReading> Walk(double turn_rad, double scale) {
  std::vector<GeoReading> readings;
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 model(1.3 * i, 0.4 * i * i, 0.1 * i);
    const double c = std::cos(turn_rad);
    const double s = std::sin(turn_rad);
    GeoReading reading;
    reading.centre = model;
    reading.position_enu_m =
        scale * glm::dvec3(c * model.x - s * model.y, s * model.x + c * model.y, 0.0) +
        glm::dvec3(40.0, -30.0, 0.0);
    readings.push_back(reading);
  }
  return readings;
}

TEST(AlignToEarth, FindsTurnScaleAndPlace) {
  for (const double turn_deg : {-170.0, -30.0, 0.0, 95.0}) {
    const GeoAlignment found = AlignToEarth(Walk(RadFromDeg(turn_deg), 2.5), std::nullopt);
    EXPECT_NEAR(
        DegFromRad(std::remainder(found.turn_rad - RadFromDeg(turn_deg), 2.0 * std::numbers::pi)),
        0.0,
        1e-6);
    EXPECT_NEAR(found.scale, 2.5, 1e-9);
    EXPECT_NEAR(found.translation.x, 40.0, 1e-6);
    EXPECT_NEAR(found.translation.y, -30.0, 1e-6);
    EXPECT_TRUE(found.has_position);
    EXPECT_LT(found.position_rms_m, 1e-6);
  }
}

// The deviation of the turn is the receivers' over the walk's spread.
TEST(AlignToEarth, StatesWhatTheReceiversAllow) {
  const std::vector<GeoReading> walk = Walk(0.3, 2.0);
  glm::dvec3 mean(0.0);
  for (const GeoReading& reading : walk) mean += reading.centre / 8.0;
  double squares = 0.0;
  for (const GeoReading& reading : walk) {
    squares += std::pow(2.0 * (reading.centre.x - mean.x), 2.0) +
               std::pow(2.0 * (reading.centre.y - mean.y), 2.0);
  }
  const GeoAlignment found = AlignToEarth(walk, std::nullopt);
  EXPECT_NEAR(found.turn_sigma_rad, 5.0 / std::sqrt(squares), 1e-9);
  EXPECT_NEAR(found.scale_sigma, 5.0 / std::sqrt(squares), 1e-9);
  EXPECT_EQ(AlignToEarth(walk, 2.0).scale_sigma, 0.0);
}

TEST(AlignToEarth, AWrongFixHardlyCounts) {
  std::vector<GeoReading> walk = Walk(0.3, 2.0);
  *walk[3].position_enu_m += glm::dvec3(300.0, -200.0, 0.0);
  const GeoAlignment found = AlignToEarth(walk, 2.0);
  EXPECT_NEAR(DegFromRad(found.turn_rad - 0.3), 0.0, 1.0);
}

TEST(AlignToEarth, WeighsPositionsAndCompassesByTheirVariances) {
  std::vector<GeoReading> walk = Walk(0.0, 2.0);
  const double by_positions = AlignToEarth(walk, 2.0).turn_sigma_rad;
  for (GeoReading& reading : walk) {
    reading.forward = {0.0, 0.9, 0.3};
    reading.heading_rad = RadFromDeg(-10.0);  // That is 10 degrees counter-clockwise.
    reading.heading_sigma_rad = 0.2;
  }
  const GeoAlignment both = AlignToEarth(walk, 2.0);
  const double p = 1.0 / (by_positions * by_positions);
  const double h = 1.0 / (0.2 * 0.2);
  EXPECT_NEAR(DegFromRad(both.turn_rad), 10.0 * h / (p + h), 0.05);
  EXPECT_NEAR(both.turn_sigma_rad, 1.0 / std::sqrt(p + h), 1e-9);
  EXPECT_NEAR(DegFromRad(*both.turn_by_headings_rad), 10.0, 1e-9);
  // One heading that is known far better than the compass has nearly the last word.
  std::vector<GeoReading> stated = walk;
  stated[2].heading_rad = RadFromDeg(-4.0);
  stated[2].heading_sigma_rad = 0.01;
  const GeoAlignment better = AlignToEarth(stated, 2.0);
  EXPECT_NEAR(DegFromRad(*better.turn_by_headings_rad), 4.0, 0.15);
  EXPECT_LT(better.turn_sigma_rad, 0.02);
  for (GeoReading& reading : walk) reading.position_enu_m.reset();
  const GeoAlignment compass = AlignToEarth(walk, std::nullopt);
  EXPECT_NEAR(DegFromRad(compass.turn_rad), 10.0, 1e-9);
  EXPECT_FALSE(compass.has_position);
  EXPECT_TRUE(std::isinf(compass.scale_sigma));
}

TEST(AlignToEarth, WithoutReadingsNothingIsKnown) {
  std::vector<GeoReading> walk = Walk(0.0, 2.0);
  for (GeoReading& reading : walk) reading.position_enu_m.reset();
  const GeoAlignment found = AlignToEarth(walk, std::nullopt);
  EXPECT_EQ(found.turn_sigma_rad, std::numbers::pi);
  EXPECT_TRUE(std::isinf(found.scale_sigma));
  // A tripod: positions say nothing of the turn either.
  std::vector<GeoReading> tripod = Walk(0.0, 2.0);
  for (GeoReading& reading : tripod) {
    reading.centre = {1.0, 2.0, 3.0};
    reading.position_enu_m = glm::dvec3(7.0, 8.0, 0.0);
  }
  const GeoAlignment still = AlignToEarth(tripod, 2.0);
  EXPECT_EQ(still.turn_sigma_rad, std::numbers::pi);
  EXPECT_TRUE(still.has_position);
  EXPECT_NEAR(still.translation.x, 5.0, 1e-9);
}

}  // namespace
}  // namespace pleinair::reconstruction_alignment_test
