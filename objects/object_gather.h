// Light at the vertices of virtual objects, gathered by rays around the vertices themselves, for
// objects that stand still. The irradiance volume approximates this.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/transport/patch_scene.h"
#include "relight/transport/transport.h"
#include "scene/lighting.h"
#include "scene/sky_shape.h"

namespace pleinair {

// Set up once per pose: the rays that leave each vertex meet an object, a real face or the sky.
// Sharp where the volume is smooth: light through a window, from a sunlit wall close by, on the
// side that a pedestal turns to the sun. The disc itself is not in it.
//
// A vertex stands for the part of its triangles that is nearer to it than to their other corners,
// and gathers at four points of it. Points within another part of an object are left out, where
// parts are put together and do not share vertices. A vertex that has no other points takes the
// mean of its neighbours. Otherwise the dark of every joint would reach as far as the next vertex.
//
// Cost  set-up 0.15 s for 4000 vertices of 256 rays on two cores; a light some milliseconds, of
//       which a frame with the same basis lights needs none.
class ObjectGather {
 public:
  static constexpr std::size_t kPointsPerVertex = 4;
  // Vertices whose rays are cast together.
  static constexpr std::size_t kVerticesPerPart = 64;
  // Receivers of each vertex of `objects` in turn, on its triangles.
  static std::vector<Receiver> PointsAround(const Mesh& objects);

  ObjectGather() = default;
  // `objects` as ObjectInterreflection::Objects() has them; receivers are their vertices, a quarter
  // of `options`' rays, rounded up, for each point. Keeps neither.
  ObjectGather(const PatchScene& objects, const PatchScene& real, const GatherOptions& options);
  // The same before any rays are cast: for callers that spread them over several frames, by Cast.
  // What they get in the end is the same bit for bit.
  static ObjectGather InParts(const PatchScene& objects,
                              const PatchScene& real,
                              const GatherOptions& options);

  std::size_t PartCount() const { return parts_.size(); }
  bool HasCast(std::size_t part) const { return parts_[part].rays.ReceiverCount() > 0; }
  // Whether all parts have been cast, as the functions for all vertices need.
  bool IsComplete() const { return lacking_ == 0; }
  // Casts those of `parts` that have not been cast; the scenes are those of construction.
  void Cast(const PatchScene& objects, const PatchScene& real, std::span<const std::size_t> parts);

  // Irradiance at each vertex from `sky` (null: none) and faces of the given radiosity.
  // Throws std::invalid_argument where a number of faces is another than that of construction.
  std::vector<glm::vec3> Irradiance(const SkyShape* sky,
                                    std::span<const glm::vec3> object_radiosity,
                                    std::span<const glm::vec3> real_radiosity) const;
  // The same at the vertices of a part that has been cast; `radiosity` is of the objects' faces,
  // then of the real ones. Vertices within a part of an object are dark.
  std::vector<glm::vec3> IrradianceOf(std::size_t part,
                                      const SkyShape* sky,
                                      std::span<const glm::vec3> radiosity) const;

  // Values at vertices from values at their points, such as NearSunlight's change.
  std::vector<glm::vec3> AtVertices(std::span<const glm::vec3> at_points) const;
  std::vector<glm::vec3> AtVerticesOf(std::size_t part, std::span<const glm::vec3> at_points) const;

  // The vertices, and points around them, of a part: [begin, end).
  struct Range {
    std::size_t begin = 0;
    std::size_t end = 0;
  };
  Range VerticesOf(std::size_t part) const;
  std::span<const Receiver> PointsOf(std::size_t part) const;

  // Where a vertex's light comes from: on_object(point, face, share) for faces of the objects,
  // on_direction(direction, share) for all else. Shares are of the vertex's hemisphere.
  template <class OnObject, class OnDirection>
  void ForSources(std::size_t vertex,
                  const OnObject& on_object,
                  const OnDirection& on_direction) const {
    const Part& part = parts_[vertex / kVerticesPerPart];
    const std::size_t first = (vertex % kVerticesPerPart) * kPointsPerVertex;
    for (std::size_t i = first; i < first + kPointsPerVertex; ++i) {
      const float weight = part.weights[i];
      if (weight == 0.0f) continue;
      const glm::vec3& point_m = points_[vertex * kPointsPerVertex + i - first].position_m;
      for (const auto& [face, share] : part.rays.FacesOf(i)) {
        if (static_cast<std::size_t>(face) >= object_faces_) break;
        on_object(point_m, static_cast<std::size_t>(face), weight * share);
      }
      const float each = weight / static_cast<float>(part.rays.RaysPerReceiver());
      for (const glm::vec3& direction : part.rays.SkyDirectionsOf(i)) on_direction(direction, each);
      for (const glm::vec3& direction : part.rays.OtherDirectionsOf(i)) {
        on_direction(direction, each);
      }
    }
  }
  // A vertex within a part of an object, which gets the mean of its neighbours.
  struct Buried {
    std::uint32_t vertex = 0;
    std::vector<std::uint32_t> neighbours;  // Those that are not buried.
  };
  // Whether a vertex lies within a part of an object. Known once its part has been cast.
  bool IsBuried(std::size_t vertex) const {
    return parts_[vertex / kVerticesPerPart].is_buried[vertex % kVerticesPerPart];
  }
  // Known once all rays have been cast; they depend on the objects alone.
  const std::vector<Buried>& BuriedVertices() const { return buried_; }
  static void Fill(std::span<const Buried> buried, std::span<glm::vec3> at_vertices);

  std::size_t VertexCount() const { return points_.size() / kPointsPerVertex; }
  int RaysPerVertex() const {
    return of_point_.rays_per_receiver * static_cast<int>(kPointsPerVertex);
  }

 private:
  struct Part {
    GatheredRays rays;            // Over the objects' faces, then the real ones.
    std::vector<float> weights;   // The weights of a vertex's points add up to 1.
    std::vector<bool> is_buried;  // Per vertex.
  };
  void CastPart(const PatchScene& objects, const PatchScene& real, std::size_t part);
  void FindBuried(const Mesh& objects);

  std::size_t object_faces_ = 0;
  std::size_t real_faces_ = 0;
  std::vector<Receiver> points_;
  GatherOptions of_point_;
  std::vector<Part> parts_;
  std::size_t lacking_ = 0;  // Parts that have not been cast.
  std::vector<Buried> buried_;
};

}  // namespace pleinair
