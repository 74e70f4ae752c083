// Light between virtual objects: what they hide of the irradiance volume from themselves and each
// other, and what they reflect in its place.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "objects/virtual_object.h"
#include "relight/transport/transport.h"
#include "scene/lighting.h"

namespace pleinair {

// Set up once per pose of the objects; the rays between them with the first that needs them.
//
// A vertex gets the volume's irradiance for the share of its hemisphere (cosine-weighted) that no
// object hides. For the rest it gets one reflection off the objects, of the shadowed sun and of the
// volume's light. It is not considered which part of the sky is hidden: exact where light is the
// same from everywhere.
class ObjectInterreflection {
 public:
  explicit ObjectInterreflection(const std::vector<VirtualObject>& objects);

  // Casts the sun's shadows onto the objects, past `real` casters and the objects themselves.
  void UpdateSun(const RayCaster& real, const glm::dvec3& sun_direction_enu);

  // Turns the volume's irradiance at the vertices, one list an object, into what reaches them.
  // `direct` is what reaches them besides, with objects' shadows in it already, and is reflected
  // too: all objects' vertices in one list, or empty.
  void Apply(const DirectionalLight& sun,
             std::span<std::vector<glm::vec3>> vertex_irradiance,
             std::span<const glm::vec3> direct = {});

  // Bound of the share of a vertex's view, cosine-weighted, that objects hide beyond its own
  // tangent plane. It includes the share behind any of the vertex's triangles. 0 for a box and,
  // nearly, for a ball. None where it is more than `most`, which a few vertices can show; else all
  // rays are cast.
  std::optional<float> LargestHiddenUpTo(float most);
  // The rays between the objects; cast at the first call.
  void CastRays();
  bool HasCastRays() const { return has_cast_rays_; }

  // All objects' triangles in the world, a group an object.
  const PatchScene& Objects() const { return scene_; }
  // Radiosity of the faces of Objects() under the sun and the irradiance that Apply made. What they
  // mirror of sky and surfaces is treated as diffuse. What they mirror of the sun is left out: it
  // lands in a spot, and spread all around it would light what it misses.
  // Shape  one entry a face; `vertex_irradiance` as for Apply.
  std::vector<glm::vec3> FaceRadiosity(
      const DirectionalLight& sun, std::span<const std::vector<glm::vec3>> vertex_irradiance) const;

 private:
  PatchScene scene_;
  std::vector<Receiver> vertices_;
  bool has_cast_rays_ = false;
  float least_known_ = 0.0f;  // LargestHidden is at least this, by a few vertices.
  GatheredRays rays_;
  std::vector<glm::vec3> hidden_;  // Per vertex: share of its hemisphere.
  std::vector<glm::vec3> face_diffuse_albedo_;
  std::vector<float> face_sun_;       // Per face: irradiance for a unit beam.
  float largest_turned_away_ = 0.0f;  // Share of a vertex's view, behind one of its triangles.
};

}  // namespace pleinair
