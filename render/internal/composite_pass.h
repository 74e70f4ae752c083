// Puts the layers into the camera's picture, pixel by pixel.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "render/internal/frame_buffer.h"
#include "render/internal/layer_lookup.h"
#include "render/internal/shader_program.h"
#include "render/internal/surface_textures.h"

namespace pleinair {

// Light of the frame in the layers' units.
struct CompositeLight {
  glm::dvec3 to_sun{0.0, 0.0, 1.0};
  glm::vec3 sun_irradiance{0.0f};
  std::vector<glm::vec3> sky_irradiance;  // Per sky shape of the view.
};

class CompositePass {
 public:
  // More sky shapes than this are refused by the compositor.
  static constexpr int kMaxSkyShapes = 128;

  CompositePass();

  // Draws into Target() inside `rect`: radiance in the layers' units, alpha the PixelChange / 255;
  // alpha is 0 outside. `gain` takes camera radiance to the layers' units.
  void Draw(const SurfaceTextures& surface,
            const LayerLookup& lookup,
            GLuint object_layer,
            GLuint shadow_mask,
            const CompositeLight& light,
            float gain,
            int width,
            int height,
            const PixelRect& rect);

  const FrameBuffer& Target() const { return target_; }

 private:
  FrameBuffer target_;
  ShaderProgram program_;
  GlObject no_vertices_;
};

}  // namespace pleinair
