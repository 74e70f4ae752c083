// Receivers on a lattice over the triangles of a scene: they stay while the camera moves.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/transport/patch_scene.h"
#include "relight/transport/transport.h"

namespace pleinair {

// A side of a triangle whose edges are cut into n parts each has receivers at the corners of its
// n^2 small triangles. Sides of one plane share a receiver where they meet in it. It stands in the
// middle of what they have around it: inside a plane on the spot, at the plane's rim a little
// inside, so that one on the rim of a wall does not stand in the wall beside it.
class FaceLattice {
 public:
  FaceLattice() = default;
  // `parts` of each side's edges, one entry a side; 0 gives a side no receivers.
  FaceLattice(const PatchScene& scene, std::span<const std::uint16_t> parts);

  const std::vector<Receiver>& Receivers() const { return receivers_; }
  // A side that has the receiver; of several the first.
  const std::vector<std::uint32_t>& SideOfReceiver() const { return side_of_receiver_; }
  bool HasReceivers(std::size_t side) const { return parts_[side] > 0; }
  // All of one side.
  std::span<const std::uint32_t> ReceiversOf(std::size_t side) const {
    const std::size_t n = parts_[side];
    return std::span(receiver_of_slot_)
        .subspan(first_slot_[side], n > 0 ? (n + 1) * (n + 2) / 2 : 0);
  }

  struct Weighted {
    std::uint32_t receiver = 0;
    float weight = 0.0f;
  };
  // The receivers around a point of a side that has some; their weights add up to 1. A point a hair
  // outside counts as on the edge.
  std::array<Weighted, 3> Around(const PatchScene& scene,
                                 std::size_t side,
                                 const glm::vec3& point_m) const;

 private:
  std::vector<std::uint16_t> parts_;       // Per side.
  std::vector<std::uint32_t> first_slot_;  // Per side, into receiver_of_slot_.
  // Per side its lattice's corners, row by row from vertex 0: row r has r + 1 of them.
  std::vector<std::uint32_t> receiver_of_slot_;
  std::vector<Receiver> receivers_;
  std::vector<std::uint32_t> side_of_receiver_;
};

}  // namespace pleinair
