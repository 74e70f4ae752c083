// State that effects share: the objects among the real surfaces, the light on them, and results of
// both that are kept from frame to frame.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "objects/object_influence.h"
#include "objects/object_reach.h"
#include "objects/posed_objects.h"
#include "objects/soft_sun.h"
#include "objects/vertex_light.h"
#include "pipeline/frame_pipeline.h"
#include "pipeline/internal/effects/frame_effect.h"
#include "pipeline/internal/effects/kept_influence.h"
#include "pipeline/internal/effects/kept_mirror.h"
#include "pipeline/internal/effects/kept_object_view.h"
#include "scene/cached.h"
#include "scene/state_id.h"

namespace pleinair {

// Shared by the effects of one pipeline. One thread at a time.
class EffectStage {
 public:
  // `scene`, `phantom` and `options` outlive this. Without objects until Pose.
  EffectStage(const PreparedScene& scene, const Mesh& phantom, const FramePipelineOptions& options);
  EffectStage(const EffectStage&) = delete;
  EffectStage& operator=(const EffectStage&) = delete;

  // Replaces the objects and their poses; they outlive this.
  void Pose(const PosedObjects& objects);

  const PreparedScene& Scene() const { return scene_; }
  const FramePipelineOptions& Options() const { return options_; }
  const PatchScene& Objects() const { return light_.Objects(); }
  const RayCaster& RealSurfaces() const { return real_caster_; }
  const SoftSun& SunPastObjects() const { return soft_sun_; }
  VertexLight& Light() { return light_; }
  const VertexLight& Light() const { return light_; }
  KeptObjectView& ViewOfObjects() { return object_view_; }
  KeptInfluence& Influence() { return influence_; }
  const KeptInfluence& Influence() const { return influence_; }
  KeptMirror& Mirror() { return mirror_; }

  // Around each object, at its present place.
  const std::vector<BoundingBox>& ObjectBoxes() const { return object_boxes_; }

  // Whether any material of the objects is glossy, and their highest reflectances.
  bool AnyGlossy() const { return any_glossy_; }
  const glm::vec3& LargestDiffuse() const { return largest_diffuse_; }
  const glm::vec3& LargestAlbedo() const { return largest_albedo_; }  // Mirrored light included.

  // Terms of several effects' bounds.
  bool InView(const EffectFrame& frame);
  bool SunReachesObjects(const EffectFrame& frame);
  const InfluenceReach& Reach(const EffectFrame& frame);
  // Upper bound of the irradiance anywhere in the scene, without the sun's disc.
  glm::vec3 LargestIrradiance(const EffectFrame& frame) const;
  // The same with what objects send each other.
  glm::vec3 LargestIrradianceOnObjects(const EffectFrame& frame) const;

 private:
  struct SunOfPose {
    glm::dvec3 sun_direction_enu{0.0};
    StateId poses;
    bool operator==(const SunOfPose&) const = default;
  };

  const PreparedScene& scene_;
  const FramePipelineOptions& options_;
  const Mesh room_;        // As given, where daylight is sampled.
  RayCaster real_caster_;  // Over the mesh as given: its triangles are fewer than the patches.
  glm::vec3 scene_albedo_{0.0f};  // The highest of the real surfaces.
  VertexLight light_;
  SoftSun soft_sun_;
  KeptObjectView object_view_;
  KeptInfluence influence_;
  KeptMirror mirror_;
  std::vector<BoundingBox> object_boxes_;
  glm::vec3 largest_diffuse_{0.0f};
  glm::vec3 largest_albedo_{0.0f};
  bool any_glossy_ = false;
  Cached<bool, ViewOfPose> in_view_;
  Cached<InfluenceReach, ViewOfPose> reach_;
  Cached<bool, SunOfPose> sun_reaches_;
};

}  // namespace pleinair
