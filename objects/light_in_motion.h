// Light at the vertices of virtual objects while they move as rigid bodies. The effect of their own
// shape is kept, light from outside follows each pose, and the rest is gathered in turn.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "objects/frame_basis.h"
#include "objects/internal/object_cone.h"
#include "objects/internal/own_shape.h"
#include "objects/object_gather.h"
#include "objects/object_interreflection.h"
#include "relight/prepared_scene.h"
#include "relight/transport/patch_scene.h"

namespace pleinair {

// Per light, irradiance at all objects' vertices; empty where it was not asked for.
using VerticesByLight = std::vector<std::vector<glm::vec3>>;

// Objects in one pose, and the pose: for each object, the transform from where it was given.
struct PlacedObjects {
  const ObjectInterreflection& objects;
  std::span<const glm::dmat4> world_from_given;
};

// Some of a basis's lights, by their numbers.
struct LightSubset {
  const FrameBasis& basis;
  std::span<const std::size_t> lights;
};

// The light at a vertex is a base and a correction,
//   E = sum over cells of share * pi L + sum over own faces of share * B + correction.
// The base is exact in the object's own shape (see OwnShape). Eight probes in the object's box see
// the sky and real surfaces, with the objects' shadow on those; their light is a function that is
// linear over the box. The base is computed for every pose. The correction is the rest that
// gathering at the vertex itself last found: light that varies otherwise over the object, and other
// objects. It changes slowly as the object moves, and is updated for some vertices a frame. It
// fades out where the object has since moved far or turned.
//
// Threads  The result does not depend on their number.
class LightInMotion {
 public:
  // `scene` outlives this.
  explicit LightInMotion(const PreparedScene& scene);

  // Whether a pose keeps angles, so that what is kept of a shape holds: rigid, or to another scale.
  static bool KeepsShape(const glm::dmat4& world_from_given);

  // Whether there is light that can follow the objects.
  bool Empty() const { return shape_.Empty(); }

  // Starts with light that was gathered where the objects stood.
  void Start(const PlacedObjects& stood,
             const ObjectGather& gather,
             const VerticesByLight& irradiance,
             const LightSubset& of);

  // Light at the vertices of a part of the objects, without what those reflect, as gathered now.
  struct Gathered {
    std::size_t part = 0;
    VerticesByLight irradiance;
  };
  // Irradiance of those lights at the present place; `gathered` are parts of `gather` there.
  void Update(const PlacedObjects& placed,
              const ObjectGather& gather,
              std::span<const Gathered> gathered,
              const LightSubset& of,
              VerticesByLight& irradiance);

 private:
  using Poses = std::shared_ptr<const std::vector<glm::dmat4>>;
  // What an object's probes see, in one pose: ray [probe * directions + direction].
  struct Seen {
    glm::dmat4 world_from_given{0.0};
    std::vector<std::int32_t> sources;  // A real face, or PatchScene::kSky.
    // Places on real faces close by: off the surface.
    struct Place {
      std::size_t ray = 0;
      glm::vec3 start_m{0.0f};
    };
    std::vector<Place> near;
  };
  Seen SeenFrom(const ObjectBounds& object, const glm::dmat4& world_from_given) const;
  // Radiance along each ray per unit of a light. As in NearSunlight, places close by are in
  // the sun or not, past the objects too.
  std::vector<glm::vec3> Radiance(const Seen& seen,
                                  const PatchScene& objects,
                                  const FrameBasis& basis,
                                  std::size_t light) const;

  // Without what objects reflect: [vertex * lights + light].
  std::vector<glm::vec3> OutsideOf(const PlacedObjects& placed, const LightSubset& of);
  // [face * lights + light].
  std::vector<glm::vec3> FaceRadiosity(const ObjectInterreflection& objects,
                                       std::span<const glm::vec3> outside,
                                       std::span<const std::size_t> lights) const;
  // How much of its correction each part and object keeps in these poses: [part * objects +
  // object].
  std::vector<float> WeightsOf(const PlacedObjects& placed) const;

  const PatchScene* real_;
  bool surfaces_reflect_ = true;
  std::vector<glm::vec3> directions_;
  OwnShape shape_;
  std::vector<ObjectGather::Buried> buried_;
  std::vector<Seen> seen_;  // One an object.
  // By light and vertex: of light from outside, and of all light.
  VerticesByLight outside_correction_;
  VerticesByLight correction_;
  std::vector<Poses> corrected_at_;  // By part.
};

}  // namespace pleinair
