// The hard sun shadow on whatever is nearest: every caster on every surface.
#pragma once

#include "render/internal/frame_buffer.h"
#include "render/internal/scene_geometry.h"
#include "render/internal/volume_stencil.h"
#include "scene/image.h"

namespace pleinair {

class ShadowMaskPass {
 public:
  ShadowMaskPass();

  // 255 where only a caster keeps the sun from the visible side, else 0.
  Gray8Image Draw(const LayerView& view,
                  SceneGeometry& scene,
                  const glm::dvec3& to_sun,
                  VolumeStencil& stencil);

 private:
  void DrawSunlitSides(const ShadowCaster& caster,
                       const CasterBuffers& buffers,
                       const glm::dvec3& to_sun);

  FrameBuffer target_;
  ShaderProgram one_program_;
  GlObject sunlit_indices_;
};

}  // namespace pleinair
