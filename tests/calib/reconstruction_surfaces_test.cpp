// Ground and walls of a yard that was made.
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/reconstruction/internal/wall_outline.h"
#include "calib/reconstruction/surfaces.h"
#include "tests/calib/reconstructed_yard.h"
#include "tests/scene/temporary_folder.h"

namespace pleinair::reconstruction_surfaces_test {
namespace {

using reconstructed_yard::kBehindY;
using reconstructed_yard::kFacadeY;
using reconstructed_yard::kRightX;
using reconstructed_yard::MakeYard;
using testing::HasSubstr;

SurfaceOptions Options() {
  SurfaceOptions options;
  options.tolerance_m = 0.08;
  options.border_m = 5.0;
  return options;
}

// The surface whose plane is this one within 1 degree and 5 cm.
const SiteSurface* Find(const SiteSurfaces& site, const glm::dvec3& normal, double offset) {
  for (const SiteSurface& surface : site.surfaces) {
    const double cosine = glm::dot(surface.plane.normal, normal);
    if (cosine > std::cos(RadFromDeg(1.0)) && std::abs(surface.plane.offset - offset) < 0.05) {
      return &surface;
    }
  }
  return nullptr;
}

bool Covers(const SiteSurface& surface, const glm::dvec3& p) {
  // Rectangles of upright walls.
  for (const auto& polygon : surface.polygons) {
    glm::dvec3 lower = polygon[0];
    glm::dvec3 upper = polygon[0];
    for (const glm::dvec3& corner : polygon) {
      lower = glm::min(lower, corner);
      upper = glm::max(upper, corner);
    }
    const bool inside = p.x > lower.x - 0.1 && p.x < upper.x + 0.1 && p.y > lower.y - 0.1 &&
                        p.y < upper.y + 0.1 && p.z > lower.z && p.z < upper.z;
    if (inside) return true;
  }
  return false;
}

double NearestCorner(const SiteSurface& surface, const Plane& plane) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& polygon : surface.polygons) {
    for (const glm::dvec3& p : polygon) {
      nearest = std::min(nearest, std::abs(plane.DistanceOf(p)));
    }
  }
  return nearest;
}

TEST(FitSurfaces, FindsGroundAndWalls) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    reconstructed_yard::Options yard;
    yard.seed = seed;
    const SiteSurfaces site = FitSurfaces(MakeYard(yard), {}, Options());
    EXPECT_EQ(site.surfaces.front().name, "ground");
    EXPECT_NEAR(site.surfaces.front().plane.offset, 0.0, 0.01);
    const SiteSurface* facade = Find(site, {0.0, -1.0, 0.0}, -kFacadeY);
    const SiteSurface* right = Find(site, {-1.0, 0.0, 0.0}, -kRightX);
    const SiteSurface* behind = Find(site, {0.0, -1.0, 0.0}, -kBehindY);
    ASSERT_TRUE(facade != nullptr && right != nullptr && behind != nullptr);
    EXPECT_EQ(site.surfaces.size(), 4u);
    EXPECT_TRUE(site.notes.empty());
    // Walls reach the ground, and the two in front meet in the corner.
    EXPECT_LT(NearestCorner(*facade, right->plane), 1e-9);
    EXPECT_LT(NearestCorner(*right, facade->plane), 1e-9);
    double low = 1.0;
    for (const auto& polygon : right->polygons) {
      for (const glm::dvec3& p : polygon) low = std::min(low, p.z);
    }
    EXPECT_NEAR(low, site.surfaces.front().plane.offset, 1e-9);
    // The gateway is open, and the wall beside and above it is not.
    EXPECT_FALSE(Covers(*facade, {0.0, kFacadeY, 2.5}));
    EXPECT_TRUE(Covers(*facade, {-6.5, kFacadeY, 2.0}));
    EXPECT_TRUE(Covers(*facade, {6.5, kFacadeY, 2.0}));
    EXPECT_TRUE(Covers(*facade, {0.0, kFacadeY, 7.0}));
    EXPECT_TRUE(Covers(*behind, {0.0, kBehindY, 2.0}));
  }
}

TEST(FitSurfaces, AGuessOfAlbedoHasTheHueOfThePoints) {
  const SiteSurfaces site = FitSurfaces(MakeYard(), {}, Options());
  const SiteSurface* facade = Find(site, {0.0, -1.0, 0.0}, -kFacadeY);
  ASSERT_NE(facade, nullptr);
  EXPECT_NEAR((facade->albedo.r + facade->albedo.g + facade->albedo.b) / 3.0, 0.5, 1e-9);
  // sRGB 0.7, 0.6, 0.5 are linear 0.448, 0.319, 0.214.
  EXPECT_NEAR(facade->albedo.r / facade->albedo.b, 0.448 / 0.214, 0.01);
}

TEST(FitSurfaces, AssumesTheGroundWhereNoPointsShowIt) {
  reconstructed_yard::Options yard;
  yard.has_ground = false;
  yard.wrong_share = 0.0;
  SurfaceOptions options = Options();
  options.camera_height_m = 1.5;
  const SiteSurfaces site = FitSurfaces(MakeYard(yard), {}, options);
  EXPECT_NEAR(site.surfaces.front().plane.offset, reconstructed_yard::kCameraHeight - 1.5, 1e-9);
  EXPECT_EQ(site.surfaces.front().points, 0u);
  EXPECT_THAT(site.notes, testing::ElementsAre(HasSubstr("--camera-height")));
}

// The facade's direction by its edges is taken where its points allow it, and not where it is far
// off.
TEST(FitSurfaces, TakesTheDirectionOfEdges) {
  SurfaceOptions options = Options();
  const auto direction = [&](double deg) {
    options.wall_direction = glm::dvec3(std::cos(RadFromDeg(deg)), std::sin(RadFromDeg(deg)), 0.0);
    const SiteSurfaces site = FitSurfaces(MakeYard(), {}, options);
    const glm::dvec3 normal = site.surfaces[1].plane.normal;
    return std::remainder(DegFromRad(std::atan2(normal.y, normal.x)), 90.0);
  };
  EXPECT_NEAR(direction(0.3), 0.3, 1e-9);
  EXPECT_NEAR(direction(20.0), 0.0, 0.1);
}

// Two walls with a gap of 10 m between them, at y = 20 m and `step_m` behind that. The points'
// depth is wrong by `tilt_rad` along the walls.
Reconstruction TwoWalls(double step_m, double tilt_rad, double noise_m, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, noise_m);
  Reconstruction world;
  world.cameras.push_back({"1", reconstructed_yard::YardCamera()});
  world.pictures.push_back(
      {"0.jpg", 0, reconstructed_yard::CameraAt({0.0, 0.0, 1.6}, 0.0, RadFromDeg(12.0)), {}});
  for (int i = 0; i < 400; ++i) {
    const double side = i % 2 == 0 ? -1.0 : 1.0;
    const double x = side * (5.0 + 5.0 * unit(random));
    const double y = 20.0 + (side > 0.0 ? step_m : 0.0) + std::tan(tilt_rad) * x + noise(random);
    world.points.push_back({i + 1, {x, y, 0.5 + 7.5 * unit(random)}, glm::dvec3(0.5)});
  }
  return world;
}

// Depth of the walls, left and right.
std::pair<double, double> DepthsOf(const Reconstruction& world) {
  SurfaceOptions options = Options();
  options.tolerance_m = 0.2;
  options.wall_direction = glm::dvec3(0.0, 1.0, 0.0);
  const SiteSurfaces site = FitSurfaces(world, {}, options);
  EXPECT_EQ(site.surfaces.size(), 3u);
  std::pair<double, double> depths;
  for (const SiteSurface& wall : site.surfaces) {
    if (wall.name == "ground") continue;
    EXPECT_NEAR(wall.plane.normal.y, -1.0, 1e-9);
    (wall.polygons.front().front().x < 0.0 ? depths.first : depths.second) = -wall.plane.offset;
  }
  return depths;
}

// A tilt of all points is their error, where edges have given the direction; a step is real.
TEST(FitSurfaces, TwoWallsOfOnePlaneStayInItWhereDepthIsTilted) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    // Each of the two alone would be off by 0.14 m.
    const auto [left, right] = DepthsOf(TwoWalls(0.0, RadFromDeg(1.1), 0.05, seed));
    EXPECT_NEAR(left, 20.0, 0.02);
    EXPECT_NEAR(right, 20.0, 0.02);
    const auto [front, behind] = DepthsOf(TwoWalls(0.15, 0.0, 0.02, seed));
    EXPECT_NEAR(front, 20.0, 0.01);
    EXPECT_NEAR(behind, 20.15, 0.01);
  }
}

MarkedSurface Marked(const Reconstruction& yard,
                     const std::string& name,
                     std::size_t picture,
                     const std::vector<glm::dvec3>& corners) {
  const Lens lens(yard.cameras[0].intrinsics);
  MarkedSurface marked{name, {}};
  for (const glm::dvec3& corner : corners) {
    const auto pixel = lens.ProjectToPixel(
        glm::dvec3(yard.pictures[picture].camera_from_model * glm::dvec4(corner, 1.0)));
    marked.marks.push_back({picture, *pixel});
  }
  return marked;
}

TEST(FitSurfaces, MarksNameAndBoundSurfaces) {
  const Reconstruction yard = MakeYard();
  // Marks are set some centimetres off: corners move to the ground and to each other.
  const std::vector<MarkedSurface> marked = {
      Marked(yard,
             "gable",
             2,
             {{-9.5, kFacadeY, 0.1},
              {9.9, kFacadeY, 0.12},
              {9.9, kFacadeY, 8.0},
              {-9.5, kFacadeY, 8.0}}),
      Marked(
          yard,
          "side",
          1,
          {{kRightX, 7.0, 0.1}, {kRightX, 7.0, 6.0}, {kRightX, 19.9, 6.0}, {kRightX, 19.9, 0.1}})};
  const SiteSurfaces site = FitSurfaces(yard, marked, Options());
  ASSERT_EQ(site.surfaces.size(), 3u);
  const SiteSurface& gable = site.surfaces[1];
  const SiteSurface& side = site.surfaces[2];
  EXPECT_EQ(gable.name, "gable");
  EXPECT_EQ(side.name, "side");
  EXPECT_EQ(Find(site, {0.0, -1.0, 0.0}, -kFacadeY), &gable);
  EXPECT_EQ(Find(site, {-1.0, 0.0, 0.0}, -kRightX), &side);
  ASSERT_EQ(gable.polygons.size(), 1u);
  int on_ground = 0;
  int in_corner = 0;
  for (const glm::dvec3& p : gable.polygons[0]) {
    EXPECT_NEAR(gable.plane.DistanceOf(p), 0.0, 1e-9);
    if (std::abs(site.surfaces[0].plane.DistanceOf(p)) < 1e-9) ++on_ground;
    if (std::abs(side.plane.DistanceOf(p)) < 1e-9) ++in_corner;
  }
  EXPECT_EQ(on_ground, 2);
  EXPECT_GE(in_corner, 1);
  // Counter-clockwise seen from the cameras.
  const auto& q = gable.polygons[0];
  EXPECT_LT(glm::cross(q[1] - q[0], q[2] - q[1]).y, 0.0);
}

// A single place on a wall is enough where points are near it.
TEST(FitSurfaces, PlacesMarkASurface) {
  const Reconstruction yard = MakeYard();
  const std::vector<MarkedSurface> marked = {
      Marked(yard, "gable", 2, {{-6.0, kFacadeY, 5.0}, {6.0, kFacadeY, 6.0}}),
      Marked(yard, "gable", 4, {{-5.0, kFacadeY, 6.0}, {5.0, kFacadeY, 5.5}})};
  MarkedSurface gable = marked[0];
  gable.marks.insert(gable.marks.end(), marked[1].marks.begin(), marked[1].marks.end());
  const SiteSurfaces site = FitSurfaces(yard, std::vector{gable}, Options());
  ASSERT_EQ(site.surfaces.size(), 2u);
  EXPECT_NE(Find(site, {0.0, -1.0, 0.0}, -kFacadeY), nullptr);
}

TEST(FitSurfacesHardCases, SaysWhatIsMissing) {
  const Reconstruction yard = MakeYard();
  const std::vector<MarkedSurface> sky = {
      Marked(yard, "sky", 2, {{-1.0, 20.0, 11.0}, {1.0, 20.0, 11.0}, {0.0, 20.0, 12.0}})};
  EXPECT_THAT(MessageOf([&] { FitSurfaces(yard, sky, Options()); }), HasSubstr("surface sky"));
  Reconstruction line = yard;
  for (std::size_t i = 0; i < line.points.size(); ++i) {
    line.points[i].position = {0.0, 15.0, 0.01 * static_cast<double>(i)};
  }
  EXPECT_THAT(MessageOf([&] { FitSurfaces(line, {}, Options()); }), HasSubstr("no plane"));
  SurfaceOptions options = Options();
  options.tolerance_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(FitSurfaces(yard, {}, options), std::invalid_argument);
}

TEST(OutlineWall, IsOpenWherePointsAreSeenThrough) {
  std::vector<glm::dvec2> on_wall;
  std::vector<glm::dvec2> through;
  for (double x = 0.25; x < 10.0; x += 0.5) {
    for (double y = 0.25; y < 6.0; y += 0.5) {
      (x > 4.0 && x < 6.0 && y < 3.0 ? through : on_wall).emplace_back(x, y);
      if (x > 4.0 && x < 6.0 && y < 3.0) through.emplace_back(x + 0.01, y);
    }
  }
  const auto parts = OutlineWall({{0.0, 0.0}, {10.0, 6.0}}, on_wall, through, 0.5);
  double area = 0.0;
  for (const WallRectangle& part : parts) {
    area += (part.upper.x - part.lower.x) * (part.upper.y - part.lower.y);
    const bool overlaps_gate = part.lower.x < 5.0 && part.upper.x > 5.0 && part.lower.y < 1.5;
    EXPECT_FALSE(overlaps_gate);
  }
  EXPECT_NEAR(area, 60.0 - 6.0, 1.0);  // Rounding of the opening's upper corners.
  EXPECT_EQ(OutlineWall({{0.0, 0.0}, {10.0, 6.0}}, on_wall, {}, 0.5).size(), 1u);
}

}  // namespace
}  // namespace pleinair::reconstruction_surfaces_test
