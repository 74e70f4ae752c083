// Receivers on a lattice over the triangles of a scene: they stay while the camera moves.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "relight/transport/patch_scene.h"
#include "relight/transport/transport.h"

namespace pleinair {

// A side of a triangle whose edges are cut into n parts each has receivers at the corners of its
// n^2 small triangles. Sides of one plane share a receiver where they meet in it. It stands in the
// middle of the small triangles around it: inside a plane that is on the spot, at the plane's rim a
// little inside. So a receiver on the rim of a wall does not stand in the wall beside it.
//
// Sides of a joined patch have the receivers of a grid over the patch, seen along the axis that it
// looks along most. Each stands on the triangle nearest to a corner of the grid, and is shared with
// patches beside it. So small triangles do not ask for more receivers than large ones.
class FaceLattice {
  struct Grid;
  // For barycentric weights of points: the gradients of the weights of vertices 0 and 1.
  struct Triangle {
    glm::vec3 b_m{0.0f};
    glm::vec3 c_m{0.0f};
    glm::vec3 of_a_per_m{0.0f};
    glm::vec3 of_b_per_m{0.0f};
    bool has_area = false;
  };

 public:
  FaceLattice() = default;
  // `parts` of each side's edges, one entry a side; 0 gives a side no receivers. Of a joined
  // patch's size, the most that its sides have.
  FaceLattice(const PatchScene& scene, std::span<const std::uint16_t> parts);

  const std::vector<Receiver>& Receivers() const { return receivers_; }
  // A side that has the receiver; of several the first.
  const std::vector<std::uint32_t>& SideOfReceiver() const { return side_of_receiver_; }
  bool HasReceivers(std::size_t side) const { return parts_[side] > 0; }
  // The receivers of one side.
  std::span<const std::uint32_t> ReceiversOf(std::size_t side) const {
    if (const Grid* const grid = GridOf(side)) {
      return std::span(receiver_of_slot_).subspan(grid->first_slot, grid->Corners());
    }
    const std::size_t n = parts_[side];
    return std::span(receiver_of_slot_)
        .subspan(first_slot_[side], n > 0 ? (n + 1) * (n + 2) / 2 : 0);
  }

  struct Weighted {
    std::uint32_t receiver = 0;
    float weight = 0.0f;
  };
  // The receivers around a point of a side that has some; their weights add up to 1. A point
  // outside by rounding counts as on the edge.
  std::array<Weighted, 3> Around(const PatchScene& scene,
                                 std::size_t side,
                                 const glm::vec3& point_m) const;

  // The same for many points of which most lie on the side of the one before: what depends on the
  // side alone is kept. Keeps references.
  class LastSide {
   public:
    LastSide(const FaceLattice& lattice, const PatchScene& scene)
        : lattice_(lattice), scene_(scene) {}
    std::array<Weighted, 3> Around(std::size_t side, const glm::vec3& point_m) {
      if (side != side_) Take(side);
      return grid_ != nullptr ? lattice_.AroundOnGrid(*grid_, point_m)
                              : lattice_.AroundInTriangle(side, triangle_, point_m);
    }

   private:
    void Take(std::size_t side);

    const FaceLattice& lattice_;
    const PatchScene& scene_;
    std::size_t side_ = static_cast<std::size_t>(-1);
    const Grid* grid_ = nullptr;
    Triangle triangle_;
  };

 private:
  // Over a joined patch's face, seen along an axis.
  struct Grid {
    std::uint32_t first_slot = 0;  // Its corners' receivers, row by row.
    float spacing_m = 0.0f;
    std::array<std::int32_t, 2> first{};   // The first corner, in spacings from the origin.
    std::uint16_t rows = 0;                // Rows of corners, at least 2,
    std::uint16_t columns = 0;             // and columns, at least 2.
    std::array<std::uint8_t, 2> across{};  // The axes along rows and columns.

    std::size_t Corners() const { return std::size_t{rows} * columns; }
    glm::vec2 Along(const glm::vec3& at_m) const { return {at_m[across[0]], at_m[across[1]]}; }
  };
  class GridCorners;

  static constexpr std::uint32_t kNoGrid = 0xffffffffu;
  const Grid* GridOf(std::size_t side) const {
    if (grid_of_side_.empty() || grid_of_side_[side] == kNoGrid) return nullptr;
    return &grids_[grid_of_side_[side]];
  }
  static Grid GridOver(const PatchScene& scene, std::size_t face, std::uint16_t parts);
  void AddGrids(const PatchScene& scene);
  std::array<Weighted, 3> AroundOnGrid(const Grid& grid, const glm::vec3& point_m) const;
  static Triangle TriangleOf(const PatchScene& scene, std::size_t side);
  std::array<Weighted, 3> AroundInTriangle(std::size_t side,
                                           const Triangle& triangle,
                                           const glm::vec3& point_m) const;

  std::vector<Grid> grids_;
  std::vector<std::uint32_t> grid_of_side_;  // Empty where no patch is joined.
  std::vector<std::uint16_t> parts_;         // Per side.
  std::vector<std::uint32_t> first_slot_;    // Per side, into receiver_of_slot_.
  // Per side its lattice's corners, row by row from vertex 0: row r has r + 1 of them.
  std::vector<std::uint32_t> receiver_of_slot_;
  std::vector<Receiver> receivers_;
  std::vector<std::uint32_t> side_of_receiver_;
};

}  // namespace pleinair
