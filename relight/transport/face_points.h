// The part of each face that light can reach, as points on it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace pleinair {

// A face is divided into kCells cells of equal area. A cell that light can reach has one point,
// somewhere on it and just off the surface; one that lies within a wall, or in a room without an
// opening, has none. So the mean over a face's points is that over its exposed part, and a floor
// that goes on under a wall is as bright as it is in the room.
struct FacePoints {
  static constexpr int kCells = 64;

  std::vector<std::uint32_t> begin;  // Face i has points [begin[i], begin[i + 1]).
  std::vector<glm::vec3> position_m;
  // Per face: 1 where all of it is exposed, also between its points: nothing stands on it.
  std::vector<std::uint8_t> whole;

  std::size_t FaceCount() const { return begin.empty() ? 0 : begin.size() - 1; }
  std::span<const glm::vec3> Of(std::size_t face) const {
    return std::span(position_m).subspan(begin[face], begin[face + 1] - begin[face]);
  }
  double ExposedShareOf(std::size_t face) const {
    return static_cast<double>(begin[face + 1] - begin[face]) / kCells;
  }
};

}  // namespace pleinair
