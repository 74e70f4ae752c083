// The real and the virtual geometry, on both sides of the bus, in the renderer's own frame.
#pragma once

#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "render/compositor.h"
#include "render/internal/caster_buffers.h"
#include "render/internal/object_mesh.h"
#include "render/internal/screen_extent.h"
#include "render/internal/shadow_caster.h"
#include "scene/camera.h"
#include "scene/state_id.h"

namespace pleinair {

// "Local" is world with its origin moved into the middle of the real scene, so that float keeps its
// digits where the geometry is; axes are the world's.
class SceneGeometry {
 public:
  // Throw std::invalid_argument naming the mesh and the field that makes no sense.
  void SetPhantom(const Mesh& mesh_world);
  void SetObjects(std::vector<VirtualObject> objects);

  std::span<const VirtualObject> Objects() const { return objects_; }
  const ShadowCaster& Phantom() const { return phantom_; }
  const ShadowCaster& ObjectsAsCaster() const { return objects_caster_; }
  CasterBuffers& PhantomBuffers() { return phantom_buffers_; }
  const CasterBuffers& PhantomBuffers() const { return phantom_buffers_; }
  CasterBuffers& ObjectBuffers() { return object_buffers_; }
  ObjectMesh& ShadedObjects() { return shaded_objects_; }
  const std::optional<BoundingBox>& PhantomBoxLocal() const { return phantom_box_; }
  const std::optional<BoundingBox>& ObjectBoxLocal() const { return object_box_; }

  glm::dmat4 CameraFromLocal(const Camera& camera) const;
  // Another one whenever any geometry changes.
  StateId Id() const { return id_; }

 private:
  std::vector<glm::vec3> LocalFromWorld(std::span<const glm::vec3> positions_world) const;
  void RebuildObjects();

  glm::dvec3 origin_world_m_{0.0};
  std::vector<VirtualObject> objects_;
  ShadowCaster phantom_;
  ShadowCaster objects_caster_;
  CasterBuffers phantom_buffers_;
  CasterBuffers object_buffers_;
  ObjectMesh shaded_objects_;
  std::optional<BoundingBox> phantom_box_;
  std::optional<BoundingBox> object_box_;
  StateId id_ = StateId::Next();
  bool has_phantom_origin_ = false;
};

// The view of one camera: common data of the passes over the undistorted layers.
struct LayerView {
  CameraIntrinsics intrinsics;  // Without distortion.
  glm::dmat4 clip_from_local{1.0};
  glm::vec3 camera_centre_local{0.0f};
  glm::dmat4 camera_from_local{1.0};
  PixelRect object_rect;  // Where virtual objects can show.

  // Data for VolumeStencil; the point at infinity lies away from the sun.
  glm::vec4 ClipOfInfinity(const glm::dvec3& to_sun) const {
    return glm::vec4(clip_from_local * glm::dvec4(-to_sun, 0.0));
  }
};

// `undistorted` may be larger than the camera's own picture: see UndistortedCover.
LayerView MakeLayerView(const SceneGeometry& scene,
                        const Camera& camera,
                        const CameraIntrinsics& undistorted);

}  // namespace pleinair
