#include "relight/daylight/windows.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "scene/mesh_io.h"
#include "tests/relight/window_rooms.h"

namespace pleinair::windows_test {
namespace {

using ::testing::HasSubstr;

const std::vector<glm::dvec3> kMiddle{{2.5, 2.0, 1.0}};

// Largest distance from a corner of either to the nearest corner of the other.
double CornersApart(const Window& a, const Window& b) {
  double apart_m = 0.0;
  const auto add = [&](const Window& from, const Window& to) {
    for (const glm::dvec3& corner : from.polygon_m) {
      double nearest_m = std::numeric_limits<double>::infinity();
      for (const glm::dvec3& other : to.polygon_m) {
        nearest_m = std::min(nearest_m, glm::distance(corner, other));
      }
      apart_m = std::max(apart_m, nearest_m);
    }
  };
  add(a, b);
  add(b, a);
  return apart_m;
}

// A cell and a half of 1 cm along each of two axes.
constexpr double kCornerM = 0.0215;

TEST(Windows, FindsTheWindowOfARoomOfSheets) {
  const FoundWindows found = FindWindows(SheetRoom({kSouthHole}), kMiddle);
  ASSERT_EQ(found.windows.size(), 1u);
  EXPECT_LT(CornersApart(found.windows[0], SouthWindow(kSouthHole)), kCornerM);
  EXPECT_FALSE(found.Open());
  EXPECT_FALSE(found.Closed());
  EXPECT_EQ(found.Summary(), "1 window found");
}

TEST(Windows, FindsTheWindowOfARoomOfSlabsOnce) {
  const FoundWindows found = FindWindows(SlabRoom(kSouthHole), kMiddle);
  ASSERT_EQ(found.windows.size(), 1u);
  EXPECT_LT(CornersApart(found.windows[0], SouthWindow(kSouthHole)), kCornerM);
  EXPECT_FALSE(found.Open());
}

TEST(Windows, FindsTwoWindows) {
  const FoundWindows found = FindWindows(SheetRoom({kSouthHole}, {kEastHole}), kMiddle);
  ASSERT_EQ(found.windows.size(), 2u);
  EXPECT_LT(CornersApart(found.windows[0], SouthWindow(kSouthHole)), kCornerM);
  EXPECT_LT(CornersApart(found.windows[1], EastWindow(kEastHole)), kCornerM);
  EXPECT_FALSE(found.Open());
}

TEST(Windows, FindsNoneInAClosedRoom) {
  const FoundWindows found = FindWindows(SheetRoom({}), kMiddle);
  EXPECT_TRUE(found.windows.empty());
  EXPECT_TRUE(found.Closed());
  EXPECT_FALSE(found.Open());
  EXPECT_THAT(found.Summary(), HasSubstr("no window"));
}

// Glass from floor to ceiling: the wall frames it on two sides only.
TEST(Windows, FindsAWindowFromFloorToCeiling) {
  const WallHole hole{{1.0f, 0.0f}, {2.8f, kRoomSize.z}};
  const FoundWindows found = FindWindows(SheetRoom({hole}), kMiddle);
  ASSERT_EQ(found.windows.size(), 1u);
  // One more cell for the line that floor and ceiling draw.
  EXPECT_LT(CornersApart(found.windows[0], SouthWindow(hole)), kCornerM + 0.01);
}

// A band of glass between sill and lintel, from wall to wall, seen past a wardrobe that stands
// before part of it.
TEST(Windows, FindsABandOfGlassBehindFurniture) {
  const WallHole hole{{0.0f, 1.0f}, {kRoomSize.x, 2.0f}};
  Mesh mesh = SheetRoom({hole});
  AddBox(mesh, {0.5f, 0.5f, 0.0f}, {1.5f, 1.0f, 2.5f});
  const FoundWindows found = FindWindows(mesh, kMiddle);
  ASSERT_EQ(found.windows.size(), 1u);
  EXPECT_LT(CornersApart(found.windows[0], SouthWindow(hole)), kCornerM + 0.01);
  EXPECT_FALSE(found.Open());
}

// Where a wall is missing there is no frame: reported, not guessed.
TEST(Windows, CallsARoomWithoutAWallOpen) {
  const FoundWindows found = FindWindows(SheetRoom({{{0.0f, 0.0f}, {5.0f, 3.0f}}}), kMiddle);
  EXPECT_TRUE(found.windows.empty());
  EXPECT_TRUE(found.Open());
  EXPECT_THAT(found.Summary(), HasSubstr("open to the sky"));
}

TEST(Windows, CallsAPointOutdoorsOpen) {
  Mesh mesh = SheetRoom({kSouthHole});
  AddGround(mesh, 50.0f, -0.01f);
  EXPECT_TRUE(FindWindows(mesh, std::vector<glm::dvec3>{{2.0, -3.0, 1.0}}).Open());
}

TEST(Windows, NeverFailsWithoutAMesh) {
  const FoundWindows found = FindWindows(Mesh{}, kMiddle);
  EXPECT_TRUE(found.windows.empty());
  EXPECT_TRUE(found.Open());
}

// The sequence's own polygon was measured from the same mesh by hand.
TEST(Windows, FindsTheRecordedRoomsWindow) {
  const std::filesystem::path room =
      std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences/room-window/scene.obj";
  if (!std::filesystem::exists(room)) GTEST_SKIP() << room << " is not there";
  const Window south{"south", {{1.1, 0, 0.9}, {2.9, 0, 0.9}, {2.9, 0, 2.3}, {1.1, 0, 2.3}}};
  const FoundWindows found =
      FindWindows(LoadMesh(room).mesh, std::vector<glm::dvec3>{{1.95, 1.75, 0.4}});
  ASSERT_EQ(found.windows.size(), 1u);
  EXPECT_LT(CornersApart(found.windows[0], south), kCornerM);
  EXPECT_FALSE(found.Open());
}

TEST(Windows, ReportsWhereLightComesFromElsewhereToo) {
  const std::vector<Window> windows{SouthWindow(kSouthHole)};
  const RayCaster room(SheetRoom({kSouthHole}));
  EXPECT_FALSE(SeesSkyPastWindows(room, windows, kMiddle));
  EXPECT_TRUE(SeesSkyPastWindows(room, windows, std::vector<glm::dvec3>{{2.0, -1.0, 1.0}}));
  const RayCaster two(SheetRoom({kSouthHole}, {kEastHole}));
  EXPECT_TRUE(SeesSkyPastWindows(two, windows, kMiddle));
  EXPECT_FALSE(SeesSkyPastWindows(RayCaster(SheetRoom({})), {}, kMiddle));
}

TEST(Windows, RefusesWhatIsNoPolygonByName) {
  const auto message = [](const Window& window) {
    try {
      window.Validate();
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message({"a", {{0, 0, 0}, {1, 0, 0}}}), HasSubstr("\"a\" has 2 corners"));
  EXPECT_THAT(message({"a", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}}), HasSubstr("no area"));
  EXPECT_THAT(message({"a", {{0, 0, 0}, {1, 0, 0}, {1, nan, 0}}}), HasSubstr("finite"));
  EXPECT_THAT(message({"a", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.5}}}), HasSubstr("flat"));
  EXPECT_EQ(message(SouthWindow(kSouthHole)), "");
}

TEST(Windows, RefusesBadSearchesByName) {
  const auto message = [](const WindowSearchOptions& options, const glm::dvec3& point) {
    try {
      FindWindows(Mesh{}, std::vector<glm::dvec3>{point}, options);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(message({.rays_per_point = 0}, {}), HasSubstr("rays_per_point is 0"));
  EXPECT_THAT(message({.cell_m = 0.0}, {}), HasSubstr("cell_m is 0"));
  EXPECT_THAT(message({}, {0.0, std::numeric_limits<double>::infinity(), 0.0}),
              HasSubstr("axis 1"));
}

}  // namespace
}  // namespace pleinair::windows_test
