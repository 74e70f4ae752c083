// Rooms with windows for tests.
#pragma once

#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "relight/daylight/windows.h"
#include "scene/mesh.h"
#include "tests/relight/probe_test_scenes.h"

namespace pleinair {

// The room is 5 m east, 4 m north, 3 m high, its south-west floor corner at the origin.
inline constexpr glm::vec3 kRoomSize{5.0f, 4.0f, 3.0f};

// A rectangle of a wall: along it from the room's south-west, and up.
struct WallHole {
  glm::vec2 lower;
  glm::vec2 upper;
};

inline const WallHole kSouthHole{{1.0f, 0.9f}, {2.8f, 2.3f}};
inline const WallHole kEastHole{{1.5f, 1.0f}, {2.5f, 2.0f}};

// The four parts of a wall around its hole, which meet in T-junctions; `add` takes their corners.
template <class Add>
void AroundHole(const glm::vec2& size, const WallHole& hole, const Add& add) {
  add(glm::vec2(0.0f), glm::vec2(hole.lower.x, size.y));
  add(glm::vec2(hole.upper.x, 0.0f), size);
  add(glm::vec2(hole.lower.x, 0.0f), glm::vec2(hole.upper.x, hole.lower.y));
  add(glm::vec2(hole.lower.x, hole.upper.y), glm::vec2(hole.upper.x, size.y));
}

// Walls are sheets; a wall without a hole is one rectangle.
inline Mesh SheetRoom(const std::vector<WallHole>& south, const std::vector<WallHole>& east = {}) {
  Mesh mesh;
  mesh.materials.resize(1);
  mesh.group_names = {"room"};
  const float x = kRoomSize.x;
  const float y = kRoomSize.y;
  const float z = kRoomSize.z;
  AddQuad(mesh, {0, 0, 0}, {x, 0, 0}, {x, y, 0}, {0, y, 0});
  AddQuad(mesh, {0, 0, z}, {0, y, z}, {x, y, z}, {x, 0, z});
  AddQuad(mesh, {0, y, 0}, {x, y, 0}, {x, y, z}, {0, y, z});
  AddQuad(mesh, {0, 0, 0}, {0, y, 0}, {0, y, z}, {0, 0, z});
  const auto add_south = [&](const glm::vec2& a, const glm::vec2& b) {
    if (a.x < b.x && a.y < b.y)
      AddQuad(mesh, {a.x, 0, a.y}, {a.x, 0, b.y}, {b.x, 0, b.y}, {b.x, 0, a.y});
  };
  const auto add_east = [&](const glm::vec2& a, const glm::vec2& b) {
    if (a.x < b.x && a.y < b.y)
      AddQuad(mesh, {x, a.x, a.y}, {x, a.x, b.y}, {x, b.x, b.y}, {x, b.x, a.y});
  };
  if (south.empty()) add_south({0, 0}, {x, z});
  if (east.empty()) add_east({0, 0}, {y, z});
  for (const WallHole& hole : south) AroundHole({x, z}, hole, add_south);
  for (const WallHole& hole : east) AroundHole({y, z}, hole, add_east);
  return mesh;
}

// The same with walls, floor and ceiling 0.3 m thick, the south wall of four boxes.
inline Mesh SlabRoom(const WallHole& south) {
  Mesh mesh;
  mesh.materials.resize(1);
  mesh.group_names = {"room"};
  const auto [x, y, z] = std::array{kRoomSize.x, kRoomSize.y, kRoomSize.z};
  const float t = 0.3f;
  AddBox(mesh, {-t, -t, -t}, {x + t, y + t, 0});
  AddBox(mesh, {-t, -t, z}, {x + t, y + t, z + t});
  AddBox(mesh, {-t, y, 0}, {x + t, y + t, z});
  AddBox(mesh, {-t, 0, 0}, {0, y, z});
  AddBox(mesh, {x, 0, 0}, {x + t, y, z});
  AroundHole({x, z}, south, [&](const glm::vec2& a, const glm::vec2& b) {
    AddBox(mesh, {a.x, -t, a.y}, {b.x, 0, b.y});
  });
  return mesh;
}

inline Window SouthWindow(const WallHole& hole) {
  const auto [a, b] = std::array{glm::dvec2(hole.lower), glm::dvec2(hole.upper)};
  return {"south", {{a.x, 0, a.y}, {b.x, 0, a.y}, {b.x, 0, b.y}, {a.x, 0, b.y}}};
}

inline Window EastWindow(const WallHole& hole) {
  const auto [a, b] = std::array{glm::dvec2(hole.lower), glm::dvec2(hole.upper)};
  const double x = static_cast<double>(kRoomSize.x);
  return {"east", {{x, a.x, a.y}, {x, b.x, a.y}, {x, b.x, b.y}, {x, a.x, b.y}}};
}

}  // namespace pleinair
