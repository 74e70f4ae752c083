// Where the real scene would lie in the virtual objects' sun shadow.
#pragma once

#include "render/internal/frame_buffer.h"
#include "render/internal/scene_geometry.h"
#include "render/internal/volume_stencil.h"
#include "scene/state_id.h"

namespace pleinair {

// The shadow on real surfaces, also on those that the objects hide: a pixel that an object only
// partly covers needs it. Real casters play no part: nature has drawn their shadow already.
class RealShadowPass {
 public:
  RealShadowPass();

  // The objects' volumes, and the unit direction to the sun that they extend from.
  struct SunVolumes {
    const ShadowVolumes& volumes;
    glm::dvec3 to_sun;
  };

  // Mask() becomes 1 where a real surface lies in the volumes, 0 elsewhere. Nothing is looked for
  // outside `rect`.
  void Draw(const LayerView& view,
            const PixelRect& rect,
            SceneGeometry& scene,
            const SunVolumes& of_objects,
            VolumeStencil& stencil);
  void Clear(int width, int height);

  const FrameBuffer& Mask() const { return target_; }

 private:
  FrameBuffer target_;
  ShaderProgram one_program_;
  GlObject no_vertices_;
  // The phantom's depth is kept while neither camera nor geometry moves.
  glm::dmat4 depth_clip_from_local_{0.0};
  StateId depth_of_scene_;
};

}  // namespace pleinair
