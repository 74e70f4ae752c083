// Which triangles block the sun, and the volumes that lie in their shadow. No OpenGL here.
//
// The shadow of one triangle is a prism. Its cap is the triangle, turned so that its front faces
// the sun. It has one side for each edge, and no far cap, since all sides meet in one point at
// infinity. A point is in shadow when it lies in at least one prism. Counting the faces of all
// prisms along a line of sight counts the prisms that contain its end, for any mesh: open,
// non-manifold, self-intersecting, with doubled faces. Sides of neighbours with opposite directions
// cancel, and so a side is only drawn where the directed edges of the turned triangles do not add
// up to zero.
//
// In a closed part a ray that leaves through the back of a face has entered through the front of
// another. So faces with their front to the sun are enough: half the caps and sides. A part with a
// few small holes (a statue without its foot, a sphere without its poles) is closed by an imaginary
// cone over each hole's rim. It needs its other faces only beneath holes that are open to the sun.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/mesh.h"

namespace pleinair {

// Triangles of a caster's volumes, three indices each, as counter-clockwise seen from outside.
struct ShadowVolumes {
  // A run of triangles, in which at most `depth_bound` prisms hold any one point. A stencil of
  // eight bits forgets multiples of 256, so that deep casters are drawn in several runs.
  struct Batch {
    std::size_t first_cap = 0;  // Into caps and sides, in indices.
    std::size_t cap_count = 0;
    std::size_t first_side = 0;
    std::size_t side_count = 0;
    int depth_bound = 0;
  };
  static constexpr int kMaxBatchDepth = 127;

  std::vector<std::uint32_t> caps;
  std::vector<std::uint32_t> sides;
  std::vector<Batch> batches;
};

class ShadowCaster {
 public:
  ShadowCaster() = default;
  // Equal positions are joined, triangles whose corners are not three different positions left out.
  ShadowCaster(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles);

  // Joined positions; the index after the last one is the point at infinity away from the sun.
  std::span<const glm::vec3> Positions() const { return positions_; }
  std::span<const glm::uvec3> Triangles() const { return triangles_; }
  std::uint32_t InfinityIndex() const { return static_cast<std::uint32_t>(positions_.size()); }

  // For the triangles of construction: 1 where the front (counter-clockwise) faces `to_sun`, -1
  // where the back does; 0 edge-on, without area, or where the side that faces the sun is the
  // inside of a closed part, which the sun never reaches.
  void SidesThatMayBeSunlit(const glm::dvec3& to_sun, std::vector<std::int8_t>& sides) const;

  // Writes the volumes for the unit direction `to_sun`; memory of `volumes` is used again. With
  // `receivers`, leaves out prisms that cannot hold a point of that box.
  void BuildVolumes(const glm::dvec3& to_sun,
                    const std::optional<BoundingBox>& receivers,
                    ShadowVolumes& volumes) const;

 private:
  enum class Casting : std::uint8_t { kAllTurned, kFrontToSun, kBackToSun };
  struct EdgeUse {
    std::uint32_t triangle = 0;
    std::int32_t sign = 0;  // 1 where the triangle runs from the edge's lower to its higher vertex.
  };
  struct Edge {
    std::uint32_t lower = 0;
    std::uint32_t higher = 0;
    std::uint32_t first_use = 0;
    std::uint32_t use_count = 0;
  };

  // The rim of a hole, and the cone over it that closes its part.
  struct Hole {
    std::uint32_t part = 0;
    std::vector<glm::dvec3> rim;
    std::vector<glm::dvec3> cone_area_normals;
  };

  struct BeamView;

  int FacingOf(std::size_t triangle, const glm::dvec3& to_sun) const;
  void BuildEdges();
  void FindParts();
  std::vector<Hole> FindHoles() const;
  void ClassifyParts();
  // Prism weights: 1 as wound, -1 turned, 0 none.
  std::vector<std::int8_t> Weights(const BeamView& beam,
                                   const std::optional<BoundingBox>& receivers) const;
  void AppendBatch(std::span<const std::int8_t> weights,
                   int depth_bound,
                   ShadowVolumes& volumes) const;

  std::vector<glm::vec3> positions_;
  std::vector<glm::uvec3> triangles_;
  std::vector<glm::dvec3> area_normals_;        // Per triangle, by winding, not unit.
  std::vector<std::uint32_t> source_triangle_;  // Per triangle.
  std::size_t source_triangle_count_ = 0;
  std::vector<Edge> edges_;
  std::vector<EdgeUse> edge_uses_;
  std::vector<std::uint32_t> part_;       // Per triangle: the number of a triangle of its part.
  std::vector<Casting> casting_of_part_;  // By that number.
  std::vector<Hole> holes_;               // Holes of parts that are closed by imaginary cones.
};

}  // namespace pleinair
