// Light on virtual objects from a single probe among them: for a field without walls near by,
// where the light on an object depends only on which way its surface faces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "objects/frame_basis.h"
#include "objects/object_light_options.h"
#include "objects/sphere_view.h"
#include "relight/transport/patch_scene.h"

namespace pleinair {

// Leaves out what objects hide from themselves and each other, and sunlight close to them.
//
// Its error is estimated from fourteen other places, the corners and the middles of the sides of
// the box around all objects (pulled in by a hundredth: objects stand on the ground). They see with
// few rays, and so does the middle for the comparison: both then have the same errors of few rays.
class SingleProbeLight {
 public:
  // `real` and `options` outlive this.
  SingleProbeLight(const PatchScene& real, const SingleProbeOptions& options);

  // Sets the objects' new places; see ObjectInterreflection::Objects().
  void Pose(const Mesh& objects);
  // Computes the lights that shine in `lighting` and are not current; the first call casts the
  // rays.
  void Update(const FrameBasis& basis, const Lighting& lighting);
  // The same at the other places, for Compare.
  void UpdateOthers(const FrameBasis& basis, const Lighting& lighting);

  // Irradiance per vertex of the objects, from one unit of a light that Update was given.
  std::vector<glm::vec3> OnObjects(std::size_t light) const;

  // Irradiance of one facing, here and at another place of the objects.
  struct Compared {
    glm::vec3 here{0.0f};
    glm::vec3 there{0.0f};
  };
  // For lights that UpdateOthers was given.
  std::vector<Compared> Compare(const Lighting& lighting) const;
  // The largest radiance that is seen from here.
  glm::vec3 LargestRadiance(const Lighting& lighting) const;

 private:
  struct OfLight {
    std::vector<glm::vec3> coefficients;  // SH, of irradiance.
    std::vector<glm::vec3> radiance;      // Seen from here.
  };
  struct Comparison {
    std::vector<glm::vec3> here;   // Irradiance from the coefficients, by facing.
    std::vector<glm::vec3> there;  // [other place * facings + facing].
  };

  std::vector<float> BasisAt(std::span<const glm::vec3> directions) const;
  // `basis`: its values for the normal.
  static glm::vec3 Irradiance(const OfLight& light, const float* basis);
  OfLight Make(const SkyShape* sky, std::span<const glm::vec3> face_radiosity) const;
  Comparison MakeComparison(const OfLight& light,
                            const SkyShape* sky,
                            std::span<const glm::vec3> face_radiosity) const;

  const PatchScene& real_;
  const SingleProbeOptions& options_;
  std::vector<glm::vec3> normals_;  // Normals of the objects' vertices.
  std::vector<glm::vec3> places_m_;
  std::vector<glm::vec3> facings_;
  std::vector<float> facing_basis_;
  // SH basis values of the directions that are seen here, and of the vertices' normals.
  std::vector<float> direction_basis_;
  std::vector<float> normal_basis_;
  SphereView here_;   // Cast with the first light of a pose.
  SphereView there_;  // The middle, then the other places; cast with the first comparison.
  std::vector<OfLight> lights_;
  LightsDone done_;
  std::vector<Comparison> comparisons_;
  LightsDone compared_;
};

}  // namespace pleinair
