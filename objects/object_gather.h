// Light at the vertices of virtual objects, gathered by rays around the vertices themselves: what
// the irradiance volume is an approximation of, for objects that stand still.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/transport/transport.h"
#include "scene/lighting.h"
#include "scene/sky_shape.h"

namespace pleinair {

// Set up once per pose: the rays that leave each vertex meet an object, a real face or the sky.
// Sharp where the volume is smooth: light through a window, from a sunlit wall close by, on the
// side that a pedestal turns to the sun. The disc itself is not in it.
//
// A vertex stands for the part of its triangles that is nearer to it than to their other corners,
// and gathers at four points of it. Points within another part of an object (where parts are put
// together, and do not share vertices) are left out, and a vertex that has no others takes the mean
// of its neighbours: else the dark of every joint would reach as far as the next vertex.
//
// Cost  set-up 0.15 s for 4000 vertices of 256 rays on two cores; a light some milliseconds, of
//       which a frame with the same basis lights needs none.
class ObjectGather {
 public:
  static constexpr std::size_t kPointsPerVertex = 4;
  // Receivers of each vertex of `objects` in turn, on its triangles.
  static std::vector<Receiver> PointsAround(const Mesh& objects);

  ObjectGather() = default;
  // `objects` as ObjectInterreflection::Objects() has them; receivers are their vertices, a quarter
  // of `options`' rays, rounded up, for each point. Keeps neither.
  ObjectGather(const PatchScene& objects, const PatchScene& real, const GatherOptions& options);

  // Irradiance at each vertex from `sky` (null: none) and faces of the given radiosity.
  // Throws std::invalid_argument where a number of faces is another than that of construction.
  std::vector<glm::vec3> Irradiance(const SkyShape* sky,
                                    std::span<const glm::vec3> object_radiosity,
                                    std::span<const glm::vec3> real_radiosity) const;

  // What vertices get of what their points do: such as NearSunlight's change for these.
  std::vector<glm::vec3> AtVertices(std::span<const glm::vec3> at_points) const;

  std::size_t VertexCount() const { return weights_.size() / kPointsPerVertex; }

 private:
  void FindBuried(const Mesh& objects);

  std::size_t object_faces_ = 0;
  std::size_t real_faces_ = 0;
  GatheredRays rays_;           // Over the objects' faces, then the real ones.
  std::vector<float> weights_;  // Of a vertex's points; they add up to 1.
  struct Buried {
    std::uint32_t vertex = 0;
    std::vector<std::uint32_t> neighbours;  // That are not.
  };
  std::vector<Buried> buried_;
};

}  // namespace pleinair
