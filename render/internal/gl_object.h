// Names of OpenGL objects, deleted when their owner goes.
#pragma once

#include <epoxy/gl.h>

namespace pleinair {

// Owns one GL object of the context that was current when it was made. When that context is gone,
// or another is current, at the end of its life, nothing is called: the object went with its
// context.
class GlObject {
 public:
  using Deleter = void (*)(GLuint name);

  GlObject() = default;
  GlObject(GLuint name, Deleter deleter);
  ~GlObject();
  GlObject(GlObject&& other) noexcept;
  GlObject& operator=(GlObject&& other) noexcept;

  GLuint Name() const { return name_; }
  explicit operator bool() const { return name_ != 0; }

 private:
  void Reset();

  GLuint name_ = 0;
  Deleter deleter_ = nullptr;
  const void* context_ = nullptr;
};

GlObject MakeBuffer();
GlObject MakeVertexArray();
GlObject MakeTexture();
GlObject MakeRenderbuffer();
GlObject MakeFramebuffer();
GlObject MakeShader(GLenum stage);
GlObject MakeProgram();
GlObject MakeQuery();

// Replaces the buffer's content, and lets the driver discard the old one.
template <typename Container>
void UploadBuffer(const GlObject& buffer, GLenum target, const Container& data, GLenum usage) {
  glBindBuffer(target, buffer.Name());
  glBufferData(target,
               static_cast<GLsizeiptr>(data.size() * sizeof(typename Container::value_type)),
               data.data(),
               usage);
}

}  // namespace pleinair
