// A layer as a lens that is not quite sharp shows it.
#pragma once

#include "render/internal/frame_buffer.h"
#include "render/internal/gl_object.h"
#include "render/internal/screen_extent.h"
#include "render/internal/shader_program.h"

namespace pleinair {

class BlurPass {
 public:
  BlurPass();

  // What `rect` of a layer grows to; inside the picture.
  static PixelRect Spread(const PixelRect& rect, float sigma_px, int width, int height);

  // Convolves a layer, which is zero outside `rect`, with a Gaussian, cut off at three
  // sigma; beyond the picture it goes on as at its border. What covers less than 1/512 of a pixel
  // is left out. Zero outside Spread(rect). sigma_px > 0, at most kMostPx.
  void Draw(GLuint layer, const PixelRect& rect, float sigma_px, int width, int height);
  static constexpr float kMostPx = 8.0f;

  const FrameBuffer& Layer() const { return both_ways_; }

 private:
  FrameBuffer one_way_;
  FrameBuffer both_ways_;
  ShaderProgram program_;
  GlObject no_vertices_;
};

}  // namespace pleinair
