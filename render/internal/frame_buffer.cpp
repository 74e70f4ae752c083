#include "render/internal/frame_buffer.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <stdexcept>
#include <utility>

namespace pleinair {
namespace {

const char* FormatName(GLenum format) {
  switch (format) {
    case GL_RGBA16F:
      return "RGBA16F";
    case GL_RGBA32F:
      return "RGBA32F";
    case GL_R8:
      return "R8";
    case GL_R32UI:
      return "R32UI";
    default:
      return "its format";
  }
}

}  // namespace

FrameBuffer::FrameBuffer(std::string name, GLenum colour_format, DepthStencil depth_stencil)
    : name_(std::move(name)), colour_format_(colour_format), depth_stencil_kind_(depth_stencil) {}

bool FrameBuffer::Resize(int width, int height) {
  if (width == width_ && height == height_) return false;
  GLint max_size = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &max_size);
  if (width > max_size || height > max_size) {
    throw std::runtime_error("framebuffer " + name_ + ": " + std::to_string(width) + "x" +
                             std::to_string(height) + " pixels, this device draws at most " +
                             std::to_string(max_size) + " a side");
  }
  width_ = 0;  // Until all is made.
  frame_buffer_ = MakeFramebuffer();
  glBindFramebuffer(GL_FRAMEBUFFER, frame_buffer_.Name());
  colour_ = MakeTexture();
  glBindTexture(GL_TEXTURE_2D, colour_.Name());
  glTexStorage2D(GL_TEXTURE_2D, 1, colour_format_, width, height);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, colour_.Name(), 0);
  if (depth_stencil_kind_ == DepthStencil::kDepth24Stencil8) {
    depth_stencil_ = MakeRenderbuffer();
    glBindRenderbuffer(GL_RENDERBUFFER, depth_stencil_.Name());
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, width, height);
    glFramebufferRenderbuffer(
        GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth_stencil_.Name());
  }
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) {
    throw std::runtime_error("framebuffer " + name_ + ": this device cannot draw into " +
                             FormatName(colour_format_) +
                             (depth_stencil_ ? " with 24-bit depth and 8-bit stencil" : ""));
  }
  width_ = width;
  height_ = height;
  return true;
}

void FrameBuffer::Reserve(int width, int height) {
  if (width <= width_ && height <= height_) return;
  // In steps, so that a moving object does not make a new buffer each frame.
  constexpr int kStep = 64;
  const auto rounded = [](int size) { return (size + kStep - 1) / kStep * kStep; };
  Resize(std::max(width_, rounded(width)), std::max(height_, rounded(height)));
}

void FrameBuffer::ShareDepthStencilOf(const FrameBuffer& other) {
  glBindFramebuffer(GL_FRAMEBUFFER, frame_buffer_.Name());
  glFramebufferRenderbuffer(
      GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, other.depth_stencil_.Name());
}

void FrameBuffer::Bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, frame_buffer_.Name());
  glViewport(0, 0, width_, height_);
}

void FrameBuffer::BindForReading() const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, frame_buffer_.Name());
}

void ResetPassState() {
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_POLYGON_OFFSET_FILL);
  glDisable(GL_RASTERIZER_DISCARD);
  glDisable(GL_SAMPLE_ALPHA_TO_COVERAGE);
  glDisable(GL_SAMPLE_COVERAGE);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_STENCIL_TEST);
  if (epoxy_is_desktop_gl()) glDisable(GL_FRAMEBUFFER_SRGB);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
  glDepthRangef(0.0f, 1.0f);
  glStencilMask(0xff);
  glFrontFace(GL_CW);
  glClearColor(0.0f, 0.0f, 0.0f, 0.0f);
  glClearDepthf(1.0f);
  glClearStencil(0);
}

void ScissorTo(const PixelRect& rect) {
  glEnable(GL_SCISSOR_TEST);
  glScissor(rect.lower.x, rect.lower.y, rect.Width(), rect.Height());
}

namespace {

// Both desktop OpenGL and ES 3.1 have these; 0 by default, but alignments, which each transfer
// sets.
constexpr std::array<GLenum, 10> kPixelLayout{GL_UNPACK_ROW_LENGTH,
                                              GL_UNPACK_IMAGE_HEIGHT,
                                              GL_UNPACK_SKIP_ROWS,
                                              GL_UNPACK_SKIP_PIXELS,
                                              GL_UNPACK_SKIP_IMAGES,
                                              GL_UNPACK_ALIGNMENT,
                                              GL_PACK_ROW_LENGTH,
                                              GL_PACK_SKIP_ROWS,
                                              GL_PACK_SKIP_PIXELS,
                                              GL_PACK_ALIGNMENT};

}  // namespace

ApplicationState::ApplicationState() {
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw_frame_buffer_);
  glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &read_frame_buffer_);
  glGetIntegerv(GL_VIEWPORT, viewport_);
  glGetIntegerv(GL_PIXEL_UNPACK_BUFFER_BINDING, &unpack_buffer_);
  glGetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &pack_buffer_);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  for (std::size_t i = 0; i < kPixelLayout.size(); ++i) {
    glGetIntegerv(kPixelLayout[i], &pixel_layout_[i]);
    const bool is_alignment =
        kPixelLayout[i] == GL_UNPACK_ALIGNMENT || kPixelLayout[i] == GL_PACK_ALIGNMENT;
    glPixelStorei(kPixelLayout[i], is_alignment ? 1 : 0);
  }
}

ApplicationState::~ApplicationState() {
  ResetPassState();
  glFrontFace(GL_CCW);
  glBindVertexArray(0);
  glUseProgram(0);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw_frame_buffer_));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(read_frame_buffer_));
  glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, static_cast<GLuint>(unpack_buffer_));
  glBindBuffer(GL_PIXEL_PACK_BUFFER, static_cast<GLuint>(pack_buffer_));
  for (std::size_t i = 0; i < kPixelLayout.size(); ++i) {
    glPixelStorei(kPixelLayout[i], pixel_layout_[i]);
  }
}

}  // namespace pleinair
