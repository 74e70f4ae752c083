// What leaving an effect out would change at most in the displayed picture, told before it is run.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include "objects/frame_basis.h"
#include "objects/object_reach.h"
#include "objects/soft_sun.h"
#include "objects/vertex_light.h"
#include "pipeline/display_codes.h"
#include "pipeline/effect_plan.h"
#include "relight/transport/patch_scene.h"
#include "scene/frame.h"
#include "scene/lighting.h"
#include "scene/surface_view.h"

namespace pleinair {

// What a frame's bounds are made of. References live for the call only.
struct BoundInput {
  const Frame& frame;
  const SurfaceView& view;
  const FrameBasis& basis;
  const Lighting& lighting;
  const DisplayCodes& codes;
  // Light at the objects' vertices where it is known already; else empty.
  std::span<const std::vector<glm::vec3>> vertex_irradiance;
  double camera_blur_px = 0.0;  // As measured.
  // Bounds that are far above this need not be any closer.
  double threshold_code_values = 1.0;
};

struct Bound {
  double code_values = 0.0;
  std::string_view why;
};

// Keeps what hangs on view, sun and objects alone.
//
// Bounds are upper ones but for four things, each as fine as the effect itself is: what reaches an
// object between its vertices and the middles of its faces is missed (AnySeesSun), what a shadow
// narrower than a pixel does (SoftSun), the noise of the rays at vertices, which the light at one
// place has less of (LightVariation), and shadows where objects hide more than three quarters of
// the light from elsewhere, under what overhangs (SunShadow).
class EffectBounds {
 public:
  // `real_caster` and `objects` outlive this, `scene_albedo` is the highest of the real surfaces.
  EffectBounds(const RayCaster& real_caster,
               const PatchScene& objects,
               const SoftSun& soft_sun,
               const glm::vec3& scene_albedo);
  // Before the first frame, and after objects have moved.
  void ObjectsMoved();
  void Forget();

  // Of the objects' materials.
  bool AnyGlossy() const { return any_glossy_; }

  // All light but the sun's on objects: first, since what it brings makes others' bounds closer.
  Bound ProbeShading(const BoundInput& input);
  // Of taking the light at one place for that at the vertices; `probe_shading` is all of it.
  Bound LightVariation(const BoundInput& input, const Bound& probe_shading, VertexLight& light);
  // Of what objects hide of that light from themselves and reflect, and of sunlight close to them.
  Bound SelfOcclusion(const BoundInput& input, const Bound& probe_shading, VertexLight& light);
  // Of direct daylight by samples, on objects and of what they hide of it.
  Bound Daylight(const BoundInput& input, const VertexLight& light);
  Bound SunShading(const BoundInput& input);
  // On objects in the sun, whether or not they are.
  Bound ObjectShadow(const BoundInput& input);
  Bound SunShadow(const BoundInput& input);
  Bound SkyOcclusion(const BoundInput& input);
  Bound ColourBleeding(const BoundInput& input);
  Bound GlossyReflection(const BoundInput& input);
  // Of what is matched to the camera.
  Bound CameraBlur(const BoundInput& input) const;
  Bound CameraNoise(const BoundInput& input) const;

  bool InView(const SurfaceView& view);

 private:
  bool SunReachesObjects(const FrameBasis& basis);
  // Irradiance that nothing in the scene exceeds, the disc's own left out.
  glm::vec3 LargestIrradiance(const BoundInput& input) const;
  // Likewise with what objects send each other.
  glm::vec3 LargestIrradianceOnObjects(const BoundInput& input) const;
  Bound SunOnObjects(const BoundInput& input);
  double SunOnFaces(const BoundInput& input) const;
  template <class ChangeOf>
  float ChangeOfFacings(const BoundInput& input,
                        float hidden,
                        const OnePlaceLight& one_place,
                        const ChangeOf& change_of) const;
  const InfluenceReach& Reach(const SurfaceView& view);
  // Where real surfaces' light is at least (1 - hidden) of itself, and grows by `added` at most.
  double ChangeOfReached(const BoundInput& input,
                         const InfluenceReach& reach,
                         const glm::vec3& hidden,
                         const glm::vec3& added) const;

  const RayCaster& real_caster_;
  const PatchScene& objects_;
  const SoftSun& soft_sun_;
  glm::vec3 scene_albedo_;
  // Highest of the objects' materials.
  glm::vec3 object_diffuse_{0.0f};
  glm::vec3 object_albedo_{0.0f};  // What they mirror included.
  bool any_glossy_ = false;

  std::optional<std::uint64_t> in_view_version_;
  bool in_view_ = false;
  std::optional<std::uint64_t> sun_version_;
  bool sun_reaches_ = false;
  std::optional<std::uint64_t> reach_version_;
  InfluenceReach reach_;
  std::optional<std::uint64_t> near_shadow_version_;
  std::vector<std::uint32_t> near_shadow_;
};

}  // namespace pleinair
