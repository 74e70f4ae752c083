#include "pipeline/internal/effects/effect_stage.h"

#include <glm/common.hpp>

#include "pipeline/internal/effects/bound_terms.h"

namespace pleinair {
namespace {

glm::vec3 HighestAlbedo(const PreparedScene& scene) {
  glm::vec3 highest(0.0f);
  for (const glm::vec3& albedo : scene.patches.face_albedo_rgb) {
    highest = glm::max(highest, albedo);
  }
  return highest;
}

}  // namespace

EffectStage::EffectStage(const PreparedScene& scene,
                         const Mesh& phantom,
                         const FramePipelineOptions& options)
    : scene_(scene),
      options_(options),
      room_(options.object_light.daylight == Daylight::kSamples ? phantom : Mesh()),
      real_caster_(phantom),
      scene_albedo_(HighestAlbedo(scene)),
      light_(scene, room_, options.object_light),
      soft_sun_(real_caster_, light_.Objects(), options.soft_sun),
      influence_(options.influence_at) {}

void EffectStage::Pose(const PosedObjects& objects) {
  light_.Pose(objects);
  object_boxes_.clear();
  for (const VirtualObject& object : objects.Objects()) {
    object_boxes_.push_back(object.mesh.Empty() ? BoundingBox() : BoundingBoxOf(object.mesh));
  }
  largest_diffuse_ = largest_albedo_ = glm::vec3(0.0f);
  any_glossy_ = false;
  for (const Material& material : Objects().mesh.materials) {
    const TexturedMaterial::Reflectances shown = BrightestOf(material);
    any_glossy_ = any_glossy_ || shown.specular_reflectance != glm::vec3(0.0f);
    largest_diffuse_ = glm::max(largest_diffuse_, shown.diffuse_albedo);
    largest_albedo_ =
        glm::max(largest_albedo_,
                 glm::min(shown.diffuse_albedo + shown.specular_reflectance, glm::vec3(1.0f)));
  }
}

bool EffectStage::InView(const EffectFrame& frame) {
  return in_view_.Get(frame.Geometry(), [&] { return MayBeInView(Objects(), frame.view.camera); });
}

bool EffectStage::SunReachesObjects(const EffectFrame& frame) {
  return sun_reaches_.Get(SunOfPose{frame.basis.Sun().direction_enu, frame.poses},
                          [&] { return AnySeesSun(Objects(), real_caster_, frame.basis.Sun()); });
}

const InfluenceReach& EffectStage::Reach(const EffectFrame& frame) {
  return reach_.Get(frame.Geometry(),
                    [&] { return ReachOfInfluence(Objects(), frame.view, options_.influence); });
}

glm::vec3 EffectStage::LargestIrradiance(const EffectFrame& frame) const {
  // Close to objects a real face's own place may be in the sun where the face's mean is not.
  glm::vec3 largest = scene_albedo_ * SunOf(frame.lighting);
  for (std::size_t light = 0; light < frame.basis.LightCount(); ++light) {
    largest += IntensityOf(frame.lighting, light) * frame.basis.LargestIrradiance(light);
  }
  return largest;
}

glm::vec3 EffectStage::LargestIrradianceOnObjects(const EffectFrame& frame) const {
  const glm::vec3 of_scene = LargestIrradiance(frame);
  // One reflection off an object, and one off what that is reflected from.
  const glm::vec3 of_objects = largest_albedo_ * (of_scene + SunOf(frame.lighting));
  return glm::max(of_scene, of_objects) + largest_albedo_ * of_objects;
}

}  // namespace pleinair
