// The renderer's shadow volumes alone: the hard sun shadow on whatever is nearest.
#pragma once

#include <vector>

#include "render/compositor.h"
#include "render/internal/frame_buffer.h"
#include "render/internal/scene_geometry.h"
#include "render/internal/shader_program.h"
#include "render/internal/volume_stencil.h"
#include "scene/camera.h"
#include "scene/image.h"
#include "scene/mesh.h"

namespace pleinair::test {

// Every caster on every surface. Needs a current context.
class ShadowMask {
 public:
  ShadowMask();

  void SetPhantom(const Mesh& mesh_world) { scene_.SetPhantom(mesh_world); }
  void SetObjects(std::vector<VirtualObject> objects) { scene_.SetObjects(std::move(objects)); }

  // In each pixel of an undistorted camera: 255 where only a caster keeps the sun from the visible
  // side; 0 lit, facing away or empty. `to_sun` is a unit vector.
  Gray8Image Draw(const Camera& camera, const glm::dvec3& to_sun);

 private:
  void DrawSunlitSides(const ShadowCaster& caster,
                       const glm::mat4& clip_from_local,
                       const glm::dvec3& to_sun);

  SceneGeometry scene_;
  VolumeStencil stencil_;
  FrameBuffer target_;
  ShaderProgram one_program_;
  CasterBuffers sunlit_;
};

}  // namespace pleinair::test
