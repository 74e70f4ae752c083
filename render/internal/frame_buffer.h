// The target of a pass.
#pragma once

#include <array>
#include <string>

#include <epoxy/gl.h>

#include "render/internal/gl_object.h"
#include "render/internal/screen_extent.h"

namespace pleinair {

// One colour attachment, with a 24-bit depth and 8-bit stencil buffer where asked for. Row 0 is the
// picture's top row.
class FrameBuffer {
 public:
  enum class DepthStencil { kNone, kDepth24Stencil8 };

  FrameBuffer(std::string name, GLenum colour_format, DepthStencil depth_stencil);

  // Makes the attachments again where the size is another; true then, and their content is
  // undefined. Throws std::runtime_error naming the buffer and the format where the device cannot
  // draw into it.
  bool Resize(int width, int height);

  // The same, but only where it is too small: for a buffer of which a corner is used.
  void Reserve(int width, int height);

  // Draws with the depth and stencil of a buffer of the same size, which has them, from now on.
  void ShareDepthStencilOf(const FrameBuffer& other);

  // Binds it for drawing and sets the viewport to all of it.
  void Bind() const;
  void BindForReading() const;

  GLuint ColourTexture() const { return colour_.Name(); }
  int Width() const { return width_; }
  int Height() const { return height_; }

 private:
  std::string name_;
  GLenum colour_format_;
  DepthStencil depth_stencil_kind_;
  int width_ = 0;
  int height_ = 0;
  GlObject colour_;
  GlObject depth_stencil_;
  GlObject frame_buffer_;
};

// Sets all state that our passes rely on to its default, independent of the application that owns
// the context: all tests and blending off, all masks open, our winding (GL_CW).
void ResetPassState();

// Limits drawing and clearing to `rect`.
void ScissorTo(const PixelRect& rect);

// Remembers the application's framebuffers, viewport and layout of pixels in memory, and gives them
// back, with the state of ResetPassState otherwise. Meanwhile pixels lie in memory without gaps,
// and no buffer is bound for them.
class ApplicationState {
 public:
  ApplicationState();
  ~ApplicationState();
  ApplicationState(const ApplicationState&) = delete;
  ApplicationState& operator=(const ApplicationState&) = delete;

 private:
  GLint draw_frame_buffer_ = 0;
  GLint read_frame_buffer_ = 0;
  GLint viewport_[4] = {0, 0, 0, 0};
  GLint unpack_buffer_ = 0;
  GLint pack_buffer_ = 0;
  std::array<GLint, 10> pixel_layout_{};
};

}  // namespace pleinair
