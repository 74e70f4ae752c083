// Less noise of light that was found by rays at the vertices of virtual objects.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/mesh.h"

namespace pleinair {

// Rays around neighbouring vertices are drawn independently, so that a flat face shows their noise
// as mottle. Here the light at a vertex becomes that of a plane, by weighted least squares, through
// the light at the vertices within two edges that are like it: of nearly its normal, and from which
// objects hide as much. Light that changes evenly over a face stays what it is.
//
// Source  Cleveland, "Robust locally weighted regression and smoothing scatterplots", 1979; weights
//         that do not depend on the data in place of his robust ones, and slopes damped
//         where few vertices determine them.
// Holds   under motions of all objects together that keep angles.
// Cost    set-up some 10 ms for 4000 vertices on two cores, then 0.2 ms.
class VertexSmoothing {
 public:
  VertexSmoothing() = default;
  // `hidden_share`, one a vertex: of its hemisphere, by objects, as `rays` found it. Those that lie
  // within an object have 1, keep their light, and do not count.
  VertexSmoothing(const Mesh& objects, std::span<const float> hidden_share, int rays);

  std::size_t VertexCount() const { return first_.empty() ? 0 : first_.size() - 1; }

  // Irradiance, 0 or more. Unchanged where it is of another number of vertices than construction's.
  std::vector<glm::vec3> Smoothed(std::vector<glm::vec3> at_vertices) const;

 private:
  struct Neighbour {
    std::uint32_t vertex = 0;
    float weight = 0.0f;
  };
  std::vector<std::uint32_t> first_;  // Per vertex, its neighbours: [first, next first).
  std::vector<Neighbour> neighbours_;
};

}  // namespace pleinair
