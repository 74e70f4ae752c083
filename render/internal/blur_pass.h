// A layer as a lens that is not quite sharp shows it.
#pragma once

#include "render/internal/blur_kernel.h"
#include "render/internal/frame_buffer.h"
#include "render/internal/gl_object.h"
#include "render/internal/screen_extent.h"
#include "render/internal/shader_program.h"

namespace pleinair {

class BlurPass {
 public:
  BlurPass();

  // Convolves a layer, which is zero outside `rect`, with the kernel; beyond the picture its border
  // is repeated. Coverage below 1/512 of a pixel is left out. Zero outside the kernel's Spread of
  // `rect`.
  void Draw(GLuint layer, const PixelRect& rect, const BlurKernel& kernel, int width, int height);

  const FrameBuffer& Layer() const { return both_ways_; }

 private:
  FrameBuffer one_way_;
  FrameBuffer both_ways_;
  ShaderProgram program_;
  GlObject no_vertices_;
};

}  // namespace pleinair
