// Puts the layers into the camera's picture, pixel by pixel.
#pragma once

#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "render/internal/blur_kernel.h"
#include "render/internal/frame_buffer.h"
#include "render/internal/layer_lookup.h"
#include "render/internal/rect_texture.h"
#include "render/internal/shader_program.h"
#include "render/internal/surface_textures.h"

namespace pleinair {

// Light of the frame in the layers' units.
struct CompositeLight {
  glm::dvec3 to_sun{0.0, 0.0, 1.0};
  glm::vec3 sun_irradiance{0.0f};
  std::vector<glm::vec3> sky_irradiance;  // Per sky shape of the view.
};

// The input of the pass: textures of the frame, and the parts of the camera's picture where they
// can matter.
struct CompositeLayers {
  const SurfaceTextures& surface;
  const LayerLookup& lookup;
  GLuint object_layer = 0;
  GLuint shadow_mask = 0;
  const RectTexture<glm::vec4>& change;  // Alpha is not used.
  // Shares of the sun's disc; replaces the mask unless empty.
  const RectTexture<float>& hidden_sun;
  const BlurKernel& shadow_blur;  // Blur of hidden_sun.
  PixelRect object_rect;
  PixelRect mask_rect;
  PixelRect hidden_rect;

  PixelRect ShadowRect() const { return UnionOf(mask_rect, hidden_rect); }
  PixelRect RelitRect() const { return UnionOf(ShadowRect(), change.Rect()); }
  PixelRect Rect() const { return UnionOf(object_rect, RelitRect()); }
  // What is read of the view: a pixel's sun is found from pixels around it, too.
  PixelRect ViewRect(int width, int height) const;
  // And of the camera's picture.
  PixelRect CameraRect(int width, int height) const {
    return UnionOf(Rect(), ViewRect(width, height));
  }
};

class CompositePass {
 public:
  // More sky shapes than this are refused by the compositor.
  static constexpr int kMaxSkyShapes = 128;

  CompositePass();

  // Draws into Target(): radiance in the layers' units, alpha the PixelChange / 255. Only
  // layers.Rect() is defined. `gain` takes camera radiance to the layers' units.
  void Draw(const CompositeLayers& layers,
            const CompositeLight& light,
            float gain,
            int width,
            int height);

  const FrameBuffer& Target() const { return target_; }

 private:
  void MarkRelit(const CompositeLayers& layers);
  void Relight(const CompositeLayers& layers, const CompositeLight& light, float gain);

  FrameBuffer target_;
  ShaderProgram shadowed_program_;
  ShaderProgram changed_program_;
  ShaderProgram cover_program_;
  ShaderProgram relight_program_;
  GlObject no_vertices_;
};

}  // namespace pleinair
