// Effect of an object's own shape on the light at its vertices: kept in the object's space, where
// it stays while the object moves as a rigid body.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "objects/object_gather.h"
#include "relight/transport/patch_scene.h"

namespace pleinair {

// Per vertex, the shares of its hemisphere that see past the object's own shape in each direction,
// and the shares that meet each of its faces. Directions are 256 cells of the sphere. Real surfaces
// and other objects count as directions: they stay behind when the object moves.
class OwnShape {
 public:
  // Cells of an octahedral map.
  static constexpr int kCellsASide = 16;
  static constexpr std::size_t kCells = std::size_t{kCellsASide} * kCellsASide;
  static std::size_t CellOf(const glm::vec3& direction);

  OwnShape() = default;
  // From rays that have been cast; `own_from_world` has a rotation for each object. Keeps no
  // reference.
  OwnShape(const ObjectGather& gather,
           const PatchScene& objects,
           std::span<const glm::mat3> own_from_world);

  // The same for these parts of the objects alone, at another place, where `gather` has more rays
  // for a part than it had before.
  void Refine(const ObjectGather& gather,
              std::span<const std::size_t> parts,
              const PatchScene& objects,
              std::span<const glm::mat3> own_from_world);

  bool Empty() const { return object_of_vertex_.empty(); }
  std::size_t VertexCount() const { return object_of_vertex_.size(); }
  std::uint32_t ObjectOf(std::size_t vertex) const { return object_of_vertex_[vertex]; }

  // Irradiance at the vertices from radiosities (pi times radiance) of the cells.
  // Shape  cells [(object * kCells + cell) * lights + light]; result [vertex * lights + light].
  std::vector<glm::vec3> FromCells(std::span<const glm::vec3> cells, std::size_t lights) const;
  // The same from the faces of all objects, [face * lights + light], of which each vertex sees its
  // own object's.
  std::vector<glm::vec3> FromFaces(std::span<const glm::vec3> faces, std::size_t lights) const;

 private:
  struct Source {
    std::uint32_t index = 0;  // Index of a cell among all objects', or of a face.
    float share = 0.0f;
  };
  // Sources of a part's vertices: those of its vertex i are [begin[i], begin[i + 1]).
  struct Rows {
    std::vector<std::uint32_t> begin{0};
    std::vector<Source> sources;
  };
  struct Part {
    Rows cells;
    Rows faces;
    int rays_per_vertex = 0;
  };
  Part PartOf(const ObjectGather& gather,
              std::size_t part,
              const PatchScene& objects,
              std::span<const glm::mat3> own_from_world) const;
  std::vector<glm::vec3> Sum(Rows Part::*rows,
                             std::span<const glm::vec3> radiosity,
                             std::size_t lights) const;

  std::vector<std::uint32_t> object_of_vertex_;
  std::vector<Part> parts_;  // As of ObjectGather.
};

}  // namespace pleinair
